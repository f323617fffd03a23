"""Tool and cutter as bodies in the axes of the TCP: z points out of the tool into the work."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.path.tool_set import ToolSet
from compensator.process.acting_process import ActingProcess
from compensator.process.process import Process
from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.solids import SolidMesh, capsule, turned
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

TOOL_COLOUR, SHANK_COLOUR, HOLDER_COLOUR, EDGE_COLOUR = "#5f6f7d", "#9aa5ad", "#5f6f7d", "#c9a227"
SPINDLE, NEEDLE = 0.16, 0.02  # radius of a spindle and of a tip nobody described, of the length of the tool
WIDEST = 0.06  # m, of that spindle
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])


def tool_bodies(tools: ToolSet, process: Process, frame: int) -> list[DrawnBody]:
    """What hangs on the flange, tool by tool; ``frame``: the number of the TCP among the links."""
    bodies = []
    for number, tool in tools.by_number.items():
        of = None if tools.any_number else number
        drawn = _cutter(process.said if isinstance(process, ActingProcess) else process, number, frame, of=of)
        height = max((float(-b.mesh.vertices[:, 2].min()) for b in drawn), default=0.0)
        bodies += [*drawn, *_carrier(tool, height, frame, of=of)]
    return bodies


def _cutter(process: Process, number: int, frame: int, *, of: int | None) -> list[DrawnBody]:
    if not process.cuts_stock:
        return []
    from compensator.process.milling.milling import MillingProcess  # loads the compiler of the kernels
    from compensator.process.milling.outline import outline_rows

    if not isinstance(process, MillingProcess):
        return []
    cutter = process.cutters.get(None) or process.cutters.get(number)
    if cutter is None:
        return []
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
