"""Each ailment changes a session by what a textbook formula says: values, not "differs". See hand.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from . import ailments_body as body
from . import ailments_instrument as instrument
from . import ailments_joint as joint
from . import small_arms
from .ailment import Ailment
from .cell_design import CELLS, climate
from .geometry import Array, shift
from .hand import Day
from .wear import Wear
from .worn_plant import WornPlant

ARMS = tuple(CELLS)
DAY = Day()


def check(day: Day, ailment: Ailment, s: float, expected: Any, close: float = 0.01) -> Array:
    """The change of the readings is `expected` (called with the values that the ailment says it set), within `close`
    of the largest; less is known than that: hand formulas are of first order."""
    wear, values = ailment.apply(day.cell.healthy, day.cell.arm, s)
    change = day.change(wear)
    wanted = expected(values)
    size = np.abs(wanted).max()
    assert size > 1e-5  # m
    np.testing.assert_allclose(change, wanted, rtol=0, atol=close * size)
    return change


def test_torque_by_hand_is_the_torque_of_the_plant() -> None:
    for k in range(1, 7):
        torque = DAY.healthy.truth.walk.torque[DAY.healthy.truth.at, k - 1]
        np.testing.assert_allclose(DAY.torque(k), torque, atol=1e-6 * np.abs(torque).max())


@pytest.mark.parametrize("k", [2, 3])
def test_hardening_follows_its_three_slopes(k: int) -> None:
    def expected(values: Any) -> Array:
        K1, K2, K3 = (values[f"K{i} joint-{k} N*m/rad"] for i in (1, 2, 3))
        T1, T2 = values[f"T1 joint-{k} N*m"], values[f"T2 joint-{k} N*m"]
        corner = T1 / K1 + (T2 - T1) / K2
        t = DAY.torque(k)
        curve = np.interp(np.abs(t), [0, T1, T2, 1e6], [0, T1 / K1, corner, corner + (1e6 - T2) / K3])
        assert (np.abs(t) < T1).any() and (np.abs(t) > T2).any()
        return DAY.turned(k, np.sign(t) * curve - t / K3)

    check(DAY, joint.hardening(k), 0.2, expected)


def test_smooth_hardening_is_the_integral_of_its_slope() -> None:
    def expected(values: Any) -> Array:
        s, knee = values["softness joint-3 1"], values["knee joint-3 N*m"]
        t = DAY.torque(3)
        steps = np.linspace(0, 1, 2001)
        slope = s * np.exp(-np.abs(t)[:, None] * steps / knee) / DAY.cell.stiffness[2]
        return DAY.turned(3, t * np.mean((slope[:, 1:] + slope[:, :-1]) / 2, axis=1))

    check(DAY, joint.hardening_smooth(3), 0.3, expected)


@pytest.mark.parametrize("k", [1, 3])
def test_softening_where_torque_is_against_the_last_rotation(k: int) -> None:
    def expected(values: Any) -> Array:
        t, stiff = DAY.torque(k), DAY.cell.stiffness[k - 1]
        against = t * DAY.direction[:, k - 1] < 0
        assert 0.1 < against[np.abs(t) > 1].mean() < 0.9
        return DAY.turned(k, np.where(against, t / stiff * (1 / values[f"ratio joint-{k}"] - 1), 0))

    check(DAY, joint.softening(k), 0.25, expected)


def test_backlash_is_on_one_side_or_the_other() -> None:
    def expected(values: Any) -> Array:
        t, side = DAY.torque(1), DAY.direction[:, 0].copy()
        order = DAY.healthy.truth.at  # torque beyond breakaway carries; less leaves the link where it is
        setup = DAY.column("setup")[:, 0]
        for row in np.unique(order):
            now = order == row
            before = (order == row - 1) & (setup == setup[now][0])
            if abs(t[now][0]) > values["breakaway joint-1 N*m"]:
                side[now] = np.sign(t[now])
            elif before.any():
                side[now] = side[before][0]
        assert (side != DAY.direction[:, 0]).any() and (side == DAY.direction[:, 0]).any()
        return DAY.turned(1, values["gap joint-1 rad"] / 2 * side)

    check(DAY, joint.backlash(1, breakaway=0.2), 1.0, expected)


def test_backlash_held_by_torque_alone_or_by_motion_alone() -> None:
    gap = 1.5e-4
    by_torque, by_motion = DAY.turned(1, gap / 2 * np.sign(DAY.torque(1))), DAY.turned(5, gap / 2 * DAY.direction[:, 4])
    loaded = DAY.column("state")[:, 0] > 0  # axis 1 stands upright: without load no torque but rounding
    wear, _ = joint.backlash(1, breakaway=0.0).apply(DAY.cell.healthy, DAY.cell.arm, 1.5)
    loaded &= np.abs(DAY.torque(1)) > 1
    np.testing.assert_allclose(DAY.change(wear)[loaded], by_torque[loaded], atol=0.01 * np.abs(by_torque).max())
    check(DAY, joint.backlash(5, breakaway=np.inf), 1.5, lambda v: by_motion)


def test_coupling_turns_each_joint_by_the_torque_of_the_other() -> None:
    def expected(values: Any) -> Array:
        (c,) = values.values()
        return DAY.turned(2, c * DAY.torque(3)) + DAY.turned(3, c * DAY.torque(2))

    check(DAY, joint.coupling(2, 3), 0.3, expected)

    def wrist(values: Any) -> Array:
        (c,) = values.values()
        return DAY.turned(5, c * DAY.torque(6)) + DAY.turned(6, c * DAY.torque(5))

    check(DAY, joint.coupling(5, 6), -0.5, wrist)


@pytest.mark.parametrize("arm", ARMS)
def test_posture_bump_and_cosine(arm: str) -> None:
    day = Day(arm)
    for k, shape in ((3, "bump"), (2, "cosine")):

        def expected(values: Any, k: int = k, shape: str = shape) -> Array:
            s, c, w = (
                values[f"{n} joint-{k} {u}"] for n, u in (("amplitude", "1"), ("centre", "rad"), ("width", "rad"))
            )
            x = day.q[:, k - 1] - c
            more = np.exp(-((x / w) ** 2) / 2) if shape == "bump" else np.cos(x) ** 2  # (1 + cos 2x) / 2
            assert np.ptp(more) > 0.2
            return day.turned(k, s * more * day.torque(k) / day.cell.stiffness[k - 1])

        check(day, joint.posture(k, shape), 0.2, expected)


@pytest.mark.parametrize("arm", ARMS)
def test_kinematic_offsets_are_there_without_load(arm: str) -> None:
    day = Day(arm)
    sign = day.cell.arm.axis[2, 2]
    check(day, body.zero(3), 1.5, lambda v: day.turned(3, np.full(len(day.q), v["zero joint-3 rad"])))
    assert sign in (-1, 1)

    def askew(v: Any) -> Array:
        R, origin = day.frames[:, 3, :3, :3], day.frames[:, 3, :3, 3]
        xyz, rpy = (
            [v[f"{c} link-3 {u}"] for c in names] for names, u in (("xyz", "m"), (("roll", "pitch", "yaw"), "rad"))
        )
        moved = R @ np.array(xyz) + np.cross(R @ np.array(rpy), day.point - origin)
        return np.where((day.on >= 3)[:, None], moved, 0)

    check(day, body.geometry(3), 1.0, askew)


@pytest.mark.parametrize("arm", ARMS)
def test_strut_turns_joint_2_by_the_slope_of_its_energy(arm: str) -> None:
    day = Day(arm)
    wear, _ = body.strut().apply(day.cell.healthy, day.cell.arm, 0.1)
    strut, h = wear.strut, 1e-6
    assert strut is not None
    origin, axis = day.axis(2)
    inner, outer = day.at(1, strut.inner), day.at(2, strut.outer)

    def energy(angle: float) -> Array:
        arm_2 = outer - origin
        turned = arm_2 + angle * np.cross(axis, arm_2) + angle**2 / 2 * np.cross(axis, np.cross(axis, arm_2))
        return strut.stiffness / 2 * (np.linalg.norm(origin + turned - inner, axis=1) - strut.length) ** 2

    torque = -(energy(h) - energy(-h)) / (2 * h)
    check(day, body.strut(), 0.1, lambda v: day.turned(2, torque / day.cell.stiffness[1]))


@pytest.mark.parametrize("arm", ARMS)
def test_payload_follows_its_weight_in_every_joint(arm: str) -> None:
    day = Day(arm)

    def expected(v: Any) -> Array:
        com, weight = day.at(6, np.array([0.06, -0.03, 0.15])), np.array([0, 0, -9.80665 * v["mass tool kg"]])
        total = np.zeros_like(com)
        for k in range(1, 7):
            origin, axis = day.axis(k)
            torque = np.sum(axis * np.cross(com - origin, weight), axis=1)
            total += day.turned(k, torque / day.cell.stiffness[k - 1])
        return total

    check(day, body.payload(), 0.5, expected)


@pytest.mark.parametrize("arm", ARMS)
def test_base_rocks_as_one_body_about_its_pivot(arm: str) -> None:
    day = Day(arm)

    def expected(v: Any) -> Array:
        pivot = np.array([0, 0, -v["depth base m"]])
        force, moment = day.wrench(0, np.broadcast_to(pivot, day.point.shape))
        *C, _ = v.values()
        tilt = np.array(C[3:]) * moment
        assert (day.on == 0).any()
        return np.array(C[:3]) * force + np.cross(tilt, day.point - pivot)

    change = check(day, body.base(), 0.2, expected)
    assert np.abs(change[day.on == 0]).max() > 2e-6  # the pedestal moves as well


@pytest.mark.parametrize(("arm", "k"), [("abb-irb6600-175-255", 2), ("abb-irb6600-175-255", 4), ("ur10", 3)])
def test_link_bends_and_twists_inside(arm: str, k: int) -> None:
    day = Day(arm)

    def expected(v: Any) -> Array:
        bodies = day.frames[:, k - 1] @ day.cell.arm.before[k - 1]
        turn = day.cell.arm.axis[k - 1, 2] * day.q[:, k - 1]
        c, s, z, o = np.cos(turn), np.sin(turn), np.zeros_like(turn), np.ones_like(turn)
        R = bodies[:, :3, :3] @ np.moveaxis(np.array([[c, -s, z], [s, c, z], [z, z, o]]), 2, 0)
        hinge = bodies[:, :3, 3] + R @ (0.6 * day.cell.arm.after[k - 1][:3, 3])
        moment = np.einsum("nij,ni->nj", R, day.wrench(k, hinge)[1])
        tilt = np.einsum("nij,nj->ni", R, np.array(list(v.values())) * moment)
        return np.where((day.on >= k)[:, None], np.cross(tilt, day.point - hinge), 0)

    check(day, body.link(k), 0.5, expected)


@pytest.mark.parametrize("arm", ARMS)
def test_tool_yields_in_six_directions(arm: str) -> None:
    day = Day(arm)

    def expected(v: Any) -> Array:
        C = np.zeros((6, 6))
        for name, value in v.items():
            i, j = (int(d) for d in name.split()[2])
            C[i, j] = C[j, i] = value
        R, origin = day.frames[:, 6, :3, :3], day.frames[:, 6, :3, 3]
        local = np.hstack([np.einsum("nij,ni->nj", R, w) for w in day.wrench(6, origin)])
        moved = local @ C
        shift, tilt = (np.einsum("nij,nj->ni", R, part) for part in (moved[:, :3], moved[:, 3:]))
        return np.where((day.on == 6)[:, None], shift + np.cross(tilt, day.point - origin), 0)

    check(day, body.tool(), 1.0, expected)


@pytest.mark.parametrize("arm", ARMS)
def test_links_grow_with_temperature(arm: str) -> None:
    day = Day(arm)
    warm = day.column("temperature")[:, 0] - 20
    assert np.ptp(warm) > 4
    # one temperature per state: that of its first reading
    first = np.unique(np.hstack([day.column("setup"), day.column("state")]), axis=0, return_index=True)[1]
    np.testing.assert_allclose(warm[first] + 20, [climate(t) for t in day.column("time")[first, 0]], atol=1e-12)

    def expected(v: Any) -> Array:
        total = np.zeros_like(day.point)
        for k in (1, 2, 3, 4, 5, 6):
            bodies = day.frames[:, k - 1] @ day.cell.arm.before[k - 1]
            length = day.frames[:, k, :3, 3] - bodies[:, :3, 3]
            total += np.where((day.on >= k)[:, None], v[f"growth link-{k} 1/K"] * warm[:, None] * length, 0)
            if k < 6:  # what is left of link k before the next joint
                onward = day.axis(k + 1)[0] - day.frames[:, k, :3, 3]
                total += np.where((day.on > k)[:, None], v[f"growth link-{k} 1/K"] * warm[:, None] * onward, 0)
        return total

    check(day, body.thermal((1, 2, 3, 4, 5, 6)), 1.0, expected, close=0.02)
    creep = 5e-6 * warm
    both = body.thermal((2,), 2).apply(day.cell.healthy, day.cell.arm, 1.0)[0]
    alone = body.thermal((2,)).apply(day.cell.healthy, day.cell.arm, 1.0)[0]
    wanted = day.turned(2, creep)
    np.testing.assert_allclose(day.change(both) - day.change(alone), wanted, atol=0.01 * np.abs(wanted).max())


@pytest.mark.parametrize("settling", [np.inf, 3000.0])
def test_tracker_wanders_with_the_clock_and_takes_the_pedestal_along(settling: float) -> None:
    time = DAY.column("time")
    since = time if settling == np.inf else settling * (1 - np.exp(-time / settling))

    def expected(v: Any) -> Array:
        speed, rate = (np.array([v[f"{s}{c} tracker {u}"] for c in "xyz"]) for s, u in (("v", "m/s"), ("w", "rad/s")))
        return since * (speed + np.cross(rate, DAY.point - [3.0, -1.0, 0.2]))

    change = check(DAY, instrument.tracker(settling), 2.0, expected, close=1e-3)
    late = (DAY.on == 0) & (time[:, 0] > 0.8 * time.max())
    assert np.linalg.norm(change[late], axis=1).min() > 2e-5


def test_zero_of_a_joint_that_turns_the_other_way() -> None:
    arm = small_arms.chain([np.eye(4)], [[0, 0, -1]], [shift((1, 0, 0))])
    wear = replace(Wear.healthy(np.array([1e6])), zeros=np.array([1e-3]))
    tip = WornPlant(arm, wear, gravity_on=False).walk([[0.2]]).tcp[0, :2, 3]
    np.testing.assert_allclose(tip, [np.cos(0.201), -np.sin(0.201)], atol=1e-12)
