"""Frames against homogeneous matrices: one, or one per pose."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.frame import Frame

N = 7


def frames(seed: int, count: tuple[int, ...]) -> Frame:
    g = np.random.default_rng(seed)
    rotation = Rotation.random(int(np.prod(count)), rng=g).as_matrix().reshape(*count, 3, 3)
    return Frame(rotation, g.normal(size=(*count, 3)))


@pytest.mark.parametrize("a", [(), (N,)])
@pytest.mark.parametrize("b", [(), (N,)])
def test_frames_chain_as_matrices_do(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    """A after B, B within A, there and back, whatever of the two is one and whatever is many."""
    outer, inner = frames(1, a), frames(2, b)
    np.testing.assert_allclose(outer.then(inner).matrix, outer.matrix @ inner.matrix, atol=1e-14)
    np.testing.assert_allclose(inner.relative_to(outer).matrix, np.linalg.inv(outer.matrix) @ inner.matrix, atol=1e-14)
    np.testing.assert_allclose(outer.then(inner.relative_to(outer)).origin - inner.origin, 0.0, atol=1e-14)
    np.testing.assert_allclose(outer.inverse().matrix, np.linalg.inv(outer.matrix), atol=1e-14)
    back = Frame.of(outer.matrix)
    assert np.array_equal(back.rotation, outer.rotation) and np.array_equal(back.origin, outer.origin)


@pytest.mark.parametrize("count", [(), (N,)])
def test_points_and_directions(count: tuple[int, ...]) -> None:
    """One point or one per pose; a direction does not know the origin."""
    frame, points = frames(3, count), np.random.default_rng(4).normal(size=(N, 3))
    for point in (points, points[0]):
        expected = np.einsum("...ij,...j->...i", frame.matrix[..., :3, :3], point)
        np.testing.assert_allclose(frame.along(point), expected, atol=1e-14)
        np.testing.assert_allclose(frame.at(point), expected + frame.origin, atol=1e-14)


def test_some_of_many() -> None:
    """By index, mask, slice; one of them is one frame."""
    many = frames(5, (N,))
    for rows in (np.array([4, 1]), many.origin[:, 0] > 0, slice(2, 5)):
        assert np.array_equal(many.take(rows).matrix, many.matrix[rows])
    assert many.take(3).matrix.shape == (4, 4) and repr(many) == "Frame(7 poses)"
