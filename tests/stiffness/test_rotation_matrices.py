"""Rotations in numbers, against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stiffness.rotation import antisymmetric, from_rotation_vector, rotation_vector, rpy_rotation, skew

AXES = np.random.default_rng(1).normal(size=(200, 3))
AXES /= np.linalg.norm(AXES, axis=1)[:, None]


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.3, 2.0, np.pi - 1e-3, np.pi - 1e-9, np.pi])
def test_rotation_vectors_and_matrices(angle: float) -> None:
    vector = angle * AXES
    matrix = Rotation.from_rotvec(vector).as_matrix()
    np.testing.assert_allclose(from_rotation_vector(vector), matrix, atol=1e-14)
    back = rotation_vector(matrix)
    np.testing.assert_allclose(np.linalg.norm(back, axis=1), angle, atol=1e-7)  # near half a turn arccos has no digits
    np.testing.assert_allclose(from_rotation_vector(back), matrix, atol=1e-7 if angle > 3 else 1e-14)


def test_a_skew_matrix_is_a_cross_product() -> None:
    u = np.random.default_rng(2).normal(size=(200, 3))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", skew(AXES), u), np.cross(AXES, u), atol=1e-15)
    np.testing.assert_array_equal(antisymmetric(skew(AXES)), 2 * AXES)
    np.testing.assert_array_equal(antisymmetric(skew(AXES))[0], antisymmetric(skew(AXES)[0]))


def test_roll_pitch_yaw() -> None:
    for rpy in np.random.default_rng(3).uniform(-4, 4, (50, 3)):
        np.testing.assert_allclose(rpy_rotation(*rpy), Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-14)


def test_quarter_turns_are_exact() -> None:
    np.testing.assert_array_equal(rpy_rotation(0.0, 0.0, np.pi / 2), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    np.testing.assert_array_equal(rpy_rotation(np.pi, 0.0, 0.0), np.diag([1, -1, -1]))
