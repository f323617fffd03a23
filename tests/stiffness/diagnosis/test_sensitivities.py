"""Sensitivities: derivatives by numbers that a fit does not have, against differences of the whole statics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.added_effects import ModelFits
from stiffness.diagnosis.candidates import trials
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects import BASE, BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.session_fit import SessionFit
from stiffness.identification.unknowns import Unknown, Unknowns, numbers_of
from tests.stiffness.diagnosis.sick import sick
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]
ADDED = [e for e in CATALOGUE if not e.is_base]
FRICTION = BY_NAME["joint-friction"]
SHOWN = [e for e in ADDED if e.scope != "process"]  # no session shows a process
ORDINARY = [e for e in SHOWN if not e.angle and e is not FRICTION]


@pytest.fixture(scope="module")
def fit() -> SessionFit:
    """Springs alone, on a session with time, temperature, approaches and two levels of load."""
    whole = sick("clean")
    some = whole.session.take(whole.session.samples.setup <= 10)
    short = ModelFits.of([some], [BASE], whole.fits.values, [np.ones(len(some), dtype=bool)])
    return short.fit([]).sessions[0].further()


def numbers(effect: Effect) -> list[Unknown]:
    found = [u for s in effect.sites(6) for u in numbers_of(effect, s, 6, True) if u.parameter.neutral is not None]
    return found[:: max(1, -(-len(found) // 4))]


def on_trial(effect: Effect, fit: SessionFit) -> dict[str, dict[str, Floats]]:
    """Springs as fitted, the effect without effect, its shapes at their first trial."""
    torque = np.abs(fit.predicted.torque).max(axis=0)
    layout = fit.observations.predictor.unknowns
    fitted = layout.values(fit.vector[: len(layout)], fit.observations.predictor.fixed)
    out = {e.name: e.neutral(6) for e in CATALOGUE} | {BASE.name: fitted[BASE.name]}
    shaped = trials(effect, 6, torque)[-1].values
    return out | {effect.name: {k: np.array(v, dtype=float) for k, v in shaped.items()}}


def position(effect: Effect, fit: SessionFit, values: dict[str, dict[str, Floats]], u: Unknown, move: float) -> Floats:
    """(N, 3) readings with one number away from neutral, in the solver's units, at the joint memory of the fit's
    torques."""
    own = {k: v.copy() for k, v in values[effect.name].items()}
    now = own[u.parameter.name][u.index]
    own[u.parameter.name][u.index] = 1 / (1 / now + move) if u.inverse else now + move
    effects = tuple(e for e in CATALOGUE if e.is_base or e is effect)
    fixed: dict[str, Numbers] = {BASE.name: values[BASE.name], effect.name: own}
    predictor = SessionPredictor.of(fit.observations.data, Unknowns(effects, 6, ()), fixed)
    state = replace(predictor.first_state(), torque=fit.predicted.torque, poses=fit.state.poses)
    for _ in range(3):
        seen = predictor.predict(state, np.zeros(0), fit.own)
        state = replace(seen.state, torque=fit.predicted.torque)
    return seen.position


@pytest.mark.parametrize("effect", ORDINARY, ids=lambda e: e.name)
def test_derivatives_are_those_of_differences(fit: SessionFit, effect: Effect) -> None:
    """One-sided where a number cannot be negative. The posture's own answer, a percent or two, is left out."""
    mine = numbers(effect)
    found = Sensitivities(fit.observations.data, CATALOGUE, mine).of(fit, on_trial(effect, fit)).whole()
    values = on_trial(effect, fit)
    assert np.abs(found).max(axis=(0, 1)).astype(bool).sum() > 0.7 * len(mine)
    for k, u in enumerate(mine):
        p = u.parameter
        size = np.abs(found[:, :, k]).max()
        if size == 0:  # nothing loads it
            continue
        step = 2e-5 / size  # 20 micrometres
        lowest = p.neutral == (p.high if u.inverse else p.low)
        up = position(effect=effect, fit=fit, values=values, u=u, move=step)
        down = position(effect=effect, fit=fit, values=values, u=u, move=0.0 if lowest else -step)
        slope = (up - down) / (step if lowest else 2 * step)
        error = np.linalg.norm(found[:, :, k] - slope, axis=1)
        assert np.quantile(error, 0.9) < 0.04 * size, str(u)
        assert np.sum(found[:, :, k] * slope) / np.sum(slope**2) == pytest.approx(1, abs=0.04), str(u)


def test_some_readings_by_some_numbers_are_those_of_all(fit: SessionFit) -> None:
    """Numbers of a table and of other effects, of an instrument too, of readings in any order."""
    table = BY_NAME["joint-angle-error"]
    mine = [u for e in SHOWN if e is not FRICTION and e is not table for u in numbers(e)]
    mine += [u for s in table.sites(6) for extras in (False, True) for u in numbers_of(table, s, 6, extras)]
    values = {e.name: e.neutral(6) for e in CATALOGUE} | on_trial(BY_NAME["backlash"], fit)
    of = Sensitivities(fit.observations.data, CATALOGUE, mine)
    whole = of.of(fit, values).whole()
    rows = np.flatnonzero(np.arange(len(fit.samples)) % 3 == 1)[::-1]
    moved = np.flatnonzero(np.abs(whole[rows]).max(axis=(0, 1)) > 0)
    wanted = moved[1::2]
    assert len(rows) > 20 and {mine[k].effect for k in wanted} > {"joint-angle-error", "tracker-drift", "backlash"}
    some = of.of(fit, values, rows, wanted).whole()
    assert some.shape == (len(rows), 3, len(wanted))
    assert some == pytest.approx(whole[rows][:, :, wanted], rel=1e-12, abs=1e-13 * np.abs(whole).max())


@pytest.mark.parametrize("name", ["base-compliance", "payload", "tracker-drift"])
def test_readings_of_a_tracker_that_stands_anywhere(name: str, tmp_path: Path) -> None:
    """In its own axes, station by station, under ropes on an inner link as well."""
    session = many_sided.session(tmp_path, setups=4)
    values = {BASE.name: {"k_nm_per_rad": many_sided.STIFFNESS}}
    of = ModelFits.of([session], [BASE], values, [np.ones(len(session), dtype=bool)])
    placed = of.fit([]).sessions[0].further()
    effect = BY_NAME[name]
    mine = numbers(effect)
    given = on_trial(effect, placed)
    found = Sensitivities(placed.observations.data, CATALOGUE, mine).of(placed, given).whole()
    assert np.abs(placed.predicted.back - np.eye(3)).max() > 0.5
    for k, u in enumerate(mine):
        size = np.abs(found[:, :, k]).max()
        up, down = (position(effect=effect, fit=placed, values=given, u=u, move=s) for s in (2e-5 / size, 0.0))
        error = np.linalg.norm(found[:, :, k] - (up - down) / (2e-5 / size), axis=1)
        assert np.quantile(error, 0.9) < 0.04 * size, str(u)


def test_friction_holds_what_its_trial_remembers(fit: SessionFit) -> None:
    """What is held depends on how much can be held: the difference is that between the trial and none."""
    mine = [u for s in FRICTION.sites(6) for u in numbers_of(FRICTION, s, 6) if u.parameter.neutral is not None]
    values = on_trial(FRICTION, fit)
    found = Sensitivities(fit.observations.data, CATALOGUE, mine).of(fit, values).whole()
    for k, u in enumerate(mine):
        trial = values[FRICTION.name][u.parameter.name][u.index]
        assert trial > 0
        on, off = (position(effect=FRICTION, fit=fit, values=values, u=u, move=m) for m in (0.0, -trial))
        difference = on - off
        size = np.abs(difference).max()
        assert size > 2e-6
        error = np.linalg.norm(found[:, :, k] * trial - difference, axis=1)
        assert np.quantile(error, 0.9) < 0.04 * size, str(u)


@pytest.mark.parametrize("effect", [e for e in ADDED if e.angle], ids=lambda e: e.name)
def test_numbers_of_a_table_move_readings_by_way_of_their_joint(fit: SessionFit, effect: Effect) -> None:
    (p,) = (p for p in effect.parameters if p.each > 1)
    q = np.degrees(fit.samples.q[:: len(fit.samples) // 3])  # some postures, the knots beside them
    near = np.floor((q + 180) / 360 * p.each).astype(int) % p.each
    knots = [Unknown(effect.name, p, j * p.each + int(k)) for row in near for j, k in enumerate(row)]
    found = Sensitivities(fit.observations.data, CATALOGUE, knots).of(fit, on_trial(effect, fit)).whole()
    felt = [k for k in range(len(knots)) if np.abs(found[:, :, k]).max() > 0.01]
    assert len(felt) > 6
    for k in felt[::4]:
        values = on_trial(effect, fit)
        up, down = (position(effect=effect, fit=fit, values=values, u=knots[k], move=s) for s in (1e-5, -1e-5))
        assert found[:, :, k] == pytest.approx((up - down) / 2e-5, abs=0.03 * np.abs(found[:, :, k]).max())


def test_geometry_is_joints_and_places(fit: SessionFit) -> None:
    """A turn of a joint, and the six coordinates of every place: against frames that are moved by hand."""
    geometry = Sensitivities(fit.observations.data, CATALOGUE, numbers(ADDED[0])).geometry(fit)
    assert geometry.shape == (len(fit.samples), 3, 6 + 6 * 7)
    robot, s = fit.session.robot, fit.samples
    links = fit.observations.data.link
    for row in range(0, len(s), 37):
        chain = [np.eye(4)]
        for k in range(6):
            turn = np.eye(4)
            c, n = np.cos(s.q[row, k]), np.sin(s.q[row, k])
            x, y, z = robot.axis[k]
            turn[:3, :3] = c * np.eye(3) + n * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) + (1 - c) * np.outer(
                robot.axis[k], robot.axis[k]
            )
            chain.append(chain[-1] @ robot.before[k] @ turn @ robot.after[k])
        link = int(links[row])
        at = (chain[link] @ np.append(fit.reflectors[s.reflector[row]], 1.0))[:3]
        back = fit.predicted.back[row]
        inward = np.eye(4)
        for k in range(6):
            inward = chain[k] @ robot.before[k]
            axis, through = inward[:3, :3] @ robot.axis[k], inward[:3, 3]
            moved = np.cross(axis, at - through) if k < link else np.zeros(3)
            assert geometry[row, :, k] == pytest.approx(back @ moved, abs=2e-2)
        for k in range(7):
            for c in range(3):
                shift = chain[k][:3, c] if k <= link else np.zeros(3)
                turned = np.cross(chain[k][:3, c], at - chain[k][:3, 3]) if k <= link else np.zeros(3)
                assert geometry[row, :, 6 + 6 * k + c] == pytest.approx(back @ shift, abs=2e-2)
                assert geometry[row, :, 6 + 6 * k + 3 + c] == pytest.approx(back @ turned, abs=2e-2)


def test_effects_on_trial_do_not_bend_each_other(fit: SessionFit) -> None:
    """Asked alone or beside all others, a number has one derivative."""
    effect = next(e for e in ADDED if e.name == "base-compliance")
    mine = numbers(effect)
    alone = Sensitivities(fit.observations.data, (BASE, effect), mine).of(
        fit, {k: v for k, v in on_trial(effect, fit).items() if k in (BASE.name, effect.name)}
    ).whole()
    together = Sensitivities(fit.observations.data, CATALOGUE, mine).of(fit, on_trial(effect, fit)).whole()
    assert together == pytest.approx(alone, rel=1e-9, abs=1e-12 * np.abs(alone).max())
