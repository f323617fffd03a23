"""The flange that the tools of a cell are measured from, where the cell does not name it: what to write.

A built-in robot may have had another flange in earlier versions: refused with the new numbers, or asked about. Of a
URDF the last moving link is taken, and the frame that the controller measures tools from may stand elsewhere.
"""

from __future__ import annotations

import numpy as np

from compensator.cell.cell_file import Cell
from compensator.cell.controller_frames import CELL, tip_findings
from compensator.cell.placement_tables import ToolTable
from compensator.errors import CellError
from stiffness.robot.robot import Robot
from stiffness.robot.tips import MAKERS, FormerFlange
from toolpaths.finding import WARNING, Finding

SHORT = 100.0  # mm: no spindle for an arm that had another flange reaches less far from it


def with_new_numbers(cell: Cell, former: FormerFlange) -> str:
    """What is to be written into a cell whose tools were measured from the former flange."""
    moved = "; ".join(_moved(name, tool, former) for name, tool in _tools(cell))
    return f"A cell that was measured from the former one has to have {moved}; and tip = \"{MAKERS}\""


def flange_findings(cell: Cell, robot: Robot) -> tuple[Finding, ...]:
    """A warning where a cell does not tell which frame its tools are measured from, and that may be another.

    Raises:
        CellError: as ``former_flange_findings``.
    """
    found = tip_findings(robot, cell.source, CELL) if _tools(cell) else ()
    return found or former_flange_findings(cell, robot)


def former_flange_findings(cell: Cell, robot: Robot) -> tuple[Finding, ...]:
    """A warning where a cell does not tell from which flange its tools are measured, and its robot had another once.

    Raises:
        CellError: a tool looks as if it had been measured from there: its centre of mass lies behind the flange, or it
            is shorter than any spindle.
    """
    former = robot.former_flange
    if former is None or cell.tip is not None or not _tools(cell):
        return ()
    told = f"{robot.name}: {former}. {with_new_numbers(cell, former)}"
    for name, tool in _tools(cell):
        behind = bool(tool.mass) and _along(tool.com or (0.0, 0.0, 0.0), former) < 0
        if behind or _along(tool.xyz, former) < SHORT:
            raise CellError(
                f"{cell.source}: {name} may have been shortened for the flange that an earlier version had: "
                f"{_shown(tool)} mm. {told}. If it is measured from {former.now}, set tip = \"{MAKERS}\" only"
            )
    what = f"tools are taken as measured from {former.now}; in earlier versions the flange was {former.was}"
    remedy = f"tip = \"{MAKERS}\" in the cell says that they are. {with_new_numbers(cell, former)}"
    return (Finding(WARNING, cell.source, what, remedy),)


def _tools(cell: Cell) -> list[tuple[str, ToolTable]]:
    several = [(f"tools.{number}", tool) for number, tool in cell.tools.items()]
    return several if cell.tool is None else [("tool", cell.tool)]


def _along(point: tuple[float, float, float], former: FormerFlange) -> float:
    """mm, how far a point lies from the flange in the direction in which the former one stood."""
    return float(np.array(point) @ former.shift / np.linalg.norm(former.shift))


def _moved(name: str, tool: ToolTable, former: FormerFlange) -> str:
    shift = former.shift * 1e3
    com = None if tool.com is None else tuple(np.array(tool.com) + shift)
    x, y, z = (float(v) for v in np.array(tool.xyz) + shift)
    return f"{name}: {_shown(tool.model_copy(update={'xyz': (x, y, z), 'com': com}))}"


def _shown(tool: ToolTable) -> str:
    com = "" if tool.com is None else f", com = {_numbers(tool.com)}"
    return f"xyz = {_numbers(tool.xyz)}{com}"


def _numbers(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(f"{v:g}" for v in values) + "]"
