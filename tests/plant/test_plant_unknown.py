"""Memory, instruments and ailments that no catalogue has: values by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from . import Plant, small_arms
from . import ailments_instrument as instrument
from . import ailments_joint as joint
from . import ailments_unknown as unknown
from .ailment import Ailment
from .cell_design import CELLS
from .geometry import Array, turn
from .hand import Day
from .joints import Bearings, Friction
from .test_plant_effects import check

ARMS = tuple(CELLS)
K = 1e5  # N*m/rad


def bearing(lag: bool) -> Plant:
    """One weightless joint about -y, 1 m long: F up is torque F. Slips at 20 N*m, grips four times as hard."""
    friction = Friction(np.array([20.0]), np.array([4.0]), lag)
    return Plant(small_arms.planar([1.0]), stiffness=K, friction=friction, gravity_on=False)


def winds(plant: Plant, torques: list[float], move: float) -> list[float]:
    """Deflection x K, N*m, in each load after a long move."""
    walk = plant.walk([[-move], *[[0.0]] * len(torques)], [[0, 0, t, 0, 0, 0] for t in (0.0, *torques)])
    return ((walk.q_act[1:, 0] - 0.0) * K).tolist()


def test_friction_keeps_its_windup_and_remembers_the_order() -> None:
    # K d = torque - T; T within +-20, else 0.8 (torque - K anchor); anchor K = K d - T / 4
    loose = bearing(lag=False)
    np.testing.assert_allclose(winds(loose, [0, 50, 100, 50, 0], 0.1), [0, 30, 80, 70, 20], atol=1e-3)
    np.testing.assert_allclose(winds(loose, [0, 100, 50, 100, 0], 0.1), [0, 80, 70, 80, 20], atol=1e-3)
    np.testing.assert_allclose(winds(loose, [0, 10, 50, 40], 0.1), [0, 2, 30, 28], atol=1e-3)
    np.testing.assert_allclose(winds(loose, [0, -50, 0], -0.1), [0, -30, -20], atol=1e-3)


def test_friction_lets_the_link_lag_behind_a_long_move() -> None:
    np.testing.assert_allclose(winds(bearing(lag=True), [0, 50, -50], 0.1), [-20, 30, -30], atol=1e-3)
    np.testing.assert_allclose(winds(bearing(lag=True), [0, 45, -50], -0.1), [20, 29, -30], atol=1e-3)
    # a move of 0.1 mrad against the last one: from T = 20 (anchor -25 / K), the anchor goes to -15 / K: T = 12
    walk = bearing(lag=True).walk([[-0.1], [0.0], [-1e-4]])
    assert (walk.q_act[2, 0] + 1e-4) * K == pytest.approx(-12, abs=1e-3)


def test_bearings_side_by_side() -> None:
    """One is the dry bearing; two of equal grip 2 that slip at 8 and 20 N*m, by hand: K d = torque - T1 - T2."""
    arm, loads = small_arms.planar([1.0]), [0, 50, -20, 90, 10, 0]
    alone = Bearings(np.array([[20.0]]), np.array([[4.0]]))
    one = Plant(arm, stiffness=K, friction=alone, gravity_on=False)
    np.testing.assert_allclose(winds(one, loads, 0.1), winds(bearing(lag=True), loads, 0.1), atol=1e-3)
    pair = Bearings(np.array([[8.0], [20.0]]), np.array([[2.0], [2.0]]))
    two = Plant(arm, stiffness=K, friction=pair, gravity_on=False)
    # dragged up: both pull back. From 50 down to 0: stuck, 1/5 of it up to T1 = -8 (K d down by 8), then 1/3 of it
    np.testing.assert_allclose(winds(two, [0, 50], 0.1), [-28, 22], atol=1e-3)
    np.testing.assert_allclose(winds(two, [0, 50, 10, 0], 0.1), [-28, 22, 14, 14 - 10 / 3], atol=1e-3)


@pytest.mark.parametrize("arm", ARMS)
def test_friction_in_a_session(arm: str) -> None:
    day = Day(arm)
    wear, values = joint.friction(2).apply(day.cell.healthy, day.cell.arm, 0.3)
    slip, stiff = values["slip joint-2 N*m"], day.cell.stiffness[1]
    change, start = day.change(wear), day.column("state")[:, 0] == 0
    wanted = day.turned(2, -slip / stiff * day.direction[:, 1])
    np.testing.assert_allclose(change[start], wanted[start], atol=0.01 * np.abs(wanted).max())
    # set-ups 1, 4 and 7 go 0, half, full, half, 0: what is left between going up and coming down
    state, setup = day.column("state")[:, 0], day.column("setup")[:, 0]
    slipped = 0
    for number in (1, 4, 7):
        up, down = ((setup == number) & (state == k) for k in (1, 3))
        rest, half, full = (day.torque(2)[(setup == number) & (state == k)][0] for k in (0, 1, 2))
        if min(abs(half - rest), abs(full - half)) < 2.5 * slip:  # 2 slip, and the grip lets 1/4 more go by
            continue
        slipped += 1
        lost = day.turned(2, np.full(len(setup), 2 * slip / stiff * np.sign(full - half)))[up]
        np.testing.assert_allclose(change[down] - change[up], lost, atol=0.02 * np.abs(lost).max())
    assert slipped


@pytest.mark.parametrize("arm", ARMS)
def test_bent_sensor_shows_another_wrench_and_moves_nothing(arm: str) -> None:
    day = Day(arm)
    names = ("fx", "fy", "fz", "mx", "my", "mz")
    R = day.healthy.truth.walk.tcp[day.healthy.truth.at, :3, :3]
    truth = np.hstack([np.einsum("nij,ni->nj", R, w) for w in np.split(day.healthy.truth.wrench, 2, axis=1)])
    for kind in ("zero", "scale"):
        wear, values = instrument.sensor(kind).apply(day.cell.healthy, day.cell.arm, 1.5)
        numbers = np.array(list(values.values()))
        if kind == "zero":
            wanted = truth + numbers
        else:
            T = turn(numbers[6:])
            wanted = (1 + numbers[:6]) * np.hstack([truth[:, :3] @ T.T, truth[:, 3:] @ T.T])
        if day.cell.frame == "base":
            wanted = np.hstack([np.einsum("nij,nj->ni", R, w) for w in np.split(wanted, 2, axis=1)])
        notes = day.measured(wear)
        np.testing.assert_allclose(day.column(*names, notes=notes), wanted, atol=1e-9)
        np.testing.assert_array_equal(day.column(*"xyz", notes=notes), day.column(*"xyz"))
        assert np.abs(wanted - truth).max() > 0.01 * day.cell.force


def amplitude(values: Any) -> float:
    (s,) = values.values()
    return float(s)


def turning(day: Day, ailment: Ailment, k: int, s: float, angle: Array) -> None:
    """Joint k turns by s x angle (N,), and nothing else happens."""

    def expected(values: Any) -> Array:
        assert amplitude(values) == s
        return day.turned(k, s * angle)

    check(day, ailment, s, expected)


@pytest.mark.parametrize("arm", ARMS)
def test_unknown_turns_of_one_joint(arm: str) -> None:
    day = Day(arm)
    q, stiff = day.q, day.cell.stiffness
    turning(day, unknown.crossed(), 3, 0.2, day.torque(3) / stiff[2] * np.sin(2 * q[:, 1]))
    turning(day, unknown.ripple(), 3, 1.2, 1e-4 * np.sin(3 * q[:, 2] + 0.4))
    shut, speed = day.column("brake")[:, 0], day.column("spindle")[:, 0]
    assert {0.0, 1.0} == set(shut) and {0.0, 6000.0, 12000.0} == set(speed)
    turning(day, unknown.brake(), 2, 1.5, 1e-4 * shut)
    turning(day, unknown.spindle(), 5, 3.0, np.select([speed == 6000, speed == 12000], [0.25e-4, 1e-4]))
    way = np.sign(day.direction[:, 3] + day.direction[:, 4])
    assert {-1.0, 0.0, 1.0} >= set(way) and len(set(way)) > 1
    turning(day, unknown.hose(), 4, 3.0, -1e-4 * (np.tanh((q[:, 3] + q[:, 4]) / 0.8) + 0.4 * way))


def test_unknown_tiring_grows_with_the_clock() -> None:
    day = Day()
    # the joint feels the clock once per state, at its first reading; readings of one state are 9 s and less apart
    _, first, back = np.unique(
        np.hstack([day.column("setup"), day.column("state")]), axis=0, return_index=True, return_inverse=True
    )
    clock = day.column("time")[first, 0][np.ravel(back)]
    turning(day, unknown.tiring(), 3, 0.3, day.torque(3) / day.cell.stiffness[2] * clock / 9000)
