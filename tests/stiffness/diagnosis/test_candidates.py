"""Candidates: trials of shapes by hand, columns of every effect, and where a fit of a term begins."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.candidates import Column, Term, blends, columns_of, excludes, started, trials, whole_turn
from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.identification.unknowns import numbers_of

Floats = npt.NDArray[np.float64]
TORQUE = np.array([10.0, 200.0, 80.0, 20.0, 5.0, 0.0])
ADDED = [e for e in CATALOGUE if not e.is_base]


def test_flanks_and_breakaway_torques_exclude_each_other() -> None:
    found = trials(BY_NAME["backlash"], 6, TORQUE)
    breakaway, side = (p for p in BY_NAME["backlash"].parameters if p.trials)
    assert excludes(breakaway) and excludes(side)
    assert [t.choice for t in found] == list(range(len(breakaway.trials) * len(side.trials)))
    pairs = {(float(t.values["breakaway_nm"][1]), float(t.values["side"][1])) for t in found}
    assert pairs == {(share * 200.0, s) for share in breakaway.trials for s in side.trials}
    for t in found:
        assert np.all(t.values["gap_rad"] == 0)  # without effect
        share = t.values["breakaway_nm"][1] / 200.0
        assert t.values["breakaway_nm"][0] == pytest.approx(share * 10.0)
        assert t.values["breakaway_nm"][5] == pytest.approx(share * 1e-3)  # a joint without torque


def test_angles_stand_side_by_side() -> None:
    effect = BY_NAME["posture-stiffness"]
    shape = next(p for p in effect.parameters if blends(p))
    found = trials(effect, 6, TORQUE)
    plain = [t for t in found if t.choice == 0]
    angles = [tuple(t.values[shape.name]) for t in plain]
    assert len(set(angles)) == len(plain) == 1 + sum(not np.all(shape.start == t) for t in shape.trials)
    assert whole_turn(shape)


@pytest.mark.parametrize("effect", ADDED, ids=lambda e: e.name)
def test_terms_have_the_numbers_of_their_site_in_every_trial(effect: Effect) -> None:
    columns, terms = columns_of([effect], 6, TORQUE)
    count = len(trials(effect, 6, TORQUE))
    assert {t.site for t in terms} == set(effect.sites(6))
    for term in terms:
        mine = [columns[k] for k in term.columns]
        runs = {c.run for c in mine}
        assert all(trials(effect, 6, TORQUE)[r].choice == term.choice for r in runs)
        scaled = {u for u in numbers_of(effect, term.site, 6, term.extras) if u.parameter.neutral is not None}
        assert {c.number for c in mine} == scaled
        core = [c for c in mine if not c.number.parameter.extra]
        assert len(core) == len({c.number for c in core}) * len(runs)
        for c, positive in zip(mine, term.positive, strict=True):
            p = c.number.parameter
            assert positive == (p.neutral == (p.high if p.fit == "inverse" else p.low))
    keys = [(t.key, t.choice, t.extras) for t in terms]
    assert len(set(keys)) == len(keys)
    assert max(c.run for c in columns) < count


def test_effects_stand_one_after_the_other() -> None:
    some = [BY_NAME[n] for n in ("payload", "base-compliance", "backlash")]
    columns, terms = columns_of(some, 6, TORQUE)
    each = [columns_of([e], 6, TORQUE) for e in some]
    assert len(columns) == sum(len(c) for c, _ in each)
    assert [t.key for t in terms] == [t.key for _, ts in each for t in ts]
    used = sorted(k for t in terms for k in t.columns)
    assert set(used) == set(range(len(columns)))


def weighted(effect: Effect, of: str, weight: Floats | None = None) -> tuple[Term, list[Column], dict[str, Floats]]:
    columns, terms = columns_of([effect], 6, TORQUE)
    term = next(t for t in terms if of in t.site.where and not t.extras)
    found = np.ones(len(term.columns)) if weight is None else weight
    return term, columns, started(term, columns, found, 6)


def test_weights_are_where_the_numbers_begin() -> None:
    _, _, begun = weighted(BY_NAME["backlash"], "joint-3", np.array([7e-5]))
    assert begun["gap_rad"].tolist() == [0, 0, 7e-5, 0, 0, 0]


def test_a_weight_of_an_inverse_begins_as_its_value() -> None:
    _, _, begun = weighted(BY_NAME["preload-softening"], "joint-2", np.array([0.25]))
    assert begun["ratio"] == pytest.approx([1, 1 / 1.25, 1, 1, 1, 1])


def test_what_lies_outside_its_bounds_begins_on_them() -> None:
    _, _, begun = weighted(BY_NAME["backlash"], "joint-1", np.array([3.0]))
    assert begun["gap_rad"][0] == 0.05


def test_a_blended_angle_is_the_mean_of_its_trials_by_weight() -> None:
    effect = BY_NAME["posture-stiffness"]
    shape = next(p for p in effect.parameters if blends(p))
    term, columns, _ = weighted(effect, "joint-2")
    values = np.array([columns[k].trial.values[shape.name][1] for k in term.columns])
    one = int(np.argmax(values))
    weight = np.where(np.arange(len(values)) == one, 0.7, 0.0)
    _, _, begun = weighted(effect, "joint-2", weight)
    assert np.cos(begun[shape.name][1] - values[one]) == pytest.approx(1, abs=1e-9)
    two = np.argsort(values)[-2:]
    weight = np.where(np.isin(np.arange(len(values)), two), 0.5, 0.0)
    _, _, begun = weighted(effect, "joint-2", weight)
    middle = np.arctan2(np.sin(values[two]).sum(), np.cos(values[two]).sum())
    assert np.cos(begun[shape.name][1] - middle) == pytest.approx(1, abs=1e-9)
    scale = next(p for p in effect.parameters if p.neutral is not None and not p.extra)
    assert begun[scale.name][1] == pytest.approx(1.0)
