"""The shape that a table of a cell file describes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from compensator.cell.scene_tables import BodyTable
from compensator.scene.mesh_shape import scene_mesh
from compensator.scene.shape import BoxShape, CylinderShape, Shape3
from toolpaths.frame import Frame


def table_shape(table: BodyTable, folder: Path) -> tuple[Shape3, Frame]:
    """Shape, and where its middle stands in the frame of the table; SI.

    Raises:
        CellError: the mesh is refused.
    """
    if table.mesh is not None:
        return scene_mesh(folder / table.mesh, table.units, table.name), Frame(np.eye(3), np.zeros(3))
    if table.box is not None:
        low, high = np.array(table.box) * 1e-3
        return BoxShape(high - low), Frame(np.eye(3), 0.5 * (low + high))
    if table.cylinder is None:
        raise ValueError("no shape in a table that was checked")
    low, high = (1e-3 * v for v in table.cylinder.z)
    middle = np.array([0.0, 0.0, 0.5 * (low + high)])
    return CylinderShape(1e-3 * table.cylinder.radius, high - low), Frame(np.eye(3), middle)
