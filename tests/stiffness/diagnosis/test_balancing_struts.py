"""Struts that balance joint 2, whose laws are not the catalogue's: a cylinder of gas, a spring with initial tension."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, ModelFits
from stiffness.diagnosis.alternatives import with_alternatives
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.result import Diagnosis
from stiffness.diagnosis.search import Search
from stiffness.diagnosis.twin_start import like_its_twin
from stiffness.effects import BASE, BY_NAME
from stiffness.effects.joint_angle_error import HARMONICS
from stiffness.identification.evaluate import evaluate
from stiffness.identify import identify
from stiffness.session.session import Session
from tests.stiffness.diagnosis.test_encoder_wobble import STIFFNESS, measured

INNER, OUTER, SIDE = 0.2, 0.55, -1.7  # m, m, rad: pins about the axis of joint 2, and where both lie on one side
REACH = (-1.4, 1.3)  # rad, as of arms that have a strut
SPRING, STRUT, ENCODER = BASE.name, BY_NAME["gravity-compensator"], BY_NAME["joint-angle-error"]
Law = Callable[[float], float]


def length(q: float) -> float:
    inner = INNER * np.array([np.cos(SIDE), np.sin(SIDE)])
    return float(np.linalg.norm(OUTER * np.array([np.cos(q), np.sin(q)]) - inner))


def gas(stretch: float) -> float:
    """J of a polytropic cylinder that is drawn out: its force rises from 1 as (1 - 0.9 stretch) to the power -1.2."""
    return float(((1 - 0.9 * stretch) ** -0.2 - 1) / (0.2 * 0.9))


def wound(stretch: float) -> float:
    """J of a spring that was wound with two thirds of a metre of initial tension."""
    return 0.5 * (stretch + 0.67) ** 2


def deflection(energy: Law, size: float) -> Law:
    """rad that joint 2 gives way to the slope of an energy."""

    def turned(q: float) -> float:
        h = 1e-5
        return -size * (energy(length(q + h) - 0.36) - energy(length(q - h) - 0.36)) / (2 * h)

    return turned


@pytest.mark.parametrize(("energy", "size"), [(gas, 4e-3), (gas, 2e-2), (wound, 4e-3)])
def test_a_strut_is_named_whatever_its_law(energy: Law, size: float) -> None:
    """With the encoder that no reading at rest tells from it, or alone where it turns farther than an encoder errs."""
    session = measured(deflection(energy, size), 2, 36, 1, REACH)
    found = diagnose([session], identify([session]).model("ur10", {}))
    assert found.verdict == "explained"
    (added,) = found.added
    assert added.where == ("joint-2",)
    assert {added.effect, *added.confused_with} == {STRUT.name, ENCODER.name}
    score = found.scores["absolute"]
    assert score is not None and score.before.rms > 1.5 * score.before.noise_floor
    assert score.after.rms < 1.25 * score.after.noise_floor
    assert own_error(session, found) < 1.05


def own_error(session: Session, found: Diagnosis) -> float:
    """Over the noise, of the model that is written, on the session that it was judged on."""
    own = evaluate(session, found.model).absolute
    assert own is not None
    return own.rms / own.noise_floor


def test_a_strut_that_turns_farther_than_an_encoder_errs_is_named_alone() -> None:
    """Ten mrad."""
    size = 6e-2
    session = measured(deflection(wound, size), 2, 36, 1, REACH)
    found = diagnose([session], identify([session]).model("ur10", {}))
    (added,) = found.added
    assert (found.verdict, added.effect, added.confused_with) == ("explained", STRUT.name, ())
    score = found.scores["absolute"]
    assert score is not None and score.before.rms > 20 * score.before.noise_floor
    assert score.after.rms < 1.25 * score.after.noise_floor
    assert own_error(session, found) < 1.05


def test_a_strut_begins_where_it_turns_the_joint_as_the_encoder_does() -> None:
    """From harmonics that were fitted to the motion of a strut that strut comes back, but for an offset."""
    session = measured(lambda q: 0.0, 2, 36, 1, REACH)
    fits = ModelFits.of([session], [BASE], {SPRING: {"k_nm_per_rad": STIFFNESS}}, [np.ones(len(session), dtype=bool)])
    q = session.samples.q[:, 1]
    wanted = np.array([deflection(wound, 2e-3)(a) for a in q])
    waves = np.column_stack([*(f(k * q) for k in (1, 2) for f in (np.cos, np.sin)), np.ones(len(q))])
    own, *_ = np.linalg.lstsq(waves, wanted, rcond=None)
    values = ENCODER.neutral(6)
    for name, value in zip(HARMONICS, own, strict=False):
        values[name][1] = value
    encoder = Addition(ENCODER, (ENCODER.sites(6)[1],), frozenset(), values, held=True)
    fit = fits.fit([encoder])
    begun, *others = like_its_twin(fit, encoder, STRUT)
    assert (begun.effect, begun.where) == (STRUT, ("joint-2",)) and len(others) < 4
    m, side, relaxed, e = (float(begun.values[p.name][0]) for p in STRUT.parameters)
    k = fit.values()[SPRING]["k_nm_per_rad"][1]
    turned = -m / k * np.sin(q - side) * (1 - relaxed / np.sqrt(1 - e * np.cos(q - side)))
    assert np.std(turned - wanted) < 0.03 * np.std(wanted)
    assert like_its_twin(fit, encoder, BY_NAME["payload"]) == []


def test_a_strut_is_tried_where_encoders_of_several_joints_stand_for_it() -> None:
    """Waves of wrist joints take up what those of joint 2 leave of its law; all of them give way to it."""
    session = measured(deflection(wound, 2e-2), 2, 36, 1, REACH)
    fits = ModelFits.of([session], [BASE], {SPRING: {"k_nm_per_rad": STIFFNESS}}, [np.ones(len(session), dtype=bool)])
    sites = tuple(ENCODER.sites(6)[k] for k in (1, 3, 4))
    base, several = fits.fit([]), Addition(ENCODER, sites, frozenset(), ENCODER.neutral(6))
    search = Search(fits, (), lambda text: None)
    _, stands, found = with_alternatives(search, fits.fit([several], base), [several], base)
    assert [(a.effect, a.where) for a in stands] == [(STRUT, ("joint-2",))]
    assert [r.addition.effect for r in found] == [STRUT]
