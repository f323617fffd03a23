"""An encoder off its axis, on the independent plant: found by harmonics, by a table only where these do not hold."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.added_effects import Addition, ModelFits, as_addition, enriched
from stiffness.diagnosis.adoption import richest, with_richer_forms
from stiffness.diagnosis.candidates import columns_of
from stiffness.diagnosis.search import Search
from stiffness.effects import BASE, BY_NAME
from stiffness.effects.joint_angle_error import HARMONICS, KNOTS
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import numbers_of
from stiffness.model.model import load_model, model_text
from stiffness.session.session import Session, load_session
from tests.contracts.test_effects_files import model_of
from tests.plant import Arm, lab
from tests.plant.lab_design import random_setups
from tests.plant.wear import Situation, Wear
from tests.plant.worn_plant import WornPlant
from tests.stiffness import session_desk

Floats = npt.NDArray[np.float64]
EFFECT = BY_NAME["joint-angle-error"]
STIFFNESS = np.array([5e4, 5e4, 3e4, 1e4, 1e4, 8e3])
NOISE = lab.Noise(1.5e-5, 0.2, 0.02)
Law = Callable[[float], float]


def measured(law: Law, joint: int, count: int, directions: int, reach: tuple[float, float] | None = None) -> Session:
    """So many set-ups of an arm whose joint errs by a law of its commanded angle; ``reach``: rad, of that joint."""
    arm = Arm.load(session_desk.ROBOT, tool=session_desk.TOOL)
    if reach is not None:
        arm.lower[joint - 1], arm.upper[joint - 1] = reach

    def wrong(at: Situation) -> Floats:
        return np.where(np.arange(6) == joint - 1, law(float(at.command[joint - 1])), 0.0)

    wear = Wear(STIFFNESS, np.ones(6), np.zeros(6), np.zeros(6), laws=(wrong,))
    narrow = Arm.load(session_desk.ROBOT, tool=session_desk.TOOL)
    narrow.lower[2], narrow.upper[2] = -1.0, 1.0  # a third of the knots
    plan = random_setups(narrow if directions == 0 else arm, count, 7, force=60.0, directions=directions, levels=(1.0,))
    notes = lab.measure(WornPlant(arm, wear), plan, session_desk.TARGETS[:2], noise=NOISE, seed=9)
    return load_session(notes.write(Path(mkdtemp(prefix="wobble")), "ur10"))


def searched(session: Session) -> tuple[ModelFits, Fit, list[Addition]]:
    """What a search adds to springs."""
    values = {BASE.name: {"k_nm_per_rad": STIFFNESS}}
    fits = ModelFits.of([session], [BASE], values, [np.ones(len(session), dtype=bool)])
    search = Search(fits, (), lambda text: None)
    linear = search.linearisation.at(fits.fit([]), [])
    fit, additions = search.run(linear.expansion, search.beginnings(linear))
    return fits, fit, additions


@cache
def eccentric() -> tuple[ModelFits, Fit, list[Addition]]:
    """0.3 mrad once and 0.15 mrad twice a turn in joint 5, 36 set-ups."""
    return searched(measured(lambda q: 3e-4 * np.sin(q + 0.8) + 1.5e-4 * np.cos(2 * q - 0.5), 5, 36, 1))


def test_an_eccentric_encoder_is_found_alone_with_its_four_numbers() -> None:
    _, fit, additions = eccentric()
    assert [(a.effect.name, a.where, a.extras) for a in additions] == [(EFFECT.name, ("joint-5",), frozenset())]
    truth = 1e-4 * np.array([3 * np.sin(0.8), 3 * np.cos(0.8), 1.5 * np.cos(0.5), 1.5 * np.sin(0.5)])
    value, sd = (np.array([d[EFFECT.name][k][4] for k in HARMONICS]) for d in (fit.values(), fit.deviations()))
    assert sd.max() < 2.5e-5 < np.abs(truth).min()
    assert np.abs((value - truth) / sd).max() < 3
    assert fit.solution.misfit < 1.1


def test_few_setups_free_no_table() -> None:
    fits, _, additions = eccentric()
    assert fits.setups < KNOTS and richest(fits, additions) == additions
    for setups, forms in ((KNOTS - 1, [False]), (KNOTS, [False, True])):
        columns, terms = columns_of([EFFECT], 6, np.ones(6), setups)
        assert [(t.site.where, t.extras) for t in terms] == [((f"joint-{k}",), f) for k in range(1, 7) for f in forms]
        assert [t.tabled for t in terms] == [t.extras for t in terms]
        for t in terms:
            names = {columns[k].number.parameter.name for k in t.columns}
            assert names == ({"error_rad"} if t.extras else set(HARMONICS))


def test_nothing_is_added_to_a_clean_arm() -> None:
    assert searched(measured(lambda q: 0.0, 5, 36, 1))[2] == []


def test_a_table_is_found_where_the_law_is_no_harmonic() -> None:
    """Waves of 30 deg; 0.3 mrad once a turn in as many set-ups needs none."""
    _, _, (found,) = searched(measured(lambda q: 3e-4 * np.sin(12 * q), 3, 150, 0))
    assert (found.effect, found.where, found.extras) == (EFFECT, ("joint-3",), frozenset(found.sites))
    knots = np.radians(-180 + 3.0 * np.arange(KNOTS))
    table = found.values["error_rad"][2 * KNOTS : 3 * KNOTS]
    seen = table != 0
    assert seen.sum() > 25 and np.corrcoef(table[seen], np.sin(12 * knots[seen]))[0, 1] > 0.9
    assert not any(found.values[k].any() for k in HARMONICS)
    fits, fit, more = searched(measured(lambda q: 3e-4 * np.sin(q), 3, 150, 0))
    more, _ = with_richer_forms(fits, more, fit)
    assert [(a.effect, a.where, a.extras) for a in more] == [(EFFECT, ("joint-3",), frozenset())]
    assert more[0].values["sin1_rad"][2] == pytest.approx(3e-4, rel=0.1)


def test_a_table_begins_as_the_harmonics_that_it_replaces() -> None:
    values = EFFECT.neutral(6)
    for k, name in enumerate(HARMONICS):
        values[name][3] = 1e-4 * (k + 1)
    plain = as_addition(EFFECT, values, 6)
    assert plain is not None and not plain.extras and len(plain.numbers(6)) == 4
    (site,) = plain.sites
    rich = enriched(plain, site, 6)
    table = rich.values["error_rad"].reshape(6, KNOTS)
    assert table[3, 60] == pytest.approx(4e-4) and table[3, 90] == pytest.approx(2e-4 - 3e-4)  # 0 and 90 deg
    assert not np.delete(table, 3, axis=0).any() and not any(rich.values[k].any() for k in HARMONICS)
    assert {u.parameter.name for u in rich.numbers(6)} == {"error_rad"} and len(rich.numbers(6)) == KNOTS
    assert len(numbers_of(EFFECT, site, 6, True)) == KNOTS


def test_harmonics_leave_open_what_their_deviations_say() -> None:
    """At all angles; of a joint with a table, knots that nobody saw are open by the table's spread."""
    values, q = EFFECT.neutral(2), np.radians([[30.0, 30.0], [120.0, 120.0]])
    values["sin2_rad"][:] = 2e-4
    values["error_rad"][KNOTS + 70] = 1e-4  # joint 2 at 30 deg
    sd = {"sin1_rad": np.array([3e-5, 0.0]), "cos2_rad": np.array([4e-5, 0.0])}
    sd |= {"error_rad": np.full(2 * KNOTS, 1e-5), "cos1_rad": np.zeros(2), "sin2_rad": np.zeros(2)}
    assert EFFECT.angle_sd is not None
    got = EFFECT.angle_sd(q, values, sd)
    first = [np.hypot(3e-5 * np.sin(a), 4e-5 * np.cos(2 * a)) for a in np.radians([30.0, 120.0])]
    np.testing.assert_allclose(got, [[first[0], 1e-5], [first[1], 5e-4]], rtol=1e-9)


def test_joints_without_any_error_are_not_open() -> None:
    """Of a model without a table: an eccentric encoder in joint 2 says nothing of joint 1."""
    values, q = EFFECT.neutral(2), np.radians([[30.0, 30.0]])
    values["sin2_rad"][1] = 2e-4
    assert EFFECT.angle_sd is not None
    got = EFFECT.angle_sd(q, values, {"sin2_rad": np.array([0.0, 4e-5])})
    np.testing.assert_allclose(got, [[0.0, 4e-5 * np.sin(np.radians(60.0))]], rtol=1e-9)


def test_a_file_of_harmonics_has_no_table_and_a_file_of_a_table_no_harmonics(tmp_path: Path) -> None:
    values = EFFECT.neutral(6)
    values["cos1_rad"][1] = 2.5e-4
    path, old = tmp_path / "model.toml", tmp_path / "old.toml"
    path.write_text(model_text(model_of(EFFECT, values)), encoding="utf-8")
    assert "error_rad" not in path.read_text(encoding="utf-8")
    back = load_model(path).values[EFFECT.name]
    assert back["cos1_rad"][1] == 2.5e-4 and back["error_rad"].shape == (720,) and not back["error_rad"].any()
    values = EFFECT.neutral(6)
    values["error_rad"][7] = 3e-4
    new = ("cos", "sin", "sd_cos", "sd_sin")
    lines = [t for t in model_text(model_of(EFFECT, values)).splitlines() if not t.startswith(new)]
    old.write_text("\n".join(lines), encoding="utf-8")
    assert "cos1" not in old.read_text(encoding="utf-8")
    again = load_model(old).values[EFFECT.name]
    assert again["error_rad"][7] == 3e-4 and again.keys() == values.keys() and not again["sin2_rad"].any()
