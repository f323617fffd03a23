"""Removed volume and the mesh that remains against exact booleans (manifold3d, an oracle of tests only)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from compensator.process.milling.mill import mill
from tests.compensator.process.milling.milling_jobs import FLAT20, K7075, block, path

manifold3d = pytest.importorskip("manifold3d")
SEGMENTS = 256


def swept(points: np.ndarray) -> float:
    """Volume (mm3) that a flat end mill of 20 mm takes out of the block along level and falling moves."""
    left = manifold3d.Manifold.cube((80.0, 80.0, 20.0)).translate((0.0, -40.0, -20.0))
    before = left.volume()
    radius = 10.0 / np.sqrt(np.sinc(2.0 / SEGMENTS))  # a polygon of the area of the circle
    body = manifold3d.Manifold.cylinder(25.0, radius, circular_segments=SEGMENTS)
    for a, b in pairwise(points):
        left -= manifold3d.Manifold.batch_hull([body.translate(tuple(a)), body.translate(tuple(b))])
    return float(before - left.volume())


@pytest.mark.parametrize("seed", [1, 2])
def test_removed_volume(seed: int) -> None:
    """Within 0.5 %, at a grid of a tenth of the radius; the mesh of what remains is closed and has the rest."""
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(-10, 90, 25), rng.uniform(-45, 45, 25), rng.uniform(-8, -1, 25)])
    points = np.concatenate([[[-40.0, 0.0, -4.0]], points])
    cut = mill(path(points, FLAT20), block((0, -40, -20), (80, 40, 0)), K7075, cell=1e-3)
    assert cut.remains is not None
    expected = swept(points)
    assert expected > 20_000
    assert cut.remains.removed * 1e9 == pytest.approx(expected, rel=0.005)
    vertices, faces = cut.remains.mesh()
    corner = vertices[faces]
    volume = float(np.einsum("ij,ij->i", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum()) / 6 * 1e9
    assert volume == pytest.approx(80 * 80 * 20 - expected, rel=0.01)
    assert cut.removed.sum() * 1e9 == pytest.approx(expected, rel=0.08)  # moves of up to 100 mm, from a few places each
