"""Equilibria of the plant against textbook cases and energy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from . import Load, Pieces, Plant, Stiffening, Tool, small_arms

G = 9.80665


def test_single_joint_spring_angle() -> None:
    # follower-free force F at the end of a link L: K a = F L cos(a)
    plant = Plant(small_arms.planar([1.5]), stiffness=2e5, gravity_on=False)
    walk = plant.walk([[0.0]], [0, 0, 400.0, 0, 0, 0])
    angle = brentq(lambda a: 2e5 * a - 400 * 1.5 * np.cos(a), 0, 0.1, xtol=1e-16)
    assert angle == pytest.approx(0.003, rel=1e-4)
    assert walk.q_act[0, 0] == pytest.approx(angle, abs=1e-13)
    np.testing.assert_allclose(
        walk.tcp[0, :3, 3], 1.5 * np.array([np.cos(angle), 0, np.sin(angle)]), atol=1e-13
    )
    np.testing.assert_allclose(walk.deflection[0], walk.tcp[0, :3, 3] - [1.5, 0, 0], atol=1e-14)
    assert walk.torque[0, 0] == pytest.approx(2e5 * angle, abs=1e-7)


def test_pull_along_a_link_stiffens_and_push_softens() -> None:
    # first order with the complementary stiffness: a = M / (K + F L), F > 0 pulling outwards
    plant = Plant(small_arms.planar([2.0]), stiffness=1e5, gravity_on=False)
    for force in (3e3, -3e3):
        walk = plant.walk([[0.0]], [force, 0, 0, 0, -50.0, 0])
        angle = brentq(lambda a, f=force: 1e5 * a + f * 2 * np.sin(a) - 50, -0.1, 0.1, xtol=1e-16)
        assert angle == pytest.approx(50 / (1e5 + 2 * force), rel=1e-5)
        assert walk.q_act[0, 0] == pytest.approx(angle, abs=1e-13)


def test_two_link_cantilever() -> None:
    # tip force and moment small against K: v = F L^2 / K1 + F L2^2 / K2 + M (L / K1 + L2 / K2), L = L1 + L2
    length, k, force, moment = [0.8, 0.5], np.array([4e8, 1e8]), 30.0, 20.0
    walk = Plant(small_arms.planar(length), stiffness=k, gravity_on=False).walk(
        [[0.0, 0.0]], [0, 0, force, 0, -moment, 0]
    )
    lever = np.array([1.3, 0.5])
    expected = np.sum((force * lever + moment) * lever / k)
    assert expected > 2e-7
    assert walk.deflection[0, 2] == pytest.approx(expected, rel=1e-6)


def test_gravity_sag_of_links_and_tool() -> None:
    # a = -sum of weights times levers, from the law of a horizontal beam with two hinges, exactly solved
    tool = Tool((0.2, 0, 0), mass=8.0, com=(0.1, 0, 0))
    arm = small_arms.planar([1.0, 0.6], mass=[20.0, 10.0], com=[[-0.5, 0, 0], [-0.2, 0, 0]], tool=tool)
    k = np.array([3e4, 1e4])
    walk = Plant(arm, stiffness=k).walk([[0.3, -0.5]])
    a1, a2 = walk.q_act[0, 0], walk.q_act[0, 0] + walk.q_act[0, 1]
    m2 = G * np.cos(a2) * (10 * 0.4 + 8 * 0.7)
    m1 = G * np.cos(a1) * (20 * 0.5 + 10 * 1.0 + 8 * 1.0) + m2
    np.testing.assert_allclose(walk.q_act[0] - [0.3, -0.5], [-m1 / k[0], -m2 / k[1]], atol=1e-13)
    assert m1 > 250
    tip = [np.cos(a1) + 0.8 * np.cos(a2), 0, np.sin(a1) + 0.8 * np.sin(a2)]
    np.testing.assert_allclose(walk.tcp[0, :3, 3], tip, atol=1e-13)
    np.testing.assert_allclose(
        walk.points(1, (-0.25, 0, 0))[0], 0.75 * np.array([np.cos(a1), 0, np.sin(a1)]), atol=1e-13
    )


def test_calibrated_out_leaves_the_process_only() -> None:
    mass = {"mass": [20.0, 10.0], "com": [[-0.5, 0, 0], [-0.2, 0, 0]]}
    k, q = [3e5, 1e5], [[0.3, -0.5], [1.0, 0.7]]
    free = Plant(small_arms.planar([1.0, 0.6], **mass), stiffness=k, calibrated_out=True)
    idle, loaded = free.walk(q), free.walk(q, [0, 0, -300, 0, 0, 0])
    np.testing.assert_allclose(idle.tcp, idle.nominal, atol=1e-14)
    assert np.min(np.abs(idle.torque)) > 5  # gravity still acts in the joints
    raw = Plant(small_arms.planar([1.0, 0.6], **mass), stiffness=k)
    raw_idle, raw_loaded = raw.walk(q), raw.walk(q, [0, 0, -300, 0, 0, 0])
    moved = raw_loaded.tcp[:, :3, 3] - raw_idle.tcp[:, :3, 3]
    np.testing.assert_allclose(loaded.deflection, moved, atol=1e-14)
    at = (-0.3, 0.1, 0.2)
    np.testing.assert_allclose(
        loaded.points(1, at) - idle.points(1, at),
        raw_loaded.points(1, at) - raw_idle.points(1, at),
        atol=1e-14,
    )
    assert np.max(np.abs(raw_idle.deflection)) > 2e-4


def test_softening_is_against_the_last_turn_only() -> None:
    plant = Plant(small_arms.planar([1.0]), stiffness=1e6, ratio=0.7, gravity_on=False)
    up = [0, 0, 100.0, 0, 0, 0]
    lifted = plant.walk([[0.01], [0.0]], [up, up], start=[0.0])  # turns up, then down
    np.testing.assert_allclose(lifted.q_act[:, 0] - [0.01, 0], [1e-4, 1e-4 / 0.7], rtol=1e-4)
    unknown = plant.walk([[0.0]], up)
    assert unknown.direction[0, 0] == 0
    assert unknown.q_act[0, 0] == pytest.approx(1e-4, rel=1e-4)


def test_pieces_and_smooth_stiffening() -> None:
    pieces = Pieces(np.array([[1e5, 2e5, 5e5]]), np.array([[50.0, 150.0]]))
    plant = Plant(small_arms.planar([1.0]), stiffness=np.inf, hardening=pieces, gravity_on=False)
    for force, angle in ((20, 2e-4), (100, 5e-4 + 2.5e-4), (-250, -(5e-4 + 5e-4 + 2e-4))):
        walk = plant.walk([[0.0]], [0, 0, force, 0, 0, 0])
        # the lever shortens with the cosine, less than 1e-6 of it
        assert walk.q_act[0, 0] == pytest.approx(angle, rel=2e-6)
    smooth = Stiffening(np.array([1e5]), np.array([3e2]))
    h = 1e-3
    slope = [
        (smooth(np.array([t + h]), np.zeros(1)) - smooth(np.array([t - h]), np.zeros(1)))[0] / (2 * h)
        for t in (-200.0, 30.0)
    ]
    np.testing.assert_allclose(1 / np.array(slope), [1e5 + 300 * 200, 1e5 + 300 * 30], rtol=1e-8)


def test_tool_spring_in_the_tool_frame() -> None:
    # a rigid arm: TCP 0.2 m out of the flange; force along flange x bends about y: d = F / kx + F l^2 / ky
    tool = Tool((0, 0, 0.2))
    spring = [2e7, 3e7, 4e7, 5e5, 6e5, 7e5]
    arm = small_arms.six_axis(tool=tool)
    plant = Plant(arm, stiffness=np.inf, tool_spring=spring, gravity_on=False)
    q = np.array([0.3, -0.2, 0.4, 0.8, 0.9, -1.1])
    R = plant.nominal(q)[:3, :3]
    force = 1000.0
    for axis, bending, expected in (
        (0, 6e5, force / 2e7 + force * 0.04 / 6e5),
        (1, 5e5, force / 3e7 + force * 0.04 / 5e5),
        (2, np.inf, force / 4e7),
    ):
        walk = plant.walk([q], np.concatenate([force * R[:, axis], np.zeros(3)]))
        local = R.T @ walk.deflection[0]
        assert local[axis] == pytest.approx(expected, rel=1e-5)
        angle = np.linalg.norm(walk.elastic[0, 3:])
        assert angle == pytest.approx(force * 0.2 / bending, rel=1e-5)
        np.testing.assert_allclose(walk.q_act[0], q, atol=1e-15)
    walk = plant.walk([q], np.concatenate([np.zeros(3), 300 * R[:, 2]]))
    assert walk.elastic[0, 5] == pytest.approx(300 / 7e5, rel=1e-6)


def test_tool_spring_carries_last_link_and_tool() -> None:
    tool = Tool((0, 0, 0.2), mass=30.0, com=(0, 0, 0.1))
    arm = small_arms.six_axis(tool=tool)
    plant = Plant(arm, stiffness=np.inf, tool_spring=[1e7] * 3 + [1e6] * 3)
    walk = plant.walk([np.array([0, 0, 0, 0, 0, 0.0])])
    # flange z points along x of the base, flange x down: 42 kg hang on the slide, moments about y
    assert walk.elastic[0, 0] == pytest.approx(42 * G / 1e7, rel=1e-3)
    assert walk.elastic[0, 4] == pytest.approx((30 * 0.1 - 12 * 0.02) * G / 1e6, rel=1e-3)


def test_base_spring_moves_the_arm_as_one_body() -> None:
    arm = small_arms.six_axis()
    plant = Plant(arm, stiffness=np.inf, springs={0: [1e8, 1e8, 1e8, 4e6, 5e6, 6e6]}, gravity_on=False)
    walk = plant.walk([[0.4, 0.1, 0.2, 0, 0.5, 0]], [0, 800.0, 0, 0, 0, 0])
    p = walk.tcp[0, :3, 3]
    expected = np.array([-p[2] * 800 / 4e6, 0, p[0] * 800 / 6e6])
    np.testing.assert_allclose(walk.elastic[0, 3:], expected, atol=1e-6 * np.max(np.abs(expected)) + 2e-7)
    # a point on the pedestal moves too, and every distance within the arm stays
    assert walk.points(0, (0, 0, 0))[0, 1] == pytest.approx(8e-6, rel=1e-6)
    span = np.linalg.norm(walk.points(6, (0, 0, 0)) - walk.points(1, (0, 0, 0)))
    rigid = np.linalg.norm((walk.rigid[0, 6] - walk.rigid[0, 1])[:3, 3])
    assert span == pytest.approx(rigid, abs=1e-13)


def test_full_spring_couples() -> None:
    K = np.diag([1e7, 1e7, 1e7, 1e6, 1e6, 1e6])
    K[0, 4] = K[4, 0] = 2e6
    plant = Plant(small_arms.six_axis(), stiffness=np.inf, tool_spring=K, gravity_on=False)
    q = np.zeros(6)
    R = plant.nominal(q)[:3, :3]
    walk = plant.walk([q], np.concatenate([100 * R[:, 0], np.zeros(3)]))
    expected = np.linalg.solve(K, [100, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(walk.elastic[0], expected, rtol=1e-4, atol=1e-12)
    assert abs(expected[4]) > 1e-5


def test_load_on_another_link_leaves_outer_joints_alone() -> None:
    plant = Plant(small_arms.six_axis(), stiffness=1e6, gravity_on=False)
    q = np.array([0.2, 0.3, -0.4, 0.5, 0.6, 0.7])
    load = Load(3, np.array([0.1, 0.2, 0.3]), np.array([100.0, -200.0, 300.0]), np.array([10.0, 20.0, -30.0]))
    walk = plant.walk([q], loads=[[load]])
    np.testing.assert_array_equal(walk.torque[0, 3:], 0)
    # the torque of joint 1 by hand: moment about the base z axis at the deflected point
    p = walk.points(3, load.at)[0]
    assert walk.torque[0, 0] == pytest.approx(p[0] * -200 - p[1] * 100 - 30, abs=1e-9)
    assert np.min(np.abs(walk.torque[0, :3])) > 1


def test_work_of_a_slow_load_is_the_energy_stored() -> None:
    tool = Tool((0.02, 0.01, 0.2), mass=25.0, com=(0, 0, 0.1))
    k = np.array([1e6, 9e5, 7e5, 2e5, 1e5, 5e4])
    spring = np.array([2e7, 2e7, 3e7, 5e5, 5e5, 7e5])
    plant = Plant(small_arms.six_axis(tool=tool), stiffness=k, tool_spring=spring)
    q = np.array([0.4, 0.2, -0.3, 0.7, 0.9, -0.5])
    full = np.array([700.0, -400.0, -900.0, 0, 0, 0])
    steps = np.linspace(0, 1, 41)
    walk = plant.walk(np.tile(q, (41, 1)), steps[:, None] * full)
    mean_force = (walk.wrench[1:, :3] + walk.wrench[:-1, :3]) / 2
    work = np.sum(mean_force * np.diff(walk.tcp[:, :3, 3], axis=0))
    stored = []
    for row in (0, -1):
        deflection = walk.q_act[row] - q
        plant.scene.move(np.concatenate([walk.q_act[row], walk.elastic[row]]))
        stored.append(
            0.5 * k @ deflection**2 + 0.5 * spring @ walk.elastic[row] ** 2 + plant.scene.potential()
        )
    assert work > 0.5
    assert stored[1] - stored[0] == pytest.approx(work, rel=1e-6)


def test_closed_form_command_puts_the_tool_where_it_should_be() -> None:
    # joint springs only: command = wanted actual angles minus K^-1 (J^T W + gravity torque), exactly
    tool = Tool((0.02, 0.01, 0.2), mass=25.0, com=(0, 0, 0.1))
    k = np.array([1e6, 9e5, 7e5, 2e5, 1e5, 5e4])
    plant = Plant(small_arms.six_axis(tool=tool), stiffness=k)
    rng = np.random.default_rng(9)
    for _ in range(20):
        wanted = rng.uniform(-1, 1, 6)
        w = rng.normal(size=6) * [1e3, 1e3, 1e3, 50, 50, 50]
        pose = plant.nominal(wanted)
        command = wanted - (plant.scene.jacobian().T @ w + plant.scene.forces(())) / k
        walk = plant.walk([command], w)
        np.testing.assert_allclose(walk.tcp[0], pose, atol=1e-12)
        assert np.linalg.norm(walk.deflection) > 1e-4


def test_no_equilibrium_is_said() -> None:
    plant = Plant(small_arms.planar([1.0]), stiffness=1e6, gravity_on=False)
    with pytest.raises(ValueError, match="no equilibrium"):
        plant.walk([[0.0]], [0, 0, np.nan, 0, 0, 0])
