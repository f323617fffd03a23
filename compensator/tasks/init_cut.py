"""The cut of a new cell: its answers against the CAM file, so that what `init` writes runs as it stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from compensator.cell.cell_file import Cell
from compensator.cell.new_cut import UNKNOWN, CutAnswers, cutters_of, stock_of
from compensator.cell.placement import placement_of
from compensator.errors import CellError, CompensatorError
from compensator.process.milling.cutter_table import CutterTable
from compensator.process.milling.fit_check import refuse_apart
from compensator.process.milling.material import builtin_materials, find_material
from compensator.process.milling.milling import MillingProcess
from compensator.process.process import ToolMotion
from toolpaths.finding import Finding
from toolpaths.frame import Frame
from toolpaths.languages.table import LANGUAGES
from toolpaths.toolpath import CUT, Toolpath


def cut_asked(
    words: Mapping[str, str], toolpath: Toolpath | None, cam: Path, seen: Callable[[Path], str]
) -> CutAnswers:
    """The cut that was answered.

    Args:
        words: ``cutter``, ``material``, ``stock``, ``spindle_rpm``.
        seen: a file as the cell names it.

    Raises:
        CompensatorError: an answer is refused, is missing, or does not fit the CAM file.
    """
    for key in ("material", "stock"):
        if not words[key].strip():
            raise CompensatorError(f"--cutter without --{key}: the force is computed from cutter, material and stock")
    cutters = cutters_of(words["cutter"])
    if toolpath is not None:
        _refuse_other_tools(toolpath, cutters)
    find_material(words["material"], Path(), "material")
    builtin = words["material"] in builtin_materials()
    stock = stock_of(words["stock"], toolpath, cutters)
    if stock.file is not None:
        stock = stock.model_copy(update={"file": seen(Path(stock.file))})
    spindle = _rpm(words["spindle_rpm"])
    if toolpath is not None and spindle is None and np.isnan(toolpath.spindle[toolpath.kind == CUT]).any():
        raise CompensatorError(f"{cam}: gives no spindle speed (S) for some cuts: give --spindle-rpm, 1/min")
    material = words["material"] if builtin else seen(Path(words["material"]))
    assumed = words["stock"].strip() == UNKNOWN
    return CutAnswers(cutters, material, stock, assumed=assumed, spindle=spindle)


def used_tools(toolpath: Toolpath) -> list[int]:
    """Numbers of the tools that cut, ascending."""
    return sorted({int(n) for n in toolpath.tool[toolpath.kind == CUT]})


def _rpm(words: str) -> float | None:
    try:
        value = float(words) if words.strip() else None
    except ValueError:
        value = 0.0
    if value is not None and not 0.0 < value <= 200_000.0:
        raise CellError(f"spindle_rpm = {words!r}: expected a speed above 0, 1/min")
    return value


def _refuse_other_tools(toolpath: Toolpath, cutters: Mapping[int | None, CutterTable]) -> None:
    """Refuse cutters that are not those of the file."""
    used = used_tools(toolpath)
    listed = "; ".join(f"{n}=..." for n in used)
    if None in cutters:
        if len(used) > 1:
            raise CellError(f"cutter: one is given, and {toolpath.source} cuts with {len(used)} tools: give {listed!r}")
    elif LANGUAGES[toolpath.language].table:
        raise CellError(f"cutter: {toolpath.source} is a table without tool numbers: give one cutter without a number")
    elif missing := [n for n in used if n not in cutters]:
        what = f"cutter: {toolpath.source} cuts with tool {missing[0]} too, and none is given: give {listed!r}"
        raise CellError(what)


def refuse_unfit(cell: Cell, toolpath: Toolpath | None) -> tuple[Finding, ...]:
    """Findings about the cut of a cell that was just made; its material, meshes and cutters are read.

    Raises:
        CellError: they are refused, a cutter is longer than its tool, or a mesh is never met.
    """
    process = placement_of(cell).process
    if toolpath is None or not isinstance(process, MillingProcess):
        return ()
    place = Frame(np.broadcast_to(np.eye(3), (len(toolpath), 3, 3)), toolpath.position)
    path, found = process.milling_path(ToolMotion(toolpath, Frame.identity(), place))
    if process.shop.stock_file:
        refuse_apart(path, process.shop.stock, process.shop.stock_file, process.shop.units)
    return tuple(found)
