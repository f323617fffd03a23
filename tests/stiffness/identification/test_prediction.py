"""Predicted readings: derivatives against differences, the state that goes in and out, agreement with other code."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects import BASE
from stiffness.identification.observations import SessionObservations
from stiffness.identification.predicted_readings import PredictedReadings, SessionState
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.readings import equilibrium_kernel
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import Unknowns
from stiffness.session.session import Session
from stiffness.statics.predictor import Predictor
from tests.stiffness import arms
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]
# effects that fill every slot, away from zero, and with memory of both kinds
AWAY = {
    "backlash": {"gap_rad": 4e-5, "breakaway_nm": 3.0},
    "joint-friction": {"friction_nm": 4.0, "held": 0.7},
    "kinematic-offset": {"zero_rad": 2e-4, "x_m": 1e-4},
    "payload": {"mass_kg": 1.5},
    "base-compliance": {},
    "tracker-drift": {},
    "force-sensor-bias": {},
}


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return many_sided.session(tmp_path_factory.mktemp("many"), setups=3)


def predictor(session: Session, *names: str) -> SessionPredictor:
    layout, fixed = many_sided.free(*names)
    for name in names:
        for p in next(e for e in layout.effects if e.name == name).parameters:
            start = AWAY[name].get(p.name, 0.3 * p.scale if p.neutral is not None and p.fit != "inverse" else None)
            if start is not None:
                sign = np.where(np.arange(len(fixed[name][p.name])) % 2, -1.0, 1.0) if p.low < 0 else 1.0
                fixed[name][p.name] = np.clip(start * sign * np.ones_like(fixed[name][p.name]), p.low, p.high)
    return SessionPredictor.of(SessionData.of(session), layout, fixed)


def settled(of: SessionPredictor, p: Floats, own: Floats, start: SessionState | None = None) -> PredictedReadings:
    """From a state, or from the first, until the iteration stands still."""
    seen = of.predict(of.first_state() if start is None else start, p, own)
    for _ in range(4):
        seen = of.predict(seen.state, p, own)
    return seen


@pytest.mark.parametrize(
    "names",
    [
        (),
        ("backlash",),
        ("joint-friction",),
        ("kinematic-offset",),
        ("payload", "force-sensor-bias"),
        ("base-compliance", "tracker-drift"),
    ],
    ids=lambda names: " ".join(names) or "springs",
)
def test_derivatives_by_all_numbers_are_those_of_differences(session: Session, names: tuple[str, ...]) -> None:
    of = predictor(session, *names)
    layout = of.unknowns
    p = layout.start(of.fixed)
    own = 0.01 * np.random.default_rng(2).normal(size=of.data.station.size)
    own[:12] = 0.0  # rotations of trackers count from their pose
    own[18:] = 0.0
    here = settled(of, p, own)
    size = np.abs(here.by_parameter).max(axis=(0, 1))
    assert np.all(size > 0)
    for k, u in enumerate(layout.free):
        step = 1e-4 * np.maximum(np.abs(p[k]), 0.03 * u.scale) * (np.arange(len(p)) == k)
        up, down = (settled(of, p + s, own, here.state).position for s in (step, -step))
        slope = (up - down) / (2 * step[k])
        error = np.abs(here.by_parameter[:, :, k] - slope)
        # a flank that switches within the step is seen by the difference alone: almost all readings have none
        assert np.quantile(error.max(axis=1), 0.95) < 2e-3 * size[k] + 1e-9 / abs(step[k]), str(u)
    for k in range(len(own)):
        step = 1e-6 * (np.arange(len(own)) == k)
        up, down = (of.predict(here.state, p, own + s).position for s in (step, -step))
        assert here.by_station[:, :, k] == pytest.approx((up - down) / 2e-6, abs=2e-5)


def test_derivatives_by_the_wrench_are_those_of_differences(session: Session) -> None:
    of = predictor(session)
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    here = settled(of, p, own)
    loaded = np.flatnonzero(np.abs(of.data.wrench).max(axis=1) > 0)
    assert len(loaded) > 10
    for k in range(6):
        step = (1.0 if k < 3 else 0.1) * (np.arange(6) == k)
        up, down = (
            settled(replace(of, data=replace(of.data, wrench=of.data.wrench + s)), p, own, here.state).position
            for s in (step, -step)
        )
        slope = (up - down) / (2 * step[k])
        assert here.by_wrench[:, :, k] == pytest.approx(slope, abs=1e-3 * np.abs(slope).max())


def test_rotations_back_turn_the_base_into_the_readings_axes(session: Session) -> None:
    of = predictor(session)
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    here = of.predict(of.first_state(), p, own)
    poses = here.state.poses
    assert poses is not None
    which = np.searchsorted(of.data.station.blocks, session.samples.block)
    assert here.back == pytest.approx(np.swapaxes(poses.rotation[which], 1, 2), abs=1e-14)
    assert np.median(np.linalg.norm(here.position - session.samples.position, axis=1)) < 5e-3


def test_the_state_that_goes_in_is_left_alone(session: Session) -> None:
    of = predictor(session, "backlash")
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    first = of.first_state()
    before = first.x.copy(), first.torque.copy(), first.used.copy()
    after = of.predict(first, p, own).state
    assert all(np.array_equal(a, b) for a, b in zip(before, (first.x, first.torque, first.used), strict=True))
    assert first.poses is None and after.poses is not None
    assert np.abs(after.x).max() > 1e-5 and np.abs(after.torque).max() > 1
    # the same state and numbers give the same bits, however often
    again = of.predict(first, p, own)
    assert np.array_equal(again.position, of.predict(first, p, own).position)
    assert of.predict(after, p, own).state.poses is after.poses
    assert of.predict(after, p, own).state.used is after.used


def test_the_iteration_closes_in_on_the_equilibrium(session: Session) -> None:
    """A thousandth and less is left from one prediction to the next; where it ends does not depend on the start."""
    of = predictor(session, "backlash")
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    end = settled(of, p, own)
    seen, off = of.predict(of.first_state(), p, own), []
    for _ in range(3):
        off.append(np.abs(seen.x - end.x).max())
        seen = of.predict(seen.state, p, own)
    assert off[0] < 1e-3 * np.abs(end.x).max()
    assert off[1] < 1e-3 * off[0] + 1e-15
    far = replace(of.first_state(), x=np.full_like(end.x, 1e-2))
    assert settled(of, p, own, far).position == pytest.approx(end.position, abs=1e-12)


def test_readings_are_those_of_the_predictor_of_paths(session: Session) -> None:
    """Loads on the flange, as a path has them: the same arm, asked by other code."""
    of = predictor(session)
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    seen = settled(of, p, own)
    held = session.tool.tool()
    other = Predictor(session.robot, of.unknowns.effects, of.fixed, held, gravity=arms.GRAVITY)
    s = session.samples
    tcp = [r.name for r in session.reflectors].index("tcp")
    rows = np.flatnonzero((s.reflector == tcp) & (s.load.link == 6) & (s.payload == 0))
    assert len(rows) > 10
    turns = other.nominal(s.q[rows]).rotation
    for nominal, row in zip(turns, rows, strict=True):
        turn, shown = nominal, of.data.wrench[row]  # in the axes of the tool as it stands
        for _ in range(4):
            acting = np.concatenate([turn @ shown[:3], turn @ shown[3:]])[None]
            tip = other.forward(s.q[row][None], acting, np.zeros((1, 0)))
            turn = tip.rotation[0]
        expected = seen.back[row] @ (tip.position[0] - _origin(seen, of, row))
        assert seen.position[row] == pytest.approx(expected, abs=1e-10)


def _origin(seen: PredictedReadings, of: SessionPredictor, row: int) -> Floats:
    poses = seen.state.poses
    assert poses is not None
    return poses.origin[int(np.searchsorted(of.data.station.blocks, of.data.samples.block[row]))]


def test_numbers_of_the_memory_alone_need_no_new_kernels(session: Session) -> None:
    """A breakaway torque only decides flanks: replaced in a predictor it gives what a predictor built with it gives."""
    of = predictor(session, "backlash")
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    torque = np.array([1e3, 0.0, 5.0, 1.0, 2.0, 0.5])
    fixed = {**of.fixed, "backlash": {**of.fixed["backlash"], "breakaway_nm": torque}}
    replaced, built = of.with_memory_values(fixed), SessionPredictor.of(of.data, of.unknowns, fixed)
    assert replaced.model is of.model
    a, b = settled(replaced, p, own), settled(built, p, own)
    assert np.array_equal(a.position, b.position)
    assert np.abs(a.position - settled(of, p, own).position).max() > 1e-6


def test_other_joint_states_take_one_step(session: Session) -> None:
    """Arms that settled with other flanks, moved by one step: as if they had settled anew, slopes included."""
    of = predictor(session, "backlash")
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    torque = np.array([0.0, 0.0, 5.0, 1.0, 2.0, 0.5])
    other = of.with_memory_values({**of.fixed, "backlash": {**of.fixed["backlash"], "breakaway_nm": torque}})
    before, scale = settled(of, p, own), of.unknowns.scale
    near = other.predict_near(before.state, p, own)
    anew = settled(other, p, own, before.state)
    moved = np.abs(anew.position - before.position).max()
    assert moved > 1e-5
    assert np.abs(near.position - anew.position).max() < 1e-3 * moved
    changed = np.abs((anew.by_parameter - before.by_parameter) * scale).max()  # m per typical size
    assert np.abs((near.by_parameter - anew.by_parameter) * scale).max() < 0.01 * changed


def test_observations_take_their_numbers_out_of_the_whole_vector(session: Session) -> None:
    layout, fixed = many_sided.free()
    observations: SessionObservations = many_sided.observed(session, layout, fixed)
    own = 0.01 * np.random.default_rng(5).normal(size=21)
    vector = np.concatenate([layout.start(fixed), np.full(7, np.nan), own])
    direct = observations.predictor.predict(observations.first_state(), vector[:6], own)
    placed = observations.predict(observations.first_state(), vector, slice(13, 34))
    assert np.array_equal(placed.position, direct.position)
    blocks, state = observations.blocks(observations.first_state(), vector, slice(13, 34))
    assert blocks[0].jacobian.shape[1] == 34
    assert np.array_equal(state.x, direct.x)
    assert observations.own_sd.shape == (21,)


def test_a_sensor_that_shows_only_noise_shows_nothing(session: Session) -> None:
    data, sensor = SessionData.of(session), session.instruments
    raw, kept = session.samples.load.wrench, data.wrench
    sd = np.array([sensor.force] * 3 + [sensor.torque] * 3)
    quiet = np.all(np.abs(raw) <= 4 * sd, axis=1)
    assert quiet.any() and not quiet.all()
    assert np.any(raw[quiet] != 0) and np.all(kept[quiet] == 0)
    assert np.array_equal(kept[~quiet], raw[~quiet])


def test_readings_that_share_load_and_posture_are_one_case(session: Session) -> None:
    data = SessionData.of(session)
    loads = data.loads(data.station.reflectors(np.zeros(21)), np.zeros((len(session), 0)))
    first, of = data.cases(loads)
    s = session.samples
    assert len(first) < len(session) / 3
    table = loads.table()
    assert np.array_equal(table[first][of], table)
    assert len(np.unique(of)) == len(first)
    assert np.array_equal(s.setup, s.setup[first][of])
    assert sum(int(rows.sum()) for rows in data.kinds.values()) == len(session)
    assert {k.link for k in data.kinds} == {3, 6}


def test_time_counts_from_the_first_reading_and_warmth_from_the_reference(session: Session) -> None:
    data, s = SessionData.of(session), session.samples
    assert data.time[:, 0] == pytest.approx(s.time - s.time.min())
    assert data.warm[:, 0] == pytest.approx(s.temperature - 20.0)
    assert np.ptp(data.warm) > 0.1
    assert BASE.name == "joint-stiffness"


def test_fits_of_one_set_of_effects_share_what_is_built(session: Session) -> None:
    """Which numbers are free, and where they start, makes no difference to the kernels; what is given does."""
    of = predictor(session, "backlash", "kinematic-offset")
    few = Unknowns(of.unknowns.effects, of.unknowns.joints, of.unknowns.free[:3])
    other = SessionPredictor.of(of.data, few, of.fixed)
    kind = next(iter(of.data.kinds))
    assert equilibrium_kernel(of.model.sweep, kind) is equilibrium_kernel(other.model.sweep, kind)
    p, own = of.unknowns.start(of.fixed), np.zeros(of.data.station.size)
    a, b = settled(of, p, own), settled(other, p[:3], own)
    np.testing.assert_allclose(b.position, a.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(b.by_parameter, a.by_parameter[:, :, :3], rtol=1e-9, atol=1e-15)
