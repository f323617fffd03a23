"""Every vendor's angles against PyPI robodk's robomath and against scipy, gimbal lock included."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath
from scipy.spatial.transform import Rotation

from toolpaths import rotation as ours


def sample() -> np.ndarray:
    """Random, exact gimbal lock of both orders, near it, half turns, tiny turns, identity."""
    g = np.random.default_rng(7)
    near = g.choice([0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4], 200) * g.normal(size=200)
    angles = g.uniform(-180, 180, (200, 3))
    angles[:, 1] = g.choice([-90, 90], 200) + near
    parts = [
        Rotation.random(300, rng=g).as_matrix(),
        Rotation.from_euler("ZYX", angles, degrees=True).as_matrix(),
        Rotation.from_euler("XYZ", angles, degrees=True).as_matrix(),
        Rotation.from_rotvec(np.pi * Rotation.random(50, rng=g).as_matrix()[:, 0]).as_matrix(),
        Rotation.from_rotvec((np.pi - 1e-9) * Rotation.random(50, rng=g).as_matrix()[:, 0]).as_matrix(),
        Rotation.from_rotvec(1e-9 * g.normal(size=(50, 3))).as_matrix(),
        np.array([np.diag(d) for d in ([1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1])], dtype=float),
        np.array([[[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [[0, 0, -1], [0, 1, 0], [1, 0, 0]]], dtype=float),
    ]
    return np.concatenate(parts)


MATRICES = sample()


def pose(matrix: np.ndarray) -> robomath.Mat:
    m = np.eye(4)
    m[:3, :3] = matrix
    return robomath.Mat(m.tolist())


PAIRS = [
    (ours.kuka_from_matrix, ours.matrix_from_kuka, robomath.Pose_2_KUKA, robomath.KUKA_2_Pose),
    (ours.fanuc_from_matrix, ours.matrix_from_fanuc, robomath.Pose_2_Fanuc, robomath.Fanuc_2_Pose),
    (ours.motoman_from_matrix, ours.matrix_from_motoman, robomath.Pose_2_Motoman, robomath.Motoman_2_Pose),
    (ours.staubli_from_matrix, ours.matrix_from_staubli, robomath.Pose_2_Staubli, robomath.Staubli_2_Pose),
]


@pytest.mark.parametrize(("there", "back", "robodk_there", "robodk_back"), PAIRS)
def test_euler_angles(there, back, robodk_there, robodk_back):
    angles = there(MATRICES)
    # what a controller makes of our angles, by robodk's formula, is the orientation itself
    theirs = np.array([robodk_back([0, 0, 0, *a]).rows for a in np.degrees(angles).tolist()])[:, :3, :3]
    np.testing.assert_allclose(theirs, MATRICES, atol=3e-9)
    np.testing.assert_allclose(back(angles), MATRICES, atol=3e-9)
    # away from gimbal lock the three angles are robodk's own
    middle = np.abs(np.degrees(angles[:, 1]))
    free = middle < 89.9
    expected = np.array([robodk_there(pose(m))[3:] for m in MATRICES])
    turns = (np.degrees(angles) - expected + 180.0) % 360.0 - 180.0
    assert free.sum() > 300
    np.testing.assert_allclose(turns[free], 0.0, atol=1e-5)
    # in exact lock, too: one angle is 0 by everybody's choice
    locked = middle == 90.0
    assert locked.sum() > 5
    np.testing.assert_allclose(turns[locked], 0.0, atol=1e-5)


def test_middle_angle_keeps_its_digits_next_to_the_lock():
    for off in (1e-3, 1e-5, 1e-7):
        m = Rotation.from_euler("ZYX", [0.3, np.pi / 2 - off, -0.4]).as_matrix()
        a, b, c = ours.kuka_from_matrix(m)
        assert np.pi / 2 - b == pytest.approx(off, abs=2e-16)
        assert (a - 0.3) - (c + 0.4) == pytest.approx(0.0, abs=1e-14)


def test_kuka_by_hand():
    # A about Z, B about the new Y, C about the newest X
    abc = np.radians([90.0, 0.0, 90.0])
    expected = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(ours.matrix_from_kuka(abc), expected, atol=1e-15)
    np.testing.assert_allclose(ours.kuka_from_matrix(expected), abc, atol=1e-15)


def test_quaternion():
    q = ours.quaternion_from_matrix(MATRICES)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-15)
    assert (q[np.arange(len(q)), (q != 0).argmax(axis=1)] > 0).all()
    assert not np.signbit(q[q == 0.0]).any()
    scipys = Rotation.from_matrix(MATRICES).as_quat(scalar_first=True)
    np.testing.assert_allclose(np.abs(np.einsum("ni,ni->n", q, scipys)), 1.0, atol=1e-14)
    np.testing.assert_allclose(ours.matrix_from_quaternion(q), MATRICES, atol=1e-15)
    robodks = np.array([robomath.quaternion_2_pose(x).rows for x in q.tolist()])[:, :3, :3]
    np.testing.assert_allclose(robodks, MATRICES, atol=1e-14)
    # robodk's own quaternion is good to 1e-4 only: it rounds to no turn or half a turn
    theirs = np.array([robomath.Pose_2_ABB(pose(m))[3:] for m in MATRICES])
    np.testing.assert_allclose(np.abs(np.einsum("ni,ni->n", q, theirs)), 1.0, atol=1e-6)


def test_quaternion_is_normalised_first():
    q = np.array([2.0, -4.0, 6.0, 1.0])
    expected = Rotation.from_quat(q, scalar_first=True).as_matrix()
    np.testing.assert_allclose(ours.matrix_from_quaternion(q), expected, atol=1e-15)


def test_rotation_vector():
    v = ours.ur_from_matrix(MATRICES)
    np.testing.assert_allclose(Rotation.from_rotvec(v).as_matrix(), MATRICES, atol=2e-15)
    np.testing.assert_allclose(ours.matrix_from_ur(v), MATRICES, atol=2e-15)
    assert np.linalg.norm(v, axis=1).max() <= np.pi + 1e-15
    tiny = np.array([3e-10, -2e-10, 1e-10])
    np.testing.assert_allclose(ours.ur_from_matrix(ours.matrix_from_ur(tiny)), tiny, rtol=1e-6)
    robodks = np.array([robomath.UR_2_Pose([0, 0, 0, *x]).rows for x in v.tolist()])[:, :3, :3]
    np.testing.assert_allclose(robodks, MATRICES, atol=3e-8)


def test_rpy_is_yaw_pitch_roll_about_z_y_x():
    rpy = np.array([[0.3, -0.7, 2.2], [-3.0, 1.5, -0.1]])
    expected = Rotation.from_euler("ZYX", rpy[:, ::-1]).as_matrix()
    np.testing.assert_allclose(ours.matrix_from_rpy(rpy), expected, atol=1e-15)
    np.testing.assert_allclose(ours.rpy_from_matrix(expected), rpy, atol=1e-14)


def test_turn_between():
    angles = np.array([1e-9, 1e-4, 0.5, 2.0, np.pi])
    start = Rotation.from_rotvec([0.2, -0.3, 0.9])
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    for angle in angles:
        pair = np.stack((start.as_matrix(), (start * Rotation.from_rotvec(angle * axis)).as_matrix()))
        assert ours.turn_between(pair)[0] == pytest.approx(angle, rel=1e-6)
