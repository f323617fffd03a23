"""Closed-form inverse kinematics: round trips, branches, turns, limits, singular and unreachable poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffness.errors import RobotError
from stiffness.kinematics.inverse import pose_error
from stiffness.kinematics.solver import inverse_kinematics
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.poses import PoseArray
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.robot.robot import Robot

BUILTIN = tuple(n for n in builtin_robots() if n != "ur10")
URDFS = (
    "abb_irb6600_225_255", "abb_irb6640_185_280", "fanuc_official_m710ic_50", "kuka_kr120r2500pro",
    "kuka_kr210_r2700_2", "motoman_mh50", "staubli_rx160",
)  # fmt: skip


@pytest.fixture(scope="module", params=BUILTIN + URDFS)
def robot(request: pytest.FixtureRequest) -> Robot:
    if request.param in BUILTIN:
        return load_robot(request.param)
    shared: Path = request.getfixturevalue("shared")
    return load_robot(str(shared / "data/robots" / f"{request.param}.urdf"))


@pytest.fixture(scope="module")
def abb() -> Robot:
    return load_robot("abb-irb6600-175-255")


def poses_of(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    poses = np.array([robot.pose(row) for row in q])
    return poses[:, :3, :3], poses[:, :3, 3]


def test_round_trip_and_all_branches(robot: Robot) -> None:
    """Every branch takes up the pose, no two are alike, and the posture that made the pose is among them."""
    inverse = inverse_kinematics(robot)
    counts = []
    for q in np.random.default_rng(1).uniform(-np.pi, np.pi, (150, 6)):
        pose = robot.pose(q)
        found = inverse.all(pose, limits=False)
        assert max(pose_error(robot, other, pose) for _, other in found) < 1e-12
        assert min(np.abs(other - q).max() for _, other in found) < 1e-6
        assert [b for b, _ in found] == sorted({b for b, _ in found})
        for branch, other in found:
            assert inverse.configuration(other[None])[0] == branch
        counts.append(len(found))
    assert max(counts) == 8
    assert set(counts) <= {4, 8}  # an arm without lateral offset always has both shoulders or none in reach


def test_turns_are_those_within_limits(robot: Robot) -> None:
    """Against counting: every sum of the branch and whole turns that lies within the limits, no other."""
    inverse = inverse_kinematics(robot)
    for q in np.random.default_rng(2).uniform(robot.lower, robot.upper, (20, 6)):
        pose = robot.pose(q)
        expected = 0
        for _, one in inverse.all(pose, limits=False):
            turned = one[:, None] + 2 * np.pi * np.arange(-3, 4)
            expected += np.prod(
                ((turned >= robot.lower[:, None]) & (turned <= robot.upper[:, None])).sum(axis=1)
            )
        found = inverse.all(pose, limits=True)
        assert len(found) == expected > 0
        for _, other in found:
            assert ((other >= robot.lower) & (other <= robot.upper)).all()
        assert min(np.abs(other - q).max() for _, other in found) < 1e-6


def test_along_follows_joint_motion_over_many_turns(abb: Robot) -> None:
    """Joint 6 sweeps 550 deg and joint 4 crosses 180 deg: no jump, and the path comes out as it went in."""
    t = np.linspace(0, 1, 4001)[:, None]
    start, end = np.radians([-150, -40, -20, 100, 20, -280]), np.radians([160, 40, 30, 260, 110, 270])
    q = start + t * (end - start)
    inverse = inverse_kinematics(abb)
    batch = inverse.along(PoseArray(*poses_of(abb, q)), int(inverse.configuration(q[:1])[0]), q[0])
    assert batch.ok.all()
    np.testing.assert_allclose(batch.q, q, atol=1e-9)
    assert (batch.limit_margin >= 0).all()


def test_along_seed_picks_the_turn(abb: Robot) -> None:
    q = np.radians([[10.0, 20, 10, 40, 50, 30]])
    inverse = inverse_kinematics(abb)
    rotation, origin = poses_of(abb, q)
    for turns in (-1, 0, 1):
        seed = q[0] + [0, 0, 0, 0, 0, 2 * np.pi * turns]
        np.testing.assert_allclose(inverse.along(PoseArray(rotation, origin), 0, seed).q[0], seed, atol=1e-12)
        np.testing.assert_allclose(inverse.along(PoseArray(rotation, origin), 0, seed[None]).q[0], seed, atol=1e-12)
    np.testing.assert_allclose(inverse.along(PoseArray(rotation, origin), 0).q, q, atol=1e-12)
    beyond = inverse.along(PoseArray(rotation, origin), 0, q[0] + [0, 0, 0, 0, 0, 2 * np.pi])
    assert beyond.ok.all()
    assert beyond.limit_margin[0, 5] == pytest.approx(np.radians(300 - 390))


def test_branches_by_pose(robot: Robot) -> None:
    """Each pose with its own branch label gives back the posture that made it."""
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (500, 6))
    inverse = inverse_kinematics(robot)
    batch = inverse.along(PoseArray(*poses_of(robot, q)), inverse.configuration(q), q)
    assert batch.ok.all()
    wrist, elbow = inverse.singularity(q)["wrist"], inverse.singularity(q)["elbow"]
    regular = (wrist > 0.01) & (elbow > 0.01)
    assert regular.sum() > 400
    assert np.abs(batch.q - q)[regular].max() < 1e-9
    for k in range(0, 500, 25):
        assert pose_error(robot, batch.q[k], robot.pose(q[k])) < 1e-12


def test_branch_bits_are_abb_configurations(abb: Robot) -> None:
    """RAPID reference, confdata: 0 in front, in front, positive; +1 axis 5 negative, +2 behind the lower
    arm, +4 behind axis 1."""
    postures = {
        0: [0.0, 0, 0, 0, 30, 0],
        1: [0.0, 0, 0, 0, -30, 0],
        2: [0.0, 60, -130, 0, 30, 0],  # forearm folded back behind the lower arm, still in front of axis 1
        3: [0.0, 60, -130, 0, -30, 0],
        6: [0.0, -60, -130, 0, 30, 0],  # lower arm back, forearm folded back too: behind axis 1
        7: [0.0, -60, -130, 0, -30, 0],
        4: [0.0, -65, -60, 0, 30, 0],  # behind axis 1, forearm before the lower arm
    }
    inverse = inverse_kinematics(abb)
    for label, degrees in postures.items():
        assert inverse.configuration(np.radians([degrees]))[0] == label


def test_unreachable_poses_are_said(abb: Robot) -> None:
    inverse = inverse_kinematics(abb)
    forward = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], dtype=float)
    # axis 2 stands at x = 0.32, z = 0.78; the wrist centre reaches 1.075 + hypot(0.2, 1.142) m from it
    origin = np.array(
        [[1.662, 0, 2.055], [4.0, 0, 0.78], [0.2, 0.0, 3.0], [0.2 + 0.4, 0, 0.8], [1.5, 0.2, 1.2]]
    )
    batch = inverse.along(PoseArray(np.tile(forward, (5, 1, 1)), origin), 0, np.zeros(6))
    assert np.isfinite(batch.q).all()
    assert batch.ok.tolist() == [False, False, False, False, True]
    assert "axes 4 and 6 in line" in batch.why(0)
    assert "too far away" in batch.why(1)
    assert batch.reach[1] == pytest.approx(1.075 + np.hypot(0.2, 1.142) - (4.0 - 0.2 - 0.32), abs=1e-12)
    assert "wrist centre on axis 1" in batch.why(2)
    assert "too close" in batch.why(3)
    assert batch.why(4) == ""
    for k in (1, 3):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = forward, origin[k]
        assert inverse.all(pose) == []


def test_near_the_edge_of_reach(abb: Robot) -> None:
    """1 nm inside it is solved to 1e-9 m, 1 nm outside it is refused."""
    inverse = inverse_kinematics(abb)
    full = 1.075 + np.hypot(0.2, 1.142)
    down = np.diag([1.0, -1, -1])
    for gap, solved in ((1e-9, True), (-1e-9, False)):
        origin = np.array([[0.32 + full - gap, 0, 0.78 - 0.2]])
        batch = inverse.along(PoseArray(down[None], origin), 0, np.zeros(6))
        assert batch.ok[0] == solved
        assert batch.reach[0] == pytest.approx(gap, abs=1e-14)
        if solved:
            assert np.linalg.norm(abb.pose(batch.q[0])[:3, 3] - origin[0]) < 1e-9


def test_singularity_measures_vanish_where_the_arm_is_singular(abb: Robot) -> None:
    inverse = inverse_kinematics(abb)
    regular = np.radians([20.0, 10, 15, 30, 50, 10])
    wrist, elbow = regular.copy(), regular.copy()
    wrist[4] = 0.0
    elbow[2] = -np.arctan2(1.142, 0.2)  # forearm in line with the lower arm
    measures = inverse.singularity(np.array([regular, wrist, elbow]))
    assert measures["wrist"] == pytest.approx([np.sin(np.radians(50)), 0, np.sin(np.radians(50))], abs=1e-12)
    assert measures["elbow"][2] == pytest.approx(0, abs=1e-12)
    assert measures["elbow"][:2].min() > 0.5
    assert measures["jacobian"][0] > 0.05
    assert measures["jacobian"][1:].max() < 1e-12
    q2, q3 = np.radians([10.0, 15])
    ahead = 0.32 + 1.075 * np.sin(q2) + 0.2 * np.sin(q2 + q3) + 1.142 * np.cos(q2 + q3)
    assert measures["shoulder"][0] == pytest.approx(ahead, rel=1e-12)
    assert set(inverse.singularity(regular[None], jacobian=False)) == {"wrist", "elbow", "shoulder"}


def test_jacobian_measure_is_the_smallest_singular_value(abb: Robot) -> None:
    """Linear rows in units of half the chain, on Pinocchio's Jacobian."""
    q = np.radians([[20.0, 10, 15, 30, 50, 10], [-40, 30, -60, 100, -80, 10]])
    length = (np.hypot(0.78, 0.32) + 1.075 + 0.2 + 1.142 + 0.2) / 2
    for row, value in zip(q, inverse_kinematics(abb).singularity(q)["jacobian"], strict=True):
        scaled = abb.jacobian(row) / np.array([length] * 3 + [1.0] * 3)[:, None]
        assert value == pytest.approx(np.linalg.svd(scaled)[1][-1], rel=1e-9)


def test_home_is_listed_with_joint_4_at_zero(abb: Robot) -> None:
    """q5 = 0 leaves joints 4 and 6 open; one posture of the family stands for all."""
    found = inverse_kinematics(abb).all(abb.pose(np.zeros(6)))
    assert min(np.abs(q).max() for _, q in found) < 1e-9


def test_empty_path_and_refusals(abb: Robot) -> None:
    inverse = inverse_kinematics(abb)
    assert isinstance(inverse, SphericalInverse)
    assert inverse.along(PoseArray(np.zeros((0, 3, 3)), np.zeros((0, 3))), 0, np.zeros(6)).q.shape == (0, 6)
    one = np.eye(3)[None], np.array([[1.5, 0.0, 1.0]])
    with pytest.raises(RobotError, match=r"branch 8\.\.8: abb-irb6600-175-255 has 0\.\.7"):
        inverse.along(PoseArray(*one), 8)
    with pytest.raises(RobotError, match="pose 0 of the path is not finite"):
        inverse.along(PoseArray(one[0], one[1] * np.nan), 0)
    with pytest.raises(RobotError, match="poses are"):
        inverse.along(PoseArray(one[0], one[1][0]), 0)
    with pytest.raises(RobotError, match="seed"):
        inverse.along(PoseArray(*one), 0, np.array([0.0, np.nan, 0, 0, 0, 0]))
    with pytest.raises(RobotError, match="branch is a whole number"):
        inverse.along(PoseArray(*one), np.array([0.5]))
