"""Stock, what remains of it and the finished part as bodies in the work object."""

from __future__ import annotations

import numpy as np

from compensator.cell.placement import Placement
from compensator.process.milling.milling_load import MillingLoad
from compensator.report.scene.drawn_body import WORK, DrawnBody
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.report.scene.solids import SolidMesh
from compensator.scene.stock_bodies import stock_bodies

STOCK_COLOUR, LEFT_COLOUR, PART_COLOUR = "#8fa3b5", "#b8c0c8", "#7fb08a"
CELLS = 60  # of the mesh of what remains, along the longest side of the stock
MOST_FACES = 20_000


def milled_bodies(placement: Placement, load: MillingLoad) -> list[DrawnBody]:
    """Stock and part as the cell has them, and what a path leaves of the stock."""
    bodies = []
    for body in stock_bodies(placement):
        mesh = shape_mesh(body.shape, MOST_FACES).moved(body.placement.rotation, body.placement.origin)
        if body.role == "part":
            bodies.append(DrawnBody(mesh, WORK, "part", PART_COLOUR, opacity=0.6))
        else:
            bodies.append(DrawnBody(mesh, WORK, "stock", STOCK_COLOUR, opacity=0.25))
    if load.cut.remains is not None:
        size = float(np.ptp(load.cut.remains.stock.box, axis=0).max())
        vertices, faces = load.cut.remains.mesh(max(size / CELLS, load.cell))
        if len(faces):
            bodies.append(DrawnBody(SolidMesh(vertices, faces), WORK, "left", LEFT_COLOUR))
    return bodies
