"""Mesh reader: vertices and facets of STL, OBJ, PLY and 3MF files through trimesh, as they stand there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]

UNITS = {"mm": 1e-3, "inch": 25.4e-3, "m": 1.0}
FORMATS = (".stl", ".obj", ".ply", ".3mf")
MOST_BYTES = 1_000_000_000
MOST_FACES = 5_000_000


def loaded_mesh(path: Path) -> tuple[Floats, Faces]:
    """Vertices (V, 3), each place once, and faces (F, 3), in the unit of the file.

    Raises:
        CellError: names the file, what is wrong with it, and what to do.
    """
    if path.suffix.lower() not in FORMATS:
        what = path.suffix or "a file without suffix"
        raise CellError(f"{path}: {what} is no mesh that is read: {' '.join(FORMATS)}")
    try:
        size = path.stat().st_size
    except OSError as e:
        raise CellError(f"{path}: cannot read the mesh: {e.strerror}") from e
    if size > MOST_BYTES:
        raise CellError(f"{path}: {size / 1e9:.1f} GB; at most {MOST_BYTES / 1e9:g} GB are read: write a coarser mesh")
    import trimesh  # half a second, and only where a mesh is named

    try:
        mesh = trimesh.load_mesh(str(path), process=False)
    except Exception as e:  # whatever the readers of trimesh stumble over
        raise CellError(f"{path}: cannot be read as a mesh: {e}") from e
    vertices = np.asarray(getattr(mesh, "vertices", ()), dtype=float).reshape(-1, 3)
    faces = np.asarray(getattr(mesh, "faces", ()), dtype=np.int64).reshape(-1, 3)
    if not len(faces):
        raise CellError(f"{path}: holds no facets; a mesh is expected")
    if len(faces) > MOST_FACES:
        raise CellError(f"{path}: {len(faces):,} facets; at most {MOST_FACES:,} are read: write a coarser mesh")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1)[faces].all(axis=1))
    if len(bad):
        what = f"facet {bad[0] + 1} has a corner that is no number ({len(bad)} such facets)"
        raise CellError(f"{path}: {what}: repair the mesh where it was made")
    return _joined(vertices, faces)


def _joined(vertices: Floats, faces: Faces) -> tuple[Floats, Faces]:
    """Corners at one place become one vertex; facets without area, which have two of them there, are dropped."""
    size = np.ptp(vertices, axis=0).max()
    key = np.round(vertices / max(size * 1e-8, 1e-300)).astype(np.int64)
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return vertices[first], faces[whole]
