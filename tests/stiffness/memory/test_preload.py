"""The walk of joint states against a joint that is followed pose by pose in plain Python."""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffness.effects import BY_NAME
from stiffness.effects.effect import REVERSAL, Effect, Numbers
from stiffness.memory.preload import PreloadState, unknown, walk
from tests.oracles.flanks import Direction, Gap

Floats = npt.NDArray[np.float64]
SOFT, GAP = BY_NAME["preload-softening"], BY_NAME["backlash"]
BOTH = (SOFT, GAP)
B = 2e-4


def values(side: float = 1.0, breakaway: float = 50.0, gap: float = B, joints: int = 1) -> Mapping[str, Numbers]:
    full = np.ones(joints)
    return {
        "preload-softening": {"ratio": 0.8 * full},
        "backlash": {"gap_rad": gap * full, "breakaway_nm": breakaway * full, "side": side * full},
    }


def at(*state: float) -> PreloadState:
    """A known state."""
    return PreloadState(np.array(state), np.array(state))


def column(*numbers: float) -> Floats:
    return np.array(numbers, dtype=float)[:, None]


def only_gap(move: Floats, torque: Floats, start: PreloadState, v: Mapping[str, Numbers]) -> Floats:
    state = walk((GAP,), v, move=move, torque=torque, start=start)
    assert state.known.all()
    return state.middle[:, 0]


def random_path(rows: int, joints: int, seed: int) -> tuple[Floats, Floats]:
    """Runs of small and large moves that turn around now and then, with stops, and torques that change sign."""
    rng = np.random.default_rng(seed)
    turns = np.cumsum(rng.random((rows, joints)) < 0.1, axis=0) % 2 * 2 - 1
    move = turns * rng.choice([0.0, 2e-5, 1e-4, 1e-3, 1e-2], (rows, joints)) * rng.uniform(0.5, 1, (rows, joints))
    torque = 120 * np.sin(np.linspace(0, 9, rows)[:, None] + rng.uniform(0, 6, joints))
    torque[rng.random((rows, joints)) < 0.2] = 0.0
    return move, torque


# --------------------------------------------------------------------------- the rules, one by one


def test_the_link_rests_on_the_side_it_turned_to() -> None:
    move = column(1e-3, -1e-3, 0, -1e-3, 1e-3)
    np.testing.assert_allclose(
        only_gap(move, 0 * move, at(0.0), values(1.0)), B / 2 * np.array([1, -1, -1, -1, 1]), atol=1e-18
    )
    np.testing.assert_allclose(
        only_gap(move, 0 * move, at(0.0), values(-1.0)), B / 2 * np.array([-1, 1, 1, 1, -1]), atol=1e-18
    )


def test_a_move_shorter_than_the_gap_takes_it_only_so_far() -> None:
    move = column(1e-3, -0.5e-4, -0.5e-4, 0.2e-4, -1e-3)
    expected = [1e-4, 0.5e-4, 0.0, 0.2e-4, -1e-4]
    np.testing.assert_allclose(only_gap(move, 0 * move, at(0.0), values()), expected, atol=1e-18)


def test_a_torque_beyond_breakaway_holds_its_own_flank() -> None:
    move = column(1e-3, 1e-3, 1e-3, 1e-3, -1e-3, 0)
    torque = column(49, -51, -50, 49, 51, 0)
    expected = B / 2 * np.array([1, -1, 1, 1, 1, 1])
    np.testing.assert_allclose(only_gap(move, torque, at(0.0), values()), expected, atol=1e-18)


def test_a_torque_carries_it_across_while_it_stands_still_and_it_stays() -> None:
    move, torque = column(0, 0, 0, 0), column(0, 80, 0, -20)
    np.testing.assert_allclose(only_gap(move, torque, at(-1e-4), values()), [-1e-4, 1e-4, 1e-4, 1e-4], atol=1e-18)


def test_rounding_of_a_zero_torque_chooses_no_flank() -> None:
    move, torque = column(1e-3, 0, 0), column(0, -1e-9, -0.009)
    np.testing.assert_allclose(only_gap(move, torque, at(0.0), values(breakaway=0.0)), [1e-4] * 3, atol=1e-18)
    torque[2] = -0.011
    np.testing.assert_allclose(only_gap(move, torque, at(0.0), values(breakaway=0.0)), [1e-4, 1e-4, -1e-4], atol=1e-18)


def test_direction_is_that_of_the_last_rotation() -> None:
    move = column(1e-3, 0, 1e-9, -1e-9, -1e-3, 0, 2e-8, 1e-3)
    state = walk((SOFT,), values(), move=move, torque=0 * move, start=unknown((SOFT,), values()))
    np.testing.assert_array_equal(np.sign(state.middle[:, 0]), [1, 1, 1, 1, -1, -1, -1, 1])
    assert state.known.all()


def test_jitter_below_the_threshold_is_no_reversal_and_adds_up_to_one() -> None:
    jitter = np.tile([[-0.4 * REVERSAL], [0.4 * REVERSAL]], (50, 1))
    state = walk((SOFT,), values(), move=jitter, torque=0 * jitter, start=at(1.0))
    assert np.all(state.middle > 0)
    creep = np.full((4, 1), -0.3 * REVERSAL)
    np.testing.assert_allclose(
        walk((SOFT,), values(), move=creep, torque=0 * creep, start=at(1.0)).middle[:, 0], [0.4, -0.2, -0.8, -1.0]
    )


# ------------------------------------------------------------------------- unknown beginnings


def test_the_bracket_closes_when_the_joint_has_moved_far_enough() -> None:
    move = column(0.0, 0.5e-4, 0.7e-4, 1e-4, 0)
    state = walk((GAP,), values(), move=move, torque=0 * move, start=unknown((GAP,), values()))
    np.testing.assert_allclose(state.low[:, 0], [-1e-4, -0.5e-4, 0.2e-4, 1e-4, 1e-4], atol=1e-18)
    np.testing.assert_allclose(state.high[:, 0], 1e-4, atol=1e-18)
    np.testing.assert_array_equal(state.known[:, 0], [False, False, False, True, True])
    assert "partly unknown" in repr(state) and repr(state.last) == "PreloadState(shape (1,), known)"


def test_a_holding_torque_closes_the_bracket_at_once() -> None:
    state = walk((GAP,), values(), move=column(0.0), torque=column(-60), start=unknown((GAP,), values()))
    assert state.known.all() and state.middle[0, 0] == pytest.approx(-1e-4)


def test_every_possible_beginning_stays_in_the_bracket() -> None:
    move, torque = random_path(300, 3, 1)
    torque[:40] = 0
    v = values(joints=3)
    bracket = walk(BOTH, v, move=move * 1e-3, torque=torque, start=unknown(BOTH, v))
    assert not bracket.known.all()
    rng = np.random.default_rng(2)
    for _ in range(20):
        start = np.r_[rng.uniform(-1, 1, 3), rng.uniform(-B / 2, B / 2, 3)]
        inside = walk(BOTH, v, move=move * 1e-3, torque=torque, start=PreloadState(start, start)).middle
        assert np.all((bracket.low - 1e-9 <= inside) & (inside <= bracket.high + 1e-9))


def test_effects_without_memory_have_no_state() -> None:
    only = (BY_NAME["joint-stiffness"],)
    state = walk(only, {}, move=np.zeros((5, 6)), torque=np.zeros((5, 6)), start=unknown(only, {}))
    assert state.low.shape == (5, 0) and state.known.all()


def test_an_empty_path() -> None:
    state = walk(
        BOTH, values(joints=2), move=np.empty((0, 2)), torque=np.empty((0, 2)), start=unknown(BOTH, values(joints=2))
    )
    assert state.low.shape == (0, 4)


# --------------------------------------------------------------------------- against the oracle


@pytest.mark.parametrize("rows", [1, 2, 3, 10, 101, 5000])
@pytest.mark.parametrize(("side", "breakaway"), [(1.0, 60.0), (-1.0, 60.0), (0.4, 0.0), (-0.3, 1e9), (1.0, 0.0)])
def test_walk_is_the_joint_followed_pose_by_pose(rows: int, side: float, breakaway: float) -> None:
    move, torque = random_path(rows, 2, rows)
    v = values(side, breakaway, joints=2)
    got = walk(BOTH, v, move=move, torque=torque, start=at(1.0, -1.0, 0.3e-4, -B / 2))
    for j in range(2):
        gap, way = Gap(B, breakaway, side, (0.3e-4, -B / 2)[j]), Direction((1, -1)[j])
        links = [gap.go(m, t) for m, t in zip(move[:, j], torque[:, j], strict=True)]
        ways = [way.go(m) for m in move[:, j]]
        np.testing.assert_allclose(got.middle[:, 2 + j], links, atol=1e-14)
        np.testing.assert_array_equal(np.sign(got.middle[:, j]), ways)
    if rows > 1000:
        assert len(np.unique(np.sign(got.middle[:, 0]))) == 2 and np.ptp(got.middle[:, 2]) > 0.9 * B


@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_any_walk_is_the_joint_followed_pose_by_pose(data: st.DataObject) -> None:
    small = st.floats(-3e-4, 3e-4, allow_nan=False)
    rows = data.draw(st.lists(st.tuples(small, st.floats(-200, 200)), min_size=1, max_size=40))
    side, breakaway = data.draw(st.floats(-1, 1)), data.draw(st.floats(0, 150))
    gap, link = data.draw(st.floats(0, 5e-4)), data.draw(st.floats(-0.5, 0.5))
    move, torque = column(*(r[0] for r in rows)), column(*(r[1] for r in rows))
    joint = Gap(gap, breakaway, side, link * gap)
    expected = [joint.go(m, t) for m, t in rows]
    got = only_gap(move, torque, at(link * gap), values(side, breakaway, gap))
    np.testing.assert_allclose(got, expected, atol=1e-14)
    cut = data.draw(st.integers(0, len(rows)))
    if 0 < cut < len(rows):
        first = walk((GAP,), values(side, breakaway, gap), move=move[:cut], torque=torque[:cut], start=at(link * gap))
        second = walk((GAP,), values(side, breakaway, gap), move=move[cut:], torque=torque[cut:], start=first.last)
        np.testing.assert_allclose(np.r_[first.middle, second.middle][:, 0], expected, atol=1e-14)


@pytest.mark.parametrize("corrected", [False, True])
@pytest.mark.parametrize("cuts", [(1,), (400,), (7, 8, 333, 1999)])
def test_chunks_carry_the_state_on(cuts: tuple[int, ...], corrected: bool) -> None:
    move, torque = random_path(2000, 3, 3)
    v = values(0.7, joints=3)
    whole = walk(BOTH, v, move=move, torque=torque, start=unknown(BOTH, v), corrected=corrected)
    state, low, high, middle = unknown(BOTH, v), [], [], []
    for a, b in zip((0, *cuts), (*cuts, 2000), strict=True):
        part = walk(BOTH, v, move=move[a:b], torque=torque[a:b], start=state, corrected=corrected)
        low.append(part.low)
        high.append(part.high)
        middle.append(part.middle)
        state = part.last
    np.testing.assert_allclose(np.vstack(low), whole.low, atol=1e-9)
    np.testing.assert_allclose(np.vstack(high), whole.high, atol=1e-9)
    np.testing.assert_allclose(np.vstack(middle), whole.middle, atol=1e-9)
    np.testing.assert_allclose(np.vstack(low)[:, 3:], whole.low[:, 3:], atol=1e-15)


@pytest.mark.parametrize("cut", [1, 2, 3, 4])
def test_chunks_of_a_path_whose_beginning_is_not_known(cut: int) -> None:
    """What a command answered at the end of one chunk is a move at the beginning of the next."""
    move, torque = column(1e-5, 1e-5, 1e-5, -1e-5, 1e-5), column(0, 0, 80, -80, 0)
    v = values()
    whole = walk(BOTH, v, move=move, torque=torque, start=unknown(BOTH, v), corrected=True)
    first = walk(BOTH, v, move=move[:cut], torque=torque[:cut], start=unknown(BOTH, v), corrected=True)
    second = walk(BOTH, v, move=move[cut:], torque=torque[cut:], start=first.last, corrected=True)
    np.testing.assert_allclose(np.vstack([first.middle, second.middle]), whole.middle, atol=1e-12)
    np.testing.assert_array_equal(np.sign(whole.middle[:, 0]), [1, 1, -1, 1, 1])


def test_no_command_has_answered_a_state_that_nobody_knew() -> None:
    """The torque puts the link on its flank before the first pose: no move of the command."""
    move, torque = column(1e-5, 1e-5), column(80, 80)
    state = walk(BOTH, values(), move=move, torque=torque, start=unknown(BOTH, values()), corrected=True)
    np.testing.assert_array_equal(np.sign(state.middle[:, 0]), [1, 1])
    known = walk(BOTH, values(), move=move, torque=torque, start=at(1.0, 0.0), corrected=True)
    np.testing.assert_array_equal(np.sign(known.middle[:, 0]), [-1, 1])


@pytest.mark.parametrize("corrected", [False, True])
def test_many_paths_side_by_side(corrected: bool) -> None:
    paths = [random_path(30, 2, seed) for seed in range(700)]
    move, torque = (np.stack([p[k] for p in paths], axis=1) for k in (0, 1))
    v = values(joints=2)
    start = np.tile(unknown(BOTH, v).high, (700, 1))
    got = walk(BOTH, v, move=move, torque=torque, start=PreloadState(-start, start), corrected=corrected)
    assert got.low.shape == (30, 700, 4)
    for k in (0, 350, 699):
        alone = walk(BOTH, v, *paths[k], unknown(BOTH, v), corrected=corrected)
        np.testing.assert_allclose(got.low[:, k], alone.low, atol=1e-9)
        np.testing.assert_allclose(got.high[:, k], alone.high, atol=1e-9)


# ----------------------------------------------------------------------------- corrected paths


def commands(target: Floats, state: PreloadState, start: PreloadState, joints: int) -> Floats:
    """Commanded moves that bring the links along ``target`` moves: every change of the gap is taken off."""
    u = np.vstack([start.middle, state.middle])[:, joints : 2 * joints]
    return np.asarray(target - np.diff(u, axis=0))


@pytest.mark.parametrize("breakaway", [0.0, 40.0, 1e9])
@pytest.mark.parametrize("side", [1.0, 0.6, -0.5, -0.95, (1.0, 0.3, 0.0, -0.8)])
def test_commands_of_a_corrected_walk_lead_to_the_same_states(
    side: float | tuple[float, ...], breakaway: float
) -> None:
    move, torque = random_path(3000, 4, 4)
    v, start = values(1.0, breakaway, joints=4), at(*[1.0] * 4, *[0.2e-4] * 4)
    v = {**v, "backlash": {**v["backlash"], "side": np.broadcast_to(side, 4)}}
    state = walk(BOTH, v, move=move, torque=torque, start=start, corrected=True)
    again = walk(BOTH, v, move=commands(move, state, start, 4), torque=torque, start=start)
    np.testing.assert_allclose(again.middle[:, 4:], state.middle[:, 4:], atol=1e-15)
    np.testing.assert_array_equal(np.sign(again.middle[:, :4]), np.sign(state.middle[:, :4]))
    assert np.ptp(state.middle[:, 4]) > 0.9 * B


@pytest.mark.parametrize("breakaway", [0.0, 40.0, 1e9])
def test_a_link_that_lags_behind_crosses_at_once(breakaway: float) -> None:
    """Side -1: the correction is as long as the gap. Moves below REVERSAL are known to REVERSAL only."""
    move, torque = random_path(3000, 4, 5)
    v, start = values(-1.0, breakaway, joints=4), at(*[1.0] * 4, *[0.2e-4] * 4)
    state = walk(BOTH, v, move=move, torque=torque, start=start, corrected=True)
    again = walk(BOTH, v, move=commands(move, state, start, 4), torque=torque, start=start)
    np.testing.assert_allclose(again.middle, state.middle, atol=1e-15)
    tiny = np.random.default_rng(6).choice([-1, 1], (500, 4)) * 0.2 * REVERSAL
    state = walk(BOTH, v, move=tiny, torque=0 * tiny, start=start, corrected=True)
    again = walk(BOTH, v, move=commands(tiny, state, start, 4), torque=0 * tiny, start=start)
    np.testing.assert_allclose(again.middle[0, 4:], state.middle[0, 4:], atol=REVERSAL)


def test_a_correction_that_turns_the_joint_around_is_seen_by_the_softer_side() -> None:
    """The torque carries the link across the gap during a small move forward: the command goes back."""
    move, torque = column(1e-3, 1e-5, 1e-5, 1e-5), column(-80, -80, 80, 80)
    v, start = values(), at(1.0, 0.0)
    state = walk(BOTH, v, move=move, torque=torque, start=start, corrected=True)
    moved = commands(move, state, start, 1)
    np.testing.assert_allclose(moved[:, 0], [1e-3 + B / 2, 1e-5, 1e-5 - B, 1e-5], atol=1e-17)
    np.testing.assert_array_equal(np.sign(state.middle[:, 0]), [1, 1, -1, 1])


def test_the_order_of_effects_is_the_order_of_columns_only() -> None:
    move, torque = random_path(400, 3, 7)
    v = values(joints=3)
    one = walk((SOFT, GAP), v, move=move, torque=torque, start=unknown((SOFT, GAP), v), corrected=True)
    other = walk((GAP, SOFT), v, move=move, torque=torque, start=unknown((GAP, SOFT), v), corrected=True)
    np.testing.assert_array_equal(one.low, np.roll(other.low, 3, axis=1))
    np.testing.assert_array_equal(one.high, np.roll(other.high, 3, axis=1))


def test_nothing_to_correct_without_a_gap() -> None:
    move, torque = random_path(500, 3, 8)
    v = values(gap=0.0, joints=3)
    a = walk(BOTH, v, move=move, torque=torque, start=unknown(BOTH, v), corrected=True)
    b = walk(BOTH, v, move=move, torque=torque, start=unknown(BOTH, v))
    np.testing.assert_array_equal(a.low, b.low)
    assert np.all(a.middle[:, 3:] == 0)


# ---------------------------------------------------------------------------------- cost


def test_memory_grows_with_the_path_and_no_faster() -> None:
    peaks = []
    for rows in (20_000, 80_000):
        move, torque = np.full((rows, 6), 1e-6), np.zeros((rows, 6))
        v = values(joints=6)
        effects: tuple[Effect, ...] = (GAP,)
        tracemalloc.start()
        walk(effects, v, move=move, torque=torque, start=unknown(effects, v))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 5 * peaks[0]
    assert peaks[1] < 20 * 80_000 * 6 * 8


def test_the_likely_state_is_that_of_a_joint_that_began_in_the_middle() -> None:
    move, torque = random_path(200, 3, 9)
    torque[:60] = 0
    v = values(joints=3)
    got = walk(BOTH, v, move=1e-3 * move, torque=torque, start=unknown(BOTH, v))
    began = walk(BOTH, v, move=1e-3 * move, torque=torque, start=at(*[0.0] * 6))
    np.testing.assert_allclose(got.middle, began.middle, atol=1e-12)
    assert np.all((got.low - 1e-9 <= got.middle) & (got.middle <= got.high + 1e-9))
    np.testing.assert_array_equal(got.last.middle, got.middle[-1])
    assert np.abs(got.middle - 0.5 * (got.low + got.high)).max() > 1e-6
