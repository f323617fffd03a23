"""Mesh files: STL, OBJ, PLY and 3MF through trimesh, closed and turned outward, or refused with what is open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.process.milling.mesh_reader import UNITS, loaded_mesh
from compensator.process.milling.stock import Stock, mesh_stock

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]

SMALLEST, LARGEST = 1e-3, 20.0  # m: a stock outside of these has another unit
USUAL = (0.01, 5.0)  # m: what a unit is proposed for


def read_mesh(path: Path, units: str) -> Stock:
    """A closed mesh; ``units`` is a key of UNITS.

    Raises:
        CellError: names the file, what is wrong with it, where, and what to do.
    """
    vertices, faces = loaded_mesh(path)
    _refuse_size(path, vertices, units)
    _refuse_open(path, vertices, faces)
    corner = (vertices * UNITS[units])[faces]
    volume = float(np.einsum("ij,ij->i", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum()) / 6.0
    if volume <= 0:
        raise CellError(
            f"{path}: its normals point inward (the volume is {volume * 1e9:.6g} mm3): turn all faces over "
            "where the mesh was made"
        )
    return mesh_stock(corner, _normals(corner, faces), f"{path.name}, {len(faces)} facets")


def _refuse_size(path: Path, vertices: Floats, units: str) -> None:
    size = float(np.ptp(vertices, axis=0).max())
    if SMALLEST <= size * UNITS[units] <= LARGEST:
        return
    fits = [u for u, scale in UNITS.items() if USUAL[0] <= size * scale <= USUAL[1]]
    remedy = f"units = {fits[0]!r} would make it {size * UNITS[fits[0]] * 1e3:.4g} mm" if fits else "no unit fits"
    raise CellError(
        f"{path}: {size * UNITS[units] * 1e3:.4g} mm large with units = {units!r}; a stock has 1 mm to 20 m: {remedy}"
    )


def _refuse_open(path: Path, vertices: Floats, faces: Faces) -> None:
    """Each edge belongs to two facets, which run along it in opposite ways."""
    edges = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    low, high = edges.min(axis=1), edges.max(axis=1)
    key = low * len(vertices) + high
    unique, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    way = np.zeros(len(unique), dtype=np.int64)
    np.add.at(way, inverse.reshape(-1), np.where(edges[:, 0] < edges[:, 1], 1, -1))
    wrong = np.flatnonzero((way != 0) | (count % 2 != 0))
    if not len(wrong):
        return
    first = int(wrong[0])
    place = vertices[[unique[first] // len(vertices), unique[first] % len(vertices)]].mean(axis=0)
    at = ", ".join(f"{v:.4g}" for v in place)
    if count[first] % 2:
        what = f"it is not closed: {int(np.sum(count[wrong] % 2))} open edges, the first at ({at}) of the file"
    else:
        what = f"neighbouring facets face opposite ways at {len(wrong)} edges, the first at ({at}) of the file"
    raise CellError(f"{path}: {what}. The inside of the stock is not known: repair the mesh where it was made")


def _normals(corner: Floats, faces: Faces) -> Floats:
    """(F, 7, 3) of faces, edges and corners, those of corners weighted by angle."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    face = np.cross(b - a, c - a)
    size = np.linalg.norm(face, axis=1, keepdims=True)
    face = np.divide(face, size, out=np.zeros_like(face), where=size > 0)
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)  # (F, 3, 2) vertices
    n = int(faces.max()) + 1
    _, edge = np.unique(sides[..., 0] * n + sides[..., 1], return_inverse=True)
    edge = edge.reshape(-1, 3)
    at_edge = np.zeros((int(edge.max()) + 1, 3))
    for k in range(3):
        np.add.at(at_edge, edge[:, k], face)
    at_corner = np.zeros((n, 3))
    for i in range(3):
        u, v = corner[:, (i + 1) % 3] - corner[:, i], corner[:, (i + 2) % 3] - corner[:, i]
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.sum(u * v, axis=1))
        np.add.at(at_corner, faces[:, i], face * angle[:, None])
    return np.concatenate([face[:, None], at_edge[edge], at_corner[faces]], axis=1)
