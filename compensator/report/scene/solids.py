"""Solids as meshes of triangles: surfaces of revolution, capsules, boxes. Vertices in m."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]

AROUND = 24  # corners of a circle
CAP = 5  # rings of half a ball


@dataclass(frozen=True, repr=False, eq=False)
class SolidMesh:
    """``vertices`` (V, 3) m and ``faces`` (F, 3), outward; ``smooth``: shaded as a curved surface."""

    vertices: Floats
    faces: Faces
    smooth: bool = False

    def __repr__(self) -> str:
        return f"SolidMesh({len(self.vertices)} vertices, {len(self.faces)} faces)"

    def moved(self, rotation: Floats, origin: Floats) -> SolidMesh:
        """The same where (rotation, origin) puts it."""
        return SolidMesh(self.vertices @ rotation.T + origin, self.faces, self.smooth)


def joined(meshes: list[SolidMesh]) -> SolidMesh:
    """Several as one; shaded as the first."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + start for m, start in zip(meshes, starts, strict=False)]
    return SolidMesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces), meshes[0].smooth)


def turned(radius: Floats, height: Floats, *, smooth: bool = False) -> SolidMesh:
    """A surface of revolution about z: an outline (R,) of radius and height, m, from below upwards."""
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = [np.column_stack([r * ring, np.full(AROUND, z)]) for r, z in zip(radius, height, strict=True)]
    vertices = np.concatenate(rings)
    k = np.arange(AROUND)
    after = (k + 1) % AROUND
    faces = []
    for row in range(len(radius) - 1):
        low, high = row * AROUND, (row + 1) * AROUND
        faces.append(np.column_stack([low + k, low + after, high + after]))
        faces.append(np.column_stack([low + k, high + after, high + k]))
    ends = np.array([[0.0, 0.0, height[0]], [0.0, 0.0, height[-1]]])
    bottom, top = len(vertices), len(vertices) + 1
    last = (len(radius) - 1) * AROUND
    faces += [np.column_stack([after, k, np.full(AROUND, bottom)])]
    faces += [np.column_stack([last + k, last + after, np.full(AROUND, top)])]
    return SolidMesh(np.concatenate([vertices, ends]), np.concatenate(faces), smooth)


def capsule(start: Floats, end: Floats, radius: float) -> SolidMesh:
    """All that is within ``radius`` of the line from ``start`` to ``end`` (3,), m."""
    length = float(np.linalg.norm(end - start))
    bend = np.linspace(0.0, 0.5 * np.pi, CAP + 1)
    side = np.concatenate([np.sin(bend), np.sin(bend[::-1])]) * radius
    height = np.concatenate([-np.cos(bend), np.cos(bend[::-1])]) * radius
    height[CAP + 1 :] += length
    return turned(np.maximum(side, 1e-6), height, smooth=True).moved(rotation_to(end - start), start)


def box(low: Floats, high: Floats) -> SolidMesh:
    """A box between two corners (3,), m."""
    corner = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
    return SolidMesh(low + corner * (high - low), np.array(faces))


def rotation_to(direction: Floats) -> Floats:
    """(3, 3) a rotation whose z column is ``direction``; any where that is of no length."""
    length = float(np.linalg.norm(direction))
    if length < 1e-9:
        return np.eye(3)
    z = direction / length
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
