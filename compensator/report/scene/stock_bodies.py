"""Stock, what remains of it and the finished part as bodies in the work object."""

from __future__ import annotations

from compensator.cell.placement import Placement
from compensator.process.milling.milling_load import MillingLoad
from compensator.report.scene.drawn_body import WORK, DrawnBody
from compensator.report.scene.moments import Moments
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.report.scene.solids import SolidMesh
from compensator.report.scene.stock_stages import left_cell, left_stages
from compensator.scene.stock_bodies import stock_bodies

STOCK_COLOUR, LEFT_COLOUR, PART_COLOUR = "#8fa3b5", "#b8c0c8", "#7fb08a"
MOST_FACES = 20_000


def milled_bodies(placement: Placement, load: MillingLoad, moments: Moments | None = None) -> list[DrawnBody]:
    """Stock and part as the cell has them, and what is left of the stock: at ``moments``; None: at the end."""
    bodies = []
    for body in stock_bodies(placement):
        mesh = shape_mesh(body.shape, MOST_FACES).moved(body.placement.rotation, body.placement.origin)
        if body.role == "part":
            bodies.append(DrawnBody(mesh, WORK, "part", PART_COLOUR, opacity=0.6))
        else:
            bodies.append(DrawnBody(mesh, WORK, "stock", STOCK_COLOUR, opacity=0.25))
    remains = load.cut.remains
    if remains is not None:
        cell = left_cell(remains, load.cell)
        if moments is None:
            mesh, stages = SolidMesh(*remains.mesh(cell)), None
        else:
            mesh, stages = left_stages(load.cut, remains, cell, moments)
        if len(mesh.faces):
            bodies.append(DrawnBody(mesh, WORK, "left", LEFT_COLOUR, stages=stages))
    return bodies
