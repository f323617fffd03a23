"""Iterative inverse kinematics, arms without a spherical wrist: UR10 against its closed form, CRX-10iA/L."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffness.errors import RobotError
from stiffness.kinematics.inverse import pose_error
from stiffness.kinematics.iterative import IterativeInverse
from stiffness.kinematics.solver import inverse_kinematics
from stiffness.poses import PoseArray
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from tests.oracles.ur10_postures import closed_form

START = np.array([0.3, -1.2, 1.4, -1.5, -1.3, 0.4])


def apart(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max())


@pytest.fixture(scope="module")
def ur() -> Robot:
    return load_robot("ur10")


@pytest.fixture(scope="module")
def inverse(ur: Robot) -> IterativeInverse:
    made = inverse_kinematics(ur)
    assert isinstance(made, IterativeInverse)
    return made


def circle(robot: Robot, count: int) -> tuple[np.ndarray, np.ndarray]:
    """A circle of 100 mm radius that sinks 50 mm while the tool tilts by 0.2 rad to and fro."""
    t = np.linspace(0, 1, count)
    pose = robot.pose(START)
    origin = pose[:3, 3] + np.stack([0.1 * np.sin(7 * t), 0.1 * np.cos(7 * t) - 0.1, -0.05 * t], axis=1)
    c, s, zero = np.cos(0.2 * np.sin(10 * t)), np.sin(0.2 * np.sin(10 * t)), np.zeros(count)
    tilt = np.stack([c, -s, zero, s, c, zero, zero, zero, zero + 1], axis=1).reshape(-1, 3, 3)
    return tilt @ pose[:3, :3], origin


def test_ur10_has_the_postures_of_its_closed_form(ur: Robot, inverse: IterativeInverse) -> None:
    counts = []
    for q in np.random.default_rng(5).uniform(-np.pi, np.pi, (60, 6)):
        pose = ur.pose(q)
        expected = list(closed_form(pose))
        assert max(pose_error(ur, e, pose) for e in expected) < 1e-9
        found = [f for _, f in inverse.all(pose, limits=False)]
        assert len(found) == len(expected)
        assert all(min(apart(e, f) for f in found) < 1e-7 for e in expected)
        assert max(pose_error(ur, f, pose) for f in found) < 1e-9
        counts.append(len(found))
    assert set(counts) <= {2, 4, 6, 8}
    assert counts.count(8) > 30


def test_turns_within_limits(ur: Robot, inverse: IterativeInverse) -> None:
    """+-360 deg on six joints: two turns each, so 64 postures a branch."""
    pose = ur.pose(START)
    every, within = inverse.all(pose, limits=False), inverse.all(pose)
    assert len(within) == 64 * len(every) == 64 * 8
    assert all((np.abs(q) <= 2 * np.pi).all() for _, q in within)
    assert {b for b, _ in within} == set(range(8))


def test_crx_round_trip(shared: Path) -> None:
    robot = load_robot(str(shared / "data/robots/fanuc_official_crx10ia_l.urdf"))
    inverse = inverse_kinematics(robot)
    assert isinstance(inverse, IterativeInverse)
    for q in np.random.default_rng(6).uniform(-np.pi, np.pi, (40, 6)):
        pose = robot.pose(q)
        found = [f for _, f in inverse.all(pose, limits=False)]
        assert min(apart(f, q) for f in found) < 1e-6
        assert max(pose_error(robot, f, pose) for f in found) < 1e-9
        assert len(found) % 2 == 0
        assert all(apart(f, g) > 1e-4 for k, f in enumerate(found) for g in found[:k])


def test_two_inverses_agree(ur: Robot) -> None:
    """Nothing depends on what was asked before."""
    first, second = IterativeInverse(ur), IterativeInverse(ur)
    first.all(ur.pose(np.ones(6)))
    for (a, p), (b, q) in zip(first.all(ur.pose(START)), second.all(ur.pose(START)), strict=True):
        assert a == b
        np.testing.assert_array_equal(p, q)


def test_labels_and_configuration(ur: Robot, inverse: IterativeInverse) -> None:
    for label, q in inverse.all(ur.pose(START), limits=False):
        assert inverse.configuration(q[None])[0] == label
        rotation, origin = ur.pose(START)[None, :3, :3], ur.pose(START)[None, :3, 3]
        assert apart(inverse.along(PoseArray(rotation, origin), label).q[0], q) < 1e-9


@pytest.mark.parametrize("count", [40, 3000])
def test_along_keeps_its_branch(ur: Robot, inverse: IterativeInverse, count: int) -> None:
    """Coarse and fine samplings of one path agree where they meet; every pose is taken up to 1e-9."""
    rotation, origin = circle(ur, count)
    batch = inverse.along(PoseArray(rotation, origin), 0, START)
    assert batch.ok.all()
    np.testing.assert_allclose(batch.q[0], START, atol=1e-9)
    for k in range(0, count, max(count // 40, 1)):
        pose = ur.pose(batch.q[k])
        assert np.linalg.norm(pose[:3, 3] - origin[k]) < 1e-9
        assert np.abs(pose[:3, :3] - rotation[k]).max() < 1e-9
    # Joint speeds are those of the path: the Jacobian carries each step to the next pose.
    middle = (batch.q[1:] + batch.q[:-1]) / 2
    move = np.array([ur.jacobian(m)[:3] @ d for m, d in zip(middle, np.diff(batch.q, axis=0), strict=True)])
    np.testing.assert_allclose(
        move, np.diff(origin, axis=0), atol=0.02 * np.abs(np.diff(origin, axis=0)).max()
    )


def test_long_moves_stay_on_the_branch(ur: Robot, inverse: IterativeInverse) -> None:
    """Two poses 1.2 m apart: the posture at the end is the one that a finely sampled line reaches."""
    pose = ur.pose(START)
    line = pose[:3, 3] + np.linspace(0, 1, 2000)[:, None] * np.array([1.2, 0.3, 0.0])
    rotation = np.tile(pose[:3, :3], (2000, 1, 1))
    fine = inverse.along(PoseArray(rotation, line), 0, START)
    coarse = inverse.along(PoseArray(rotation[[0, -1]], line[[0, -1]]), 0, START)
    assert fine.ok.all()
    assert coarse.ok.all()
    np.testing.assert_allclose(coarse.q[1], fine.q[-1], atol=1e-8)


def test_seed_turns(ur: Robot, inverse: IterativeInverse) -> None:
    rotation, origin = circle(ur, 30)
    plain = inverse.along(PoseArray(rotation, origin), 0, START).q
    shift = np.array([0, 0, 0, 2 * np.pi, 0, -2 * np.pi])
    np.testing.assert_allclose(inverse.along(PoseArray(rotation, origin), 0, START + shift).q, plain + shift, atol=1e-9)
    np.testing.assert_allclose(inverse.along(PoseArray(rotation, origin), 0, plain + 0.01).q, plain, atol=1e-9)


def test_where_the_path_leaves_the_reach(ur: Robot, inverse: IterativeInverse) -> None:
    """The first pose that fails is the first at which postures are gone: the elbow is stretched."""
    pose = ur.pose(START)
    outwards = pose[:3, 3] + np.linspace(0, 1, 101)[:, None] * np.array([-1.2, 0.3, 0.0])
    rotation = np.tile(pose[:3, :3], (101, 1, 1))
    batch = inverse.along(PoseArray(rotation, outwards), 0, START)
    first = int(np.argmin(batch.ok))
    assert 0 < first < 100
    assert not batch.ok[first:].any()
    assert np.isfinite(batch.q).all()
    assert "out of reach" in batch.why(first)

    def postures(k: int) -> int:
        t = np.eye(4)
        t[:3, :3], t[:3, 3] = rotation[k], outwards[k]
        return len(list(closed_form(t)))

    assert postures(first) < postures(first - 1) == 4


def test_singular_and_unreachable(ur: Robot, inverse: IterativeInverse) -> None:
    singular = np.array([0.3, -1.2, 1.4, -1.5, 0.0, 0.4])  # axes 4 and 6 parallel
    assert inverse.singularity(singular[None])["jacobian"][0] < 1e-12
    assert inverse.singularity(START[None])["jacobian"][0] > 0.05
    batch = inverse.along(PoseArray(ur.pose(singular)[None, :3, :3], ur.pose(singular)[None, :3, 3]), 0, singular[None])
    assert np.isfinite(batch.q).all()
    assert not batch.ok[0]
    assert batch.why(0) == "singular"
    with pytest.raises(RobotError, match="is singular: it has no branch"):
        inverse.configuration(singular[None])
    far = np.eye(4)
    far[:3, 3] = [3.0, 0, 0]
    assert inverse.all(far) == []
    nowhere = inverse.along(PoseArray(far[None, :3, :3], far[None, :3, 3]), 0, START)
    assert not nowhere.ok[0]
    assert "first pose" in nowhere.why(0)


def test_refusals(ur: Robot, inverse: IterativeInverse) -> None:
    rotation, origin = circle(ur, 3)
    with pytest.raises(RobotError, match="one branch for the whole path"):
        inverse.along(PoseArray(rotation, origin), np.array([0, 1, 0]))
    with pytest.raises(RobotError, match=r"has 0\.\.15"):
        inverse.along(PoseArray(rotation, origin), 16)
    with pytest.raises(RobotError, match="seed has the shape"):
        inverse.along(PoseArray(rotation, origin), 0, np.zeros((2, 6)))
    assert inverse.along(PoseArray(rotation[:0], origin[:0]), 0, START).q.shape == (0, 6)


@pytest.mark.parametrize("name", ["ur10", "abb-irb6600-175-255", "kuka-kr210-r2700"])
def test_what_is_reached_has_a_posture(name: str) -> None:
    """Both kinds of arm, from well inside to well outside, against all postures within the limits."""
    robot = load_robot(name)
    inverse = inverse_kinematics(robot)
    g = np.random.default_rng(4)
    low, high = np.maximum(robot.lower, -3.1), np.minimum(robot.upper, 3.1)
    poses = np.array([robot.pose(g.uniform(low, high)) for _ in range(40)])
    poses[:, :3, 3] *= np.linspace(0.7, 1.5, 40)[:, None]
    expected = [len(inverse.all(pose)) > 0 for pose in poses]
    assert 8 < sum(expected) < 36
    path = PoseArray(poses[:, :3, :3], poses[:, :3, 3])
    np.testing.assert_array_equal(inverse.reached(path), expected)
    assert inverse.reached(path, thorough=False)[~np.array(expected)].sum() == 0


def test_no_flange_is_farther_away_than_the_links_are_long(ur: Robot) -> None:
    """A bound that costs nothing: it may not shut out what an arm reaches."""
    inverse = inverse_kinematics(ur)
    assert isinstance(inverse, IterativeInverse)
    centre, farthest = inverse._postures._outermost
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (500, 6))
    q[:100, 1:] = [0.0, 0.0, 0.0, 0.0, 0.0]  # stretched
    away = [np.linalg.norm(ur.pose(row)[:3, 3] - centre) for row in q]
    assert max(away) <= farthest < 1.3 * max(away)


def matrix(path: PoseArray, k: int) -> np.ndarray:
    return np.block([[path.rotation[k], path.origin[k][:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])


def test_many_starts_side_by_side_are_what_each_is_alone(ur: Robot, inverse: IterativeInverse) -> None:
    """Two paths, one of them turned about an axis off the flange, so that it needs other poses in between."""
    rotation, origin = circle(ur, 12)
    about = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned = rotation @ about
    paths = [PoseArray(rotation, origin), PoseArray(turned, origin + 0.2 * (rotation[:, :, 0] - turned[:, :, 0]))]
    first = [[q for _, q in inverse.all(matrix(path, 0), limits=False)] for path in paths]
    which = np.repeat([0, 1], [len(f) for f in first])
    start = np.concatenate(first)
    q, ok = inverse.followed(paths, which, start)
    assert ok.all(axis=1).sum() >= 8 and len(start) > 8
    for k in np.flatnonzero(ok.all(axis=1)):
        alone = inverse.along(paths[which[k]], 0, start[k])
        assert alone.ok.all()
        assert apart(alone.q, q[k]) < 1e-9
        expected = closed_form(matrix(paths[which[k]], 7))
        assert min(apart(e, q[k, 7]) for e in expected) < 1e-7
