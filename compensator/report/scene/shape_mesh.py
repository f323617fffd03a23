"""Meshes of the shapes of bodies, fine meshes thinned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.scene.solids import SolidMesh, box, capsule, turned
from compensator.scene.shape import BoxShape, CapsuleShape, CylinderShape, Shape3

Floats = npt.NDArray[np.float64]

MOST_FACES = 6000  # of a body


def shape_mesh(shape: Shape3, most: int = MOST_FACES) -> SolidMesh:
    """The surface of a shape in its own axes; a mesh has about ``most`` triangles at most."""
    if isinstance(shape, CapsuleShape):
        end = np.array([0.0, 0.0, 0.5 * shape.length])
        return capsule(-end, end, shape.radius)
    if isinstance(shape, CylinderShape):
        return turned(np.full(2, shape.radius), np.array([-0.5, 0.5]) * shape.length)
    if isinstance(shape, BoxShape):
        return box(-0.5 * shape.size, 0.5 * shape.size)
    return thinned(shape.vertices[shape.faces], most)


def thinned(corner: Floats, most: int) -> SolidMesh:
    """Triangles (T, 3, 3) as a mesh whose corners lie on a grid that is as coarse as ``most`` triangles ask for."""
    points = corner.reshape(-1, 3)
    size = max(float(np.ptp(points, axis=0).max()), 1e-6)
    grid = size * 1e-6
    while True:
        cell = np.round(points / grid).astype(np.int64)
        _, first, index = np.unique(cell, axis=0, return_index=True, return_inverse=True)
        faces = index.reshape(-1, 3)
        kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        faces = faces[kept]
        if len(faces) > most:  # the same triangle may be there several times
            faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
        if len(faces) <= most:
            return SolidMesh(points[first], faces)
        grid = max(1.3 * grid, size / 400)
