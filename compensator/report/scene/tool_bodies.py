"""Tool and cutter as bodies in the axes of the TCP: z points out of the tool into the work."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from compensator.cell.placement import Placement
from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.report.scene.solids import SolidMesh, capsule, turned
from compensator.scene.body import Body
from compensator.scene.tool_bodies import cutter_of
from stiffness.statics.tool import Tool

if TYPE_CHECKING:
    from compensator.process.milling.cutter import Cutter

Floats = npt.NDArray[np.float64]

TOOL_COLOUR, SHANK_COLOUR, HOLDER_COLOUR, EDGE_COLOUR = "#5f6f7d", "#9aa5ad", "#5f6f7d", "#c9a227"
SPINDLE, NEEDLE = 0.16, 0.02  # radius of a spindle and of a tip nobody described, of the length of the tool
WIDEST = 0.06  # m, of that spindle
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def tool_bodies(placement: Placement, known: Sequence[Body], links: int) -> list[DrawnBody]:
    """What hangs on the flange, tool by tool.

    Args:
        known: bodies of a job, of which those are taken that the cell draws of its tools.
        links: number of the flange; that of the TCP is one more.
    """
    tools, bodies = placement.tools, list[DrawnBody]()
    for number, tool in tools.by_number.items():
        of = None if tools.any_number else number
        cutter = cutter_of(placement, number)
        drawn = [] if cutter is None else _cutter(cutter, links + 1, of=of)
        own = [_of_cell(body, links) for body in known if body.role == "tool" and body.tool == of]
        height = max((float(-b.mesh.vertices[:, 2].min()) for b in drawn), default=0.0)
        bodies += [*drawn, *own, *([] if own else _carrier(tool, height, links + 1, of=of))]
    return bodies


def _of_cell(body: Body, flange: int) -> DrawnBody:
    mesh = shape_mesh(body.shape).moved(body.placement.rotation, body.placement.origin)
    return DrawnBody(mesh, flange, "tool", TOOL_COLOUR, tool=body.tool)


def _cutter(cutter: Cutter, frame: int, *, of: int | None) -> list[DrawnBody]:
    from compensator.process.milling.outline import outline_rows  # loads the compiler of the kernels

    rows = outline_rows(cutter, cutter.radius)
    edge = turned(np.maximum(rows[:, 0], 1e-6), rows[:, 1])
    bodies = [DrawnBody(_hung(edge), frame, "cutter", EDGE_COLOUR, tool=of)]
    for low, high, radius, kind in cutter.cylinders:
        colour = HOLDER_COLOUR if kind == 2 else SHANK_COLOUR
        mesh = turned(np.full(2, radius), np.array([low, high]))
        bodies.append(DrawnBody(_hung(mesh), frame, "cutter", colour, tool=of))
    return bodies


def _carrier(tool: Tool, height: float, frame: int, *, of: int | None) -> list[DrawnBody]:
    """From the flange to the cutter, ``height`` m above the tip; without a cutter a needle at the tip."""
    flange = -tool.rotation.T @ tool.position
    length = float(np.linalg.norm(flange))
    if length < 1e-3:
        return []
    bodies = []
    if not height:
        height = 0.3 * length
        mesh = turned(np.array([0.05, 1.0]) * NEEDLE * length, np.array([0.0, height]))
        bodies.append(DrawnBody(_hung(mesh), frame, "cutter", EDGE_COLOUR, tool=of))
    end = np.array([0.0, 0.0, -height])
    if np.linalg.norm(flange - end) > 1e-3:
        radius = min(SPINDLE * length, WIDEST)
        bodies.append(DrawnBody(capsule(flange, end, radius), frame, "tool", TOOL_COLOUR, tool=of))
    return bodies


def _hung(mesh: SolidMesh) -> SolidMesh:
    """From heights above the tip to the axes of the TCP."""
    return mesh.moved(UPSIDE_DOWN, np.zeros(3))
