"""Load histories: against a loop over the states of every set-up, joint by joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect, Numbers
from stiffness.identification.load_history import FAR, SMALLEST, LoadHistory, opened
from stiffness.session.session import Session
from tests.oracles.effects import ORACLES, Step
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]
REMEMBERING = {
    "backlash": {"gap_rad": [4e-5, 0.0, 6e-5, 1e-4, 2e-5, 8e-5], "breakaway_nm": [2.0, 0, 5, 1, 1e3, 0.5],
                 "side": [1, 1, -1, 1, 1, -1]},
    "joint-friction": {"friction_nm": [4.0, 8, 2, 1, 0.5, 0.0], "held": [0.8, 0.5, 1, 0.9, 0.7, 1],
                       "lag": [1.0, 0, 1, 1, 0, 1], "weight_half": [0.0, 0.5, 1, 2, 0, 0.3],
                       "weight_double": [0.0, 0, 0.7, 1, 0.4, 0], "weight_quarter": [0.0, 1, 0.2, 0, 0.6, 0.1]},
    "preload-softening": {"ratio": [0.7, 0.8, 0.9, 0.85, 0.75, 1.0]},
}  # fmt: skip


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return many_sided.session(tmp_path_factory.mktemp("many"), setups=7)


def values(name: str) -> tuple[tuple[Effect], dict[str, dict[str, Floats]]]:
    return (BY_NAME[name],), {name: {k: np.array(v, dtype=float) for k, v in REMEMBERING[name].items()}}


def torques(session: Session, seed: int) -> tuple[Floats, Floats]:
    """(N, n) of every reading, the same in one state, and (N, n) without load, the same in one set-up; a multiple of
    what changes flanks."""
    rng = np.random.default_rng(seed)
    states, s = session.states, session.samples
    every = rng.normal(scale=[6, 10, 6, 3, 2, 2], size=(len(states), 6))
    _, setup = np.unique(s.setup, return_inverse=True)
    return every[states.of], rng.normal(scale=3.0, size=(setup.max() + 1, 6))[setup]


def by_hand(session: Session, name: str, numbers: Numbers, torque: Floats, resting: Floats) -> Floats:
    """(N, 6 states) memory of every reading over its half range: the oracle's rule, one set-up after the other."""
    s, step = session.samples, ORACLES[name].step
    assert step is not None
    effect = BY_NAME[name]
    assert effect.memory is not None
    own = opened(effect, numbers)
    half = effect.memory.bounds(own)
    out = np.empty((len(s), len(half)))
    for setup in np.unique(s.setup):
        mine = np.flatnonzero(s.setup == setup)
        states = sorted({int(k) for k in s.state[mine]})
        first = mine[s.state[mine] == states[0]][0]
        for c in range(len(half)):
            number, j = divmod(c, 6)
            p = {k: float(v[j]) for k, v in own.items()}
            size = abs(s.step[first, j]) if np.isfinite(s.step[first, j]) else FAR
            rest = float(resting[first, j])
            state = step(0.0, Step(s.approach[first, j] * size, rest, rest, number=number), p)
            before = resting[first, j]
            for k in states:
                rows = mine[s.state[mine] == k]
                state = step(state, Step(0.0, torque[rows[0], j], before, number=number), p)
                before = torque[rows[0], j]
                out[rows, c] = state / half[c]
    return out


@pytest.mark.parametrize("name", list(REMEMBERING))
@pytest.mark.parametrize("seed", range(3))
def test_every_state_remembers_what_a_loop_over_the_states_gives(session: Session, name: str, seed: int) -> None:
    effects, numbers = values(name)
    torque, resting = torques(session, seed)
    found = LoadHistory(session).state(effects, numbers, torque, resting)
    expected = by_hand(session=session, name=name, numbers=numbers[name], torque=torque, resting=resting)
    assert found == pytest.approx(expected, abs=1e-6)  # operators of weight zero are opened to 1e-8
    assert np.abs(found).max() <= 1 + 1e-12
    assert len(np.unique(np.round(found, 6))) > 1


def test_rows_in_any_order_remember_the_same(session: Session) -> None:
    effects, numbers = values("backlash")
    torque, resting = torques(session, 5)
    order = np.random.default_rng(1).permutation(len(session))
    found = LoadHistory(session).state(effects, numbers, torque, resting)
    mixed = LoadHistory(session.take(order)).state(effects, numbers, torque[order], resting[order])
    assert np.array_equal(mixed, found[order])


def test_effects_stand_side_by_side(session: Session) -> None:
    both = BY_NAME["backlash"], BY_NAME["joint-friction"]
    numbers: Mapping[str, Numbers] = {e.name: values(e.name)[1][e.name] for e in both}
    torque, resting = torques(session, 2)
    history = LoadHistory(session)
    found = history.state(both, numbers, torque, resting)
    assert found.shape == (len(session), 6 + 24)
    for e, columns in zip(both, (slice(0, 6), slice(6, 30)), strict=True):
        alone = history.state((e,), {e.name: numbers[e.name]}, torque, resting)
        assert np.array_equal(found[:, columns], alone)
    assert history.state((BY_NAME["payload"],), {"payload": {"mass_kg": np.zeros(1)}}, torque, resting).shape[1] == 0


def test_an_approach_of_unknown_size_is_longer_than_any_gap(session: Session) -> None:
    effects, numbers = values("backlash")
    s = session.samples
    unknown = replace(session, samples=replace(s, step=np.full_like(s.step, np.nan)))
    quiet = np.zeros((len(session), 6))
    numbers["backlash"]["breakaway_nm"] = np.full(6, 1e6)  # no load decides
    found = LoadHistory(unknown).state(effects, numbers, quiet, quiet)
    assert np.array_equal(found, np.sign(s.approach) * numbers["backlash"]["side"])


def test_a_gap_of_zero_has_sides(session: Session) -> None:
    effects, numbers = values("backlash")
    numbers["backlash"]["gap_rad"] = np.zeros(6)
    kept = opened(effects[0], numbers["backlash"])
    assert np.all(kept["gap_rad"] == SMALLEST * 1e-4)
    assert kept["side"] is numbers["backlash"]["side"]
    torque, resting = torques(session, 3)
    found = LoadHistory(session).state(effects, numbers, torque, resting)
    assert np.all(np.abs(np.abs(found) - 1) < 1e-9)


@pytest.mark.parametrize("name", ["backlash", "joint-friction"])
def test_slopes_are_those_of_central_differences(session: Session, name: str) -> None:
    """Shares between their bounds change with the number; those at a bound do not."""
    effects, numbers = values(name)
    torque, resting = torques(session, 1)
    if name == "backlash":  # moves shorter than the gap leave it half crossed
        numbers[name] |= {"gap_rad": np.full(6, 0.5), "breakaway_nm": np.full(6, 1e6)}
    history = LoadHistory(session)
    state = history.state(effects, numbers, torque, resting)
    inside = np.abs(state) < 1 - 1e-9
    assert inside.mean() > 0.02
    found = history.slopes(effects=effects, values=numbers, torque=torque, resting=resting, state=state)
    direct = [p.name for p in effects[0].parameters if p.fit == "direct"]
    assert set(found) == {(name, p) for p in direct}
    for p in direct:
        size = np.maximum(numbers[name][p], 1e-3 * np.abs(numbers[name][p]).max())
        step = 1e-5 * size
        up, down = (
            history.state(effects, {name: {**numbers[name], p: np.minimum(numbers[name][p] + s, 1e3)}}, torque, resting)
            for s in (step, -step)
        )
        slope = (up - down) / (2 * np.tile(step, effects[0].memory.states if effects[0].memory else 1))
        close = np.abs(found[name, p] - slope) <= 1e-3 * np.abs(slope).max() + 1e-6
        assert close.mean() > 0.97  # a state on the edge of its window has two slopes
        assert np.abs(slope).max() > 0


def test_where_nothing_lies_between_its_bounds_there_is_no_slope(session: Session) -> None:
    effects, numbers = values("backlash")
    state = np.sign(np.random.default_rng(0).normal(size=(len(session), 6)))
    torque, resting = torques(session, 1)
    history = LoadHistory(session)
    assert history.slopes(effects=effects, values=numbers, torque=torque, resting=resting, state=state) == {}
