"""Wind-up that stays, along load histories: against a block on a spring that is dragged step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.effects import BY_NAME
from stiffness.effects.effect import REVERSAL, Numbers
from stiffness.memory.preload import PreloadState, unknown, walk
from tests.oracles.effects import ORACLES, Step
from tests.plant.joints import Friction, Memory

Floats = npt.NDArray[np.float64]
FRICTION = (BY_NAME["joint-friction"],)
WEIGHTS = ("weight_half", "weight_double", "weight_quarter")
T = 40.0


def values(joints: int = 1, lag: float = 1.0, share: float = 1.0) -> Mapping[str, Numbers]:
    """One operator."""
    numbers = {"friction_nm": T, "held": share, "lag": lag} | dict.fromkeys(WEIGHTS, 0.0)
    return {"joint-friction": {name: np.full(joints, number) for name, number in numbers.items()}}


def held(
    torque: Floats, start: float = 0.0, move: Floats | None = None, lag: float = 1.0, share: float = 1.0
) -> Floats:
    """Friction torque along a history of torques on one joint."""
    alone = np.array([start, 0.0, 0.0, 0.0])
    moves = np.zeros((len(torque), 1)) if move is None else move[:, None]
    numbers = values(lag=lag, share=share)
    return whole(walk(FRICTION, numbers, move=moves, torque=torque[:, None], start=PreloadState(alone, alone)).middle)


def whole(states: Floats) -> Floats:
    """(N,) sum over the operators of one joint."""
    return np.asarray(states.reshape(len(states), 4).sum(axis=1))


def dragged(torque: Floats, start: float, share: float, parts: int = 200) -> Floats:
    """The same by brute force: a spring of rate 1, a slider on a spring beside it, the load changed in small parts."""
    link, slider, friction = torque[0] + start, -start, []
    beside = share / (1 - share)
    for before, after in zip(np.r_[torque[0], torque[:-1]], torque, strict=True):
        for load in np.linspace(before, after, parts + 1):
            moved = (load - link - slider) / (1 + beside)  # both springs share what is out of balance
            if abs(slider + beside * moved) > T:
                slider = np.copysign(T, slider + beside * moved)
                link = load - slider
            else:
                link, slider = link + moved, slider + beside * moved
        friction.append(-slider)
    return np.array(friction)


def test_loading_and_unloading_differ_by_twice_the_friction() -> None:
    """Up to 300, down to 0: on the way up the link lags by T, on the way down it is ahead by T."""
    up = np.linspace(0, 300, 31)
    torque = np.r_[up, up[-2::-1]]
    total = torque + held(torque)
    np.testing.assert_allclose(total[:5], 0, atol=1e-12)  # within friction nothing moves
    np.testing.assert_allclose(total[5:31], up[5:] - T, atol=1e-12)
    down = total[31:][::-1]  # at 0, 10, ... 290
    np.testing.assert_allclose(down[:23], up[:23] + T, atol=1e-12)
    np.testing.assert_allclose((down - total[:30])[8:23], 2 * T, atol=1e-12)
    assert total[-1] == pytest.approx(T)  # wind-up that stays without load


def test_the_width_of_the_loop_stops_growing_with_the_load() -> None:
    widths = []
    for most in (30.0, 60.0, 100.0, 400.0, 1000.0):
        torque = np.r_[0, most, -most, most, -most, 0]
        total = torque + held(torque)
        back = torque + held(np.r_[0, most, -most, most, 0, 0])
        widths.append(abs(back[4] - torque[4] - (total[5] - torque[5])))
    np.testing.assert_allclose(widths, [0, 2 * (60 - T), 2 * T, 2 * T, 2 * T], atol=1e-12)


def test_a_small_loop_comes_back_to_where_it_left_the_large_one() -> None:
    """Return-point memory: what happened between is forgotten."""
    torque = np.r_[0, 500, 200, 350, 240, 320, 200, 500, -500]
    f = held(torque)
    assert f[6] == f[2] == T and f[7] == f[1] == -T
    assert f[3] == -T and f[4] == T and f[5] == -T
    small = held(np.r_[0, 500, 430, 470, 430, 500])
    assert small[2] == small[4] == pytest.approx(30.0) and small[3] == pytest.approx(-10.0) and small[5] == -T


def test_a_share_that_is_held_makes_the_beginning_stiffer_and_not_rigid() -> None:
    """Slope (1 - b)/K until it slips at T/b, 1/K from there on."""
    load = np.linspace(0, 300, 61)
    total = load + held(load, share=0.8)
    np.testing.assert_allclose(total, np.where(load < T / 0.8, 0.2 * load, load - T), atol=1e-12)


@pytest.mark.parametrize("share", [0.9999999, 0.8, 0.3])
@pytest.mark.parametrize("seed", range(4))
def test_any_history_is_that_of_a_slider_that_is_dragged(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    torque, start = np.cumsum(rng.normal(size=60) * 25 / share), rng.uniform(-T, T)
    f = held(torque, start, share=share)
    np.testing.assert_allclose(f, dragged(torque, start, share), atol=1e-4)
    assert np.ptp(f) > 1.5 * T and np.sum(np.abs(f) < 0.9 * T) > 5


@pytest.mark.parametrize(("lag", "left"), [(1.0, -T), (0.0, 0.0), (0.5, -T / 2)])
def test_a_move_leaves_the_link_behind(lag: float, left: float) -> None:
    move = np.array([0.0, 1e-3, 0.0, -1e-3, 0.0, 1e-9])
    f = held(np.array([10.0, 60, 65, 60, -30, -30]), 7.0, move, lag)
    behind = -left
    expected = [7.0, left, max(left - 5, -T), behind, min(behind + 90, T), min(behind + 90, T)]
    np.testing.assert_allclose(f, expected, atol=0.2)
    np.testing.assert_allclose(f[:5], expected[:5], atol=1e-12)


def test_a_move_shorter_than_a_reversal_takes_it_only_so_far() -> None:
    move = np.array([0.0, -0.1 * REVERSAL, -0.25 * REVERSAL])
    np.testing.assert_allclose(held(np.zeros(3), -T, move), [-T, -T + 0.2 * 2 * T, -T + 0.7 * 2 * T], atol=1e-9)


def test_the_bracket_closes_with_a_load_beyond_twice_the_friction() -> None:
    torque = np.array([0.0, 30, 70, 79, 81, 0])[:, None]
    state = walk(FRICTION, values(), move=np.zeros_like(torque), torque=torque, start=unknown(FRICTION, values()))
    np.testing.assert_allclose(whole(state.low), [-40, -40, -40, -40, -40, 40], atol=1e-12)
    np.testing.assert_allclose(whole(state.high), [40, 10, -30, -39, -40, 40], atol=1e-12)
    np.testing.assert_array_equal(state.known.all(axis=1), [False, False, False, False, True, True])


@pytest.mark.parametrize("rows", [1, 2, 37, 4000])
def test_the_walk_is_the_oracle_step_by_step(rows: int) -> None:
    """Moves and torques together, several joints, blocks side by side."""
    rng, n, step = np.random.default_rng(rows), 3, ORACLES["joint-friction"].step
    move = rng.choice([0.0, 1e-7, 3e-7, 1e-4], (rows, n), p=[0.6, 0.2, 0.1, 0.1]) * rng.choice([-1, 1], (rows, n))
    torque = np.cumsum(rng.normal(size=(rows, n)) * 20, axis=0)
    numbers = {"friction_nm": T, "held": 0.6, "lag": 0.7} | dict(zip(WEIGHTS, (0.4, 0.9, 0.3), strict=True))
    every: Mapping[str, Numbers] = {"joint-friction": {name: np.full(n, v) for name, v in numbers.items()}}
    start = np.random.default_rng(1).uniform(-1, 1, 4 * n) * unknown(FRICTION, every).high
    got = walk(FRICTION, every, move=move, torque=torque, start=PreloadState(start, start)).middle
    if step is None:
        raise TypeError("no step")
    p, states = numbers, []
    for c in range(4 * n):
        state, j = start[c], c % n
        for k in range(rows):
            now = Step(move[k, j], torque[k, j], torque[max(k - 1, 0), j], number=c // n)
            state = step(state, now, p)
            states.append(state)
    np.testing.assert_allclose(got.T.ravel(), states, atol=1e-9)


K = 2e5  # N*m/rad
SPRING = (BY_NAME["joint-stiffness"], *FRICTION)


def sprung(share: float, weights: tuple[float, float, float], lag: float = 1.0) -> Mapping[str, Numbers]:
    numbers = {"friction_nm": T, "held": share, "lag": lag} | dict(zip(WEIGHTS, weights, strict=True))
    own = {name: np.array([number]) for name, number in numbers.items()}
    return {"joint-stiffness": {"k_nm_per_rad": np.array([K])}, "joint-friction": own}


def prandtl_ishlinskii(load: Floats, angle: Floats, share: float, weights: tuple[float, float, float]) -> Floats:
    """Friction along a history, by the textbook: a weighted sum of play operators of what drives them.

    Kuhnen, European Journal of Control 9 (2003) 407: y = sum w_k p_k, p' = max(x - r, min(x + r, p)). A play takes
    what a stop leaves: the stop of x is x - p.
    """
    driving, total = load + K * angle, np.zeros(len(load))
    weight = np.array([1.0, *weights])
    for w, ratio in zip(weight / weight.sum(), (1.0, 0.5, 2.0, 0.25), strict=True):
        r, play = ratio * T / share, driving[0]
        for k, x in enumerate(driving):
            play = max(x - r, min(x + r, play))
            total[k] -= w * share * (x - play)
    return total


@pytest.mark.parametrize("share", [1.0, 0.7, 0.3])
@pytest.mark.parametrize("weights", [(0.0, 0.0, 0.0), (0.5, 0.3, 0.8), (2.0, 0.0, 0.1)])
def test_loads_and_moves_drive_one_prandtl_ishlinskii_operator(
    share: float, weights: tuple[float, float, float]
) -> None:
    rng = np.random.default_rng(5)
    load, angle = (np.cumsum(rng.normal(size=400)) * size for size in (15 / share, 60 / K))
    start = np.zeros(4)
    found = walk(
        SPRING,
        sprung(share, weights),
        move=np.diff(angle, prepend=angle[0])[:, None],
        torque=load[:, None],
        start=PreloadState(start, start),
    )
    expected = prandtl_ishlinskii(load, angle, share, weights)
    np.testing.assert_allclose(whole(found.middle), expected, atol=1e-9)
    assert np.ptp(expected) > T


@pytest.mark.parametrize("grip", [4.0, 0.5])
def test_a_reversal_turns_over_as_the_plant_s_dry_bearing_does(grip: float) -> None:
    """The release travel is 2 T / (b K): small moves to and fro, and loads, against a bearing dragged by a drive."""
    rng = np.random.default_rng(3)
    share = grip / (1 + grip)
    move = rng.choice([-1, 1], 200).repeat(3) * rng.uniform(0, 1.2 * T / (share * K), 600)
    load = np.repeat(np.cumsum(rng.normal(size=60)) * 10, 10)
    bearing, stiffness = Friction(np.array([T]), np.array([grip])), np.array([K])
    memory, expected = Memory.fresh([0.0]), []
    memory = replace(memory, anchor=bearing.dragged(load[:1], stiffness, np.array([load[0] / K])))
    for step, torque in zip(move, load, strict=True):
        command = memory.command + step
        anchor = bearing.carried(memory, command, 1e-12)
        expected.append(-float(bearing.torque(np.array([torque]), stiffness, anchor)[0]))
        memory = replace(memory, command=command, anchor=bearing.dragged(np.array([torque]), stiffness, anchor))
    start, values = np.zeros(4), sprung(share, (0.0, 0.0, 0.0))
    found = walk(SPRING, values, move=move[:, None], torque=load[:, None], start=PreloadState(start, start))
    np.testing.assert_allclose(whole(found.middle), expected, atol=1e-6)
    assert np.mean(np.abs(expected) < 0.9 * T) > 0.2 and np.max(np.abs(expected)) == pytest.approx(T)


@pytest.mark.parametrize("share", [1.0, 0.8, 0.4])
@pytest.mark.parametrize("weights", [(0.0, 0.0, 0.0), (0.5, 0.3, 0.8), (1.0, 2.0, 0.0)])
@pytest.mark.parametrize("lag", [1.0, 0.0])
def test_the_command_of_a_corrected_target_leads_to_the_states_it_was_corrected_for(
    share: float, weights: tuple[float, float, float], lag: float
) -> None:
    rng = np.random.default_rng(7)
    turns = np.cumsum(rng.random(800) < 0.15) % 2 * 2 - 1
    target = turns * rng.choice([0.0, 2e-6, 2e-5, 2e-4, 2e-3], 800) * rng.uniform(0.5, 1, 800)
    load = np.repeat(np.cumsum(rng.normal(size=80)) * 20, 10)
    target -= np.diff(load, prepend=load[0]) / K  # corrected for the spring
    values = sprung(share, weights, lag)
    begin = 0.3 * unknown(SPRING, values).high * (np.array([1.0, *weights]) > 0)
    start = PreloadState(begin, begin)
    corrected = walk(SPRING, values, move=target[:, None], torque=load[:, None], start=start, corrected=True).middle
    f = whole(np.vstack([begin, corrected]))
    command = target - np.diff(f) / K
    again = walk(SPRING, values, move=command[:, None], torque=load[:, None], start=start).middle
    np.testing.assert_allclose(whole(again), f[1:], atol=1e-6 * T)
    assert np.ptp(f) > (1.2 * T if lag else 0.2 * T)
