"""Tool bodies: what the cell draws of a tool, cutter, shank and holder, or the line from the flange to the TCP."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from compensator.cell.placement import Placement
from compensator.process.process import Process
from compensator.scene.body import TOOL, Body, Role
from compensator.scene.shape import CapsuleShape, CylinderShape, Shape3
from compensator.scene.table_shape import table_shape
from stiffness.robot.link_shape import along_z
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame

if TYPE_CHECKING:
    from compensator.process.milling.cutter import Cutter
    from compensator.process.milling.milling import MillingProcess

Floats = npt.NDArray[np.float64]
LINE = 2e-3  # m: radius of the line that stands for a tool of which nothing is drawn


def tool_bodies(placement: Placement) -> list[Body]:
    """The bodies of all tools of a placement, on the flange.

    Raises:
        CellError: a mesh is refused.
    """
    process, out = milling_of(placement.process), []
    for number, tool in placement.tools.by_number.items():
        mine = None if placement.tools.any_number else number
        drawn = placement.surroundings.tools.get(number, ())
        for entry in drawn:
            shape, inside = table_shape(entry, placement.surroundings.folder)
            frame = entry.placed().then(inside)
            out.append(Body(entry.name, TOOL, shape, frame, role="tool", tool=mine))
        cutter = cutter_of(placement, number)
        if cutter is not None:
            out += _of_cutter(tool, cutter, mine)
        elif not drawn or process is None:
            out += _line(tool, mine)
    return out


def cutter_of(placement: Placement, number: int) -> Cutter | None:
    """The cutter in a tool; None: nothing is milled, or it is not known.

    One tool for whatever number a file calls has the one cutter of the cell, by whatever number the cell has it.
    """
    process = milling_of(placement.process)
    if process is None:
        return None
    cutters = process.cutters
    only = next(iter(cutters.values())) if placement.tools.any_number and len(cutters) == 1 else None
    return cutters.get(None) or cutters.get(number) or only


def milling_of(process: Process) -> MillingProcess | None:
    """The milling behind a process; None where it is another kind."""
    said = getattr(process, "said", process)  # what effects of a model change it from
    if not said.cuts_stock:
        return None
    from compensator.process.milling.milling import MillingProcess  # loads the compiler of the kernels

    return said if isinstance(said, MillingProcess) else None


def _line(tool: Tool, number: int | None) -> list[Body]:
    """What is surely there: a line from the flange to the TCP; its end may cut."""
    if not tool.position.any():
        return []
    placement, length = along_z(np.zeros(3), tool.position)
    reach = max(length - 2 * LINE, 0.0)
    frame = Frame(placement[:3, :3].copy(), placement[:3, 3].copy())
    return [Body(tool.name, TOOL, CapsuleShape(LINE, reach), frame, role="cutter", tool=number, approximate=True)]


def _of_cutter(tool: Tool, cutter: Cutter, number: int | None) -> list[Body]:
    radius, length = cutter.largest_radius, cutter.length
    round_end = cutter.shape == "ball" and length > 2 * radius
    edge: Shape3 = CapsuleShape(radius, length - 2 * radius) if round_end else CylinderShape(radius, length)
    out = [_on_axis(tool, number, edge, ends=(0.0, length), role="cutter")]
    for low, high, thick, kind in cutter.cylinders.tolist():
        role: Role = "holder" if kind == 2.0 else "shank"
        out.append(_on_axis(tool, number, CylinderShape(thick, high - low), ends=(low, high), role=role))
    return out


def _on_axis(tool: Tool, number: int | None, shape: Shape3, *, ends: tuple[float, float], role: Role) -> Body:
    """A body on the axis of a tool between two heights above the tip, m."""
    middle = tool.position - tool.rotation[:, 2] * 0.5 * (ends[0] + ends[1])
    name = role if number is None else f"{role} of tool {number}"
    return Body(name, TOOL, shape, Frame(tool.rotation, middle), role=role, tool=number)
