"""What stands around the arm, as bodies: stock and part on the work object, what the cell puts there."""

from __future__ import annotations

from compensator.cell.placement import Placement
from compensator.process.milling.milling_load import MillingLoad
from compensator.process.process import ProcessLoad
from compensator.report.scene.drawn_body import FLOOR, WORK, DrawnBody
from compensator.report.scene.moments import Moments
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.scene.body import BASE, WORKOBJECT, Body

FIXTURE_COLOUR, SACRIFICIAL_COLOUR = "#9c8f7a", "#c9bfa8"


def work_bodies(placement: Placement, load: ProcessLoad, moments: Moments | None = None) -> list[DrawnBody]:
    """Bodies in the work object, none where nothing is milled; the stock as it is at ``moments``, or at the end."""
    if not isinstance(load, MillingLoad):
        return []
    from compensator.report.scene.stock_bodies import milled_bodies  # loads the compiler of the kernels

    return milled_bodies(placement, load, moments)


def fixture(body: Body) -> DrawnBody:
    """A body that the cell puts around the arm."""
    frame = WORK if body.carrier == WORKOBJECT else 0 if body.carrier == BASE else FLOOR
    mesh = shape_mesh(body.shape).moved(body.placement.rotation, body.placement.origin)
    return DrawnBody(mesh, frame, "fixture", SACRIFICIAL_COLOUR if body.sacrificial else FIXTURE_COLOUR)
