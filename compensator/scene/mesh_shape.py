"""Mesh shapes from files: of links and of things around; a mesh in another unit is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensator.errors import CellError
from compensator.process.milling.mesh_reader import UNITS, loaded_mesh
from compensator.scene.shape import MeshShape

SMALLEST, LARGEST = 10.0e-3, 50.0  # m: a thing that stands in a cell
USUAL = (0.05, 20.0)  # m: what a unit is proposed for


def scene_mesh(path: Path, units: str, name: str) -> MeshShape:
    """A mesh of a cell, in SI; it need not be closed.

    Raises:
        CellError: names file, body, size and the unit that would fit.
    """
    vertices, faces = loaded_mesh(path)
    size = float(np.ptp(vertices[np.unique(faces)], axis=0).max())
    if not SMALLEST <= size * UNITS[units] <= LARGEST:
        fits = [u for u, scale in UNITS.items() if USUAL[0] <= size * scale <= USUAL[1]]
        offered = [f"units = {u!r} would make it {size * UNITS[u] * 1e3:.4g} mm" for u in fits]
        remedy = "; ".join(offered) if fits else "no unit fits"
        raise CellError(
            f"{path}: {name} is {size * UNITS[units] * 1e3:.4g} mm large with units = {units!r}; a body of a cell has "
            f"{SMALLEST * 1e3:g} mm to {LARGEST:g} m: {remedy}"
        )
    return MeshShape(vertices * UNITS[units], faces)
