"""Play, breakaway and last turn along a path against numbers worked out by hand."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from . import Memory, Plant, Tool, small_arms
from .geometry import placement, pose_error

GAP = 1e-4


def single(**more: Any) -> Plant:
    """One weightless joint without springs, link 1 m."""
    given = {"stiffness": np.inf, "gap": GAP, "gravity_on": False, **more}
    return Plant(small_arms.planar([1.0]), **given)


def test_play_by_hand() -> None:
    moves = np.array([3.0, -0.4, -0.3, 0.0, -0.2, -1.0, 0.5, 0.8]) * GAP
    walk = single().walk(np.cumsum(moves)[:, None], start=[0.0])
    by_hand = [0.5, 0.1, -0.2, -0.2, -0.4, -0.5, 0.0, 0.5]
    np.testing.assert_allclose(walk.play[:, 0] / GAP, by_hand, atol=1e-12)
    np.testing.assert_allclose(walk.q_act - walk.q_cmd, walk.play, atol=1e-15)
    np.testing.assert_array_equal(walk.direction[:, 0], [1, -1, -1, -1, -1, -1, 1, 1])
    np.testing.assert_allclose(walk.deflection[:, 2], walk.play[:, 0] * np.cos(walk.q_cmd[:, 0]), atol=1e-8)


def test_other_side() -> None:
    walk = single(side_sign=-1.0).walk([[0.1], [0.1 - 0.3 * GAP], [0.0]], start=[0.0])
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [-0.5, -0.2, 0.5], atol=1e-9)


def test_a_trembling_command_is_no_reversal() -> None:
    q = np.array([[0.1], [0.1 - 4e-10], [0.1 - 8e-10], [0.1 - 12e-10]])
    walk = single().walk(q, start=[0.0])
    np.testing.assert_array_equal(walk.direction[:, 0], [1, 1, 1, -1])
    walk = single(still=1e-6).walk(q, start=[0.0])
    np.testing.assert_array_equal(walk.direction[:, 0], [1, 1, 1, 1])


def test_breakaway_of_nothing_ends() -> None:
    # every torque holds its flank, and over the top the side of the torque depends on the play itself
    arm = small_arms.planar([1.0], mass=[10.0], com=[[0, 0, 0]])
    plant = Plant(arm, stiffness=1e7, gap=GAP, breakaway=0.0)
    walk = plant.walk(np.pi / 2 + GAP * np.array([[-1.0], [-0.2], [0.2], [1.0]]), start=[1.5])
    np.testing.assert_allclose(walk.play[[0, 3], 0] / GAP, [-0.5, 0.5], atol=1e-12)
    np.testing.assert_allclose(np.abs(walk.play[:, 0]) / GAP, 0.5, atol=1e-12)


def test_start_unknown_is_the_middle() -> None:
    walk = single().walk([[0.3], [0.3], [0.3 + 0.2 * GAP]])
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [0, 0, 0.2], atol=1e-9)
    np.testing.assert_array_equal(walk.direction[:, 0], [0, 0, 1])


def test_breakaway_holds_the_flank_of_the_torque() -> None:
    plant = single(breakaway=50.0)
    forces = np.array([0.0, -49.0, -51.0, -49.0, 51.0, 0.0, 0.0])
    commands = np.array([0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1 - 0.25 * GAP])
    wrench = np.zeros((7, 6))
    wrench[:, 4] = -forces  # joint about -y: a moment about -y lifts
    walk = plant.walk(commands[:, None], wrench, start=[0.0])
    np.testing.assert_allclose(walk.torque[:, 0], forces, atol=1e-9)
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [0.5, 0.5, -0.5, -0.5, 0.5, 0.5, 0.25], atol=1e-9)


def test_held_flank_resists_motion() -> None:
    # the load keeps its flank through a reversal of the command
    walk = single(breakaway=50.0).walk([[0.1], [0.0], [0.2]], [0, 0, 0, 0, 80.0, 0], start=[0.0])
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [-0.5] * 3, atol=1e-12)
    np.testing.assert_array_equal(walk.direction[:, 0], [1, -1, 1])


def test_gravity_holds_a_flank_and_lets_go_over_the_top() -> None:
    # 10 kg at 1 m: torque -98 cos(q) N*m; breakaway 50 is left at |cos q| = 0.51
    arm = small_arms.planar([1.0], mass=[10.0], com=[[0, 0, 0]])
    plant = Plant(arm, stiffness=1e7, gap=GAP, breakaway=50.0)
    q = np.radians([0.0, 30.0, 58.0, 62.0, 90.0, 118.0, 122.0, 150.0])
    walk = plant.walk(q[:, None], start=[-0.5])
    np.testing.assert_allclose(walk.torque[:, 0], -98.0665 * np.cos(q), atol=0.05)
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [-0.5, -0.5, -0.5, 0.5, 0.5, 0.5, 0.5, 0.5], atol=1e-12)


def test_memory_goes_from_walk_to_walk() -> None:
    rng = np.random.default_rng(5)
    arm = small_arms.six_axis(tool=Tool((0, 0, 0.2), mass=20.0, com=(0, 0, 0.1)))
    gap = np.array([1, 2, 3, 4, 5, 6]) * 2e-5
    plant = Plant(arm, stiffness=1e6, ratio=0.8, gap=gap, breakaway=200.0)
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.6]) + np.cumsum(rng.normal(scale=5e-5, size=(30, 6)), axis=0)
    w = rng.normal(scale=[300, 300, 300, 30, 30, 30], size=(30, 6))
    whole = plant.walk(q, w, start=q[0] - 1e-3)
    first = plant.walk(q[:13], w[:13], start=q[0] - 1e-3)
    second = plant.walk(q[13:], w[13:], start=first.memory)
    np.testing.assert_allclose(np.vstack([first.tcp, second.tcp]), whole.tcp, atol=1e-12)
    inside = np.abs(whole.play) < 0.49 * gap
    assert 0.05 < np.mean(inside) < 0.95  # the path did go through gaps


def test_settled_memory() -> None:
    memory = Memory.settled([0.2], [-1.0], [GAP])
    walk = single().walk([[0.2], [0.2 + 0.6 * GAP]], start=memory)
    np.testing.assert_allclose(walk.play[:, 0] / GAP, [-0.5, 0.1], atol=1e-9)


def test_inverse_of_nominal() -> None:
    plant = Plant(small_arms.six_axis(tool=Tool((0.1, 0, 0.2), (0.1, 0.2, 0.3))), stiffness=1e6)
    rng = np.random.default_rng(7)
    for _ in range(20):
        q = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.6]) + rng.uniform(-0.3, 0.3, 6)
        back = plant.inverse(plant.nominal(q), q + rng.uniform(-0.05, 0.05, 6))
        np.testing.assert_allclose(back, q, atol=1e-11)
    with pytest.raises(ValueError, match="inverse kinematics"):
        plant.inverse(placement((9, 0, 0)), q)


def test_line_between_poses_is_straight_and_turns_joints_back() -> None:
    arm = small_arms.six_axis(tool=Tool((0, 0, 0.2)))
    plant = Plant(arm, stiffness=1e6, gap=1e-5, gravity_on=False)
    T0, T1 = (
        placement((1.1, -0.5, 0.8), (0, np.pi / 2, 0)),
        placement((1.1, 0.5, 0.8), (0, np.pi / 2 + 0.2, 0)),
    )
    seed = np.array([-0.4, 0.2, 0.4, 0.1, -0.5, 0])
    q0 = plant.inverse(T0, seed)
    q1 = plant.inverse(T1, plant.inverse(placement((1.1, 0, 0.8), (0, np.pi / 2 + 0.1, 0)), q0))
    fine = plant.run([q0, q1], start=q0, interpolate=20, keep_between=True)
    assert fine.knot.sum() == 2 and len(fine.knot) == 21
    np.testing.assert_allclose(fine.nominal[:, 0, 3], 1.1, atol=1e-11)
    np.testing.assert_allclose(fine.nominal[:, 1, 3], np.linspace(-0.5, 0.5, 21), atol=1e-11)
    assert max(pose_error(fine.nominal[-1], T1)) < 1e-11
    # in and out again: joints 2 and 3 reverse halfway, which the two poses alone do not show
    coarse, between = plant.run([q0, q1], start=q0), plant.run([q0, q1], start=q0, interpolate=20)
    assert len(between.tcp) == 2
    np.testing.assert_allclose(between.play[1], fine.play[-1], atol=1e-15)
    turned = np.sign(np.diff(fine.q_cmd, axis=0))
    reversing = np.any(turned[1:] * turned[:-1] < 0, axis=0)
    assert reversing.any()
    np.testing.assert_array_equal(between.direction[1], turned[-1])
    assert np.any(coarse.direction[1] != between.direction[1])


def test_load_fades_between_two_poses() -> None:
    # joint 1 turns by two gaps while its torque fades from -1000 to 0: held until it is below 250 N*m after
    # 7 of 10 steps, then carried along by the last 3, 0.2 gaps each
    plant = Plant(small_arms.six_axis(), stiffness=1e9, gap=GAP, breakaway=250.0, gravity_on=False)
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.6])
    path = [q, q + 2 * GAP * np.eye(6)[0]]
    wrench = np.array([[0, 0, 0, 0, 0, -1000.0], np.zeros(6)])
    fine = plant.run(path, wrench, start=q, interpolate=10, keep_between=True)
    np.testing.assert_allclose(fine.torque[:, 0], np.linspace(-1000, 0, 11), atol=1e-6)
    by_hand = [-0.5] * 8 + [-0.3, -0.1, 0.1]
    np.testing.assert_allclose(fine.play[:, 0] / GAP, by_hand, atol=1e-4)
    ends = plant.run(path, wrench, start=q, interpolate=10)
    np.testing.assert_allclose(ends.tcp, fine.tcp[fine.knot], atol=1e-12)
    assert plant.walk(path, wrench, start=q).play[1, 0] == pytest.approx(GAP / 2)


def test_three_hundred_poses(record_property: Callable[[str, object], None]) -> None:
    arm = small_arms.six_axis(tool=Tool((0, 0, 0.2), mass=30.0, com=(0, 0, 0.1)))
    plant = Plant(arm, stiffness=1e6, ratio=0.8, gap=1e-4, breakaway=100.0, tool_spring=[1e7] * 3 + [1e6] * 3)
    angle = np.linspace(0, 2 * np.pi, 300)
    q = np.array([0, 0.2, 0.3, 0.1, 0.8, 0]) + 0.05 * np.sin(angle[:, None] + np.arange(6))
    began = time.perf_counter()
    walk = plant.walk(q, [400, -300, -900, 5, 5, 5])
    record_property("seconds", time.perf_counter() - began)
    assert np.isfinite(walk.tcp).all() and np.max(np.linalg.norm(walk.deflection, axis=1)) > 1e-4
