"""Tool and work object of a robot program: they hold, and what the cell gives all the same has to agree."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import Cell
from compensator.cell.placement_tables import ToolTable, WorkObjectTable
from compensator.errors import CellError
from toolpaths.frame import Frame
from toolpaths.rotation import rpy_from_matrix, turn_between
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT, Setting, Toolpath

Floats = npt.NDArray[np.float64]

SAME_FRAME = 1e-5  # m: frames of cell and program that are nearer are the same
SAME_TURN = 1e-4  # rad


def with_program_frames(cell: Cell, toolpath: Toolpath, setting: Setting) -> Cell:
    """The cell with work object and tools of a program; mass and centre of mass are the cell's where it has them.

    Raises:
        CellError: cell and program contradict each other, or neither has a frame that is needed.
    """
    workobject = _workobject(cell, toolpath, setting)
    tools = _tools(cell, toolpath, setting)
    return cell.model_copy(update={"workobject": workobject, "tool": None, "tools": tools})


def _workobject(cell: Cell, toolpath: Toolpath, setting: Setting) -> WorkObjectTable:
    given = cell.workobject.xyz is not None
    frame = setting.workobject if setting.carried is None else _on_table(cell, *setting.carried)
    if frame is None:
        if not given:
            raise CellError(f"{cell.source}: workobject is missing, and {toolpath.source} only names it: give it here")
        return cell.workobject
    if given:
        what = f"{cell.source}: [workobject] is not the work object of {toolpath.source}"
        _refuse_other(what, cell.workobject.frame(), frame)
    rpy = np.degrees(rpy_from_matrix(frame.rotation))
    origin, touched = _three(frame.origin * 1e3), cell.workobject.touched_off
    return WorkObjectTable.model_construct(xyz=origin, rpy=_three(rpy), touched_off=touched)


def _on_table(cell: Cell, unit: str | int, on_unit: Frame) -> Frame | None:
    """The work object in the base with the axis of its mechanical unit at 0; None: the cell does not know the unit."""
    for axis in cell.external.values():
        stands = axis.unit_frame()
        if stands is not None and str(axis.unit).lower() == str(unit).strip('"').lower():
            return stands.then(on_unit)
    return None


def _tools(cell: Cell, toolpath: Toolpath, setting: Setting) -> dict[int, ToolTable]:
    """[tools.N] by the numbers of the toolpath."""
    cuts = np.flatnonzero(toolpath.kind == CUT)
    numbers = np.unique(toolpath.tool[cuts]).tolist()
    named = [number for number in numbers if number not in setting.tools]
    if cell.tool is not None and len(numbers) > 1 and named:
        k = int(cuts[np.argmax(toolpath.tool[cuts] == named[0])])
        raise CellError(
            f"{toolpath.where(k)}: a cut with tool {named[0]}, whose frame is not in the program, "
            f"beside {len(numbers) - 1} others, and [tool] of {cell.source} is one tool: give [tools.{named[0]}]"
        )
    return {number: _tool(cell, toolpath, number, setting.tools.get(number)) for number in numbers}


def _cell_tool(cell: Cell, number: int, program: ToolFrame | None) -> ToolTable | None:
    if cell.tool is not None:
        return cell.tool
    named = [t for t in cell.tools.values() if program and t.name.lower() == program.name.lower()]
    return named[0] if named else cell.tools.get(number)


def _tool(cell: Cell, toolpath: Toolpath, number: int, program: ToolFrame | None) -> ToolTable:
    own = _cell_tool(cell, number, program)
    if program is None:
        if own is None:
            raise CellError(
                f"{cell.source}: no tool: {toolpath.source} cuts with tool {number}, whose frame is not in the "
                f"program: give [tools.{number}]"
            )
        return own
    if own is not None:
        tool = own.tool()
        what = f"{cell.source}: tool {own.name!r} is not {program.name} of {toolpath.source}"
        _refuse_other(what, Frame(tool.rotation, tool.position), program.frame)
    mass, com = (own.mass, own.com) if own is not None and own.mass is not None else (program.mass, None)
    if com is None and program.com is not None and mass == program.mass:
        com = _three(program.com * 1e3)
    xyz, rpy = program.frame.origin * 1e3, np.degrees(rpy_from_matrix(program.frame.rotation))
    return ToolTable.model_construct(
        xyz=_three(xyz), rpy=_three(rpy), mass=mass, com=com, name="tool" if own is None else own.name,
        bodies=() if own is None else own.bodies,
    )  # fmt: skip


def _refuse_other(what: str, own: Frame, program: Frame) -> None:
    off = float(np.linalg.norm(own.origin - program.origin))
    turned = float(turn_between(np.array([own.rotation, program.rotation]))[0])
    if off > SAME_FRAME or turned > SAME_TURN:
        shown = [", ".join(f"{v * 1e3:.3f}" for v in frame.origin) for frame in (own, program)]
        raise CellError(
            f"{what}: ({shown[0]}) mm against ({shown[1]}) mm, {np.degrees(turned):.4f} deg apart; the program's "
            "holds: correct the cell"
        )


def _three(values: Floats) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
