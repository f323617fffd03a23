"""Used tools: which cutter works at every pose of a path, how fast it turns and which way round."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from toolpaths.finding import NOTE, Finding
from toolpaths.languages.table import LANGUAGES
from toolpaths.toolpath import CLOCKWISE, CUT, SENSE_OPEN, Toolpath

if TYPE_CHECKING:
    from compensator.process.milling.cutter import Cutter

Floats = npt.NDArray[np.float64]
TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Spindle:
    """Where a file gives none: ``speed`` rev/s or None; ``sense`` 1 for M3, -1 for M4, 0: not given."""

    speed: float | None
    sense: int


def used_cutters(
    toolpath: Toolpath, cutters: Mapping[int | None, Cutter], source: str
) -> tuple[tuple[Cutter, ...], npt.NDArray[np.int32]]:
    """The cutters that cut, and the one (N,) of every pose; rapids before a tool call have that of the next cut.

    Raises:
        CellError: a tool cuts that has none; names the line.
    """
    cuts = np.flatnonzero(toolpath.kind == CUT)
    used = toolpath.tool[cuts]
    if None in cutters:
        if (used != used[0]).any():
            k = int(cuts[np.argmax(used != used[0])])
            listed = ", ".join(f"[process.cutters.{n}]" for n in sorted({int(n) for n in used}))
            raise CellError(
                f"{toolpath.source}:{toolpath.line[k]}: a cut with tool {toolpath.tool[k]} after cuts with tool "
                f"{used[0]}, and [process.cutter] of {source} is one cutter: give {listed} in its place"
            )
        return (cutters[None],), np.zeros(len(toolpath), dtype=np.int32)
    if LANGUAGES[toolpath.language].table:
        raise CellError(
            f"{source}: process.cutters: {toolpath.source} is a table without tool numbers: give [process.cutter]"
        )
    missing = ~np.isin(used, [n for n in cutters if n is not None])
    if missing.any():
        k = int(cuts[np.argmax(missing)])
        number = int(toolpath.tool[k])
        what = f"tool {number} cuts" if number else "a cut before any tool call"
        known = ", ".join(str(n) for n in sorted(n for n in cutters if n is not None))
        raise CellError(
            f"{toolpath.source}:{toolpath.line[k]}: {what}, but {source} has [process.cutters.N] for {known} only: "
            f"give [process.cutters.{number}]"
        )
    numbers = sorted({int(n) for n in used})
    following = cuts[np.minimum(np.searchsorted(cuts, np.arange(len(toolpath))), len(cuts) - 1)]
    at = np.where(np.isin(toolpath.tool, numbers), toolpath.tool, toolpath.tool[following])
    return tuple(cutters[n] for n in numbers), np.asarray(np.searchsorted(np.array(numbers), at), dtype=np.int32)


def used_spindle(
    toolpath: Toolpath, given: Spindle, source: str
) -> tuple[Floats, npt.NDArray[np.int8], list[Finding]]:
    """Speed (N,) rev/s, 0 where the file has stopped it, and sense (N,) 1 or -1; what was chosen between two.

    Raises:
        CellError: neither file nor cell give a speed; names the line and the key.
    """
    cut = toolpath.kind == CUT
    speed = toolpath.spindle / TURN
    missing = np.isnan(speed)
    if given.speed is None and (missing & cut).any():
        k = int(np.argmax(missing & cut))
        raise CellError(
            f"{toolpath.source}:{toolpath.line[k]}: no spindle speed for this cut (the file has no S word up to here): "
            f"give process.spindle_rpm in {source}, or S in the file"
        )
    found = []
    own = speed[cut & ~missing & (speed > 0)]
    if given.speed is not None and len(own) and np.abs(own - given.speed).max() > 1e-6 * given.speed:
        shown = " to ".join(dict.fromkeys(f"{v * 60:.6g}" for v in (own.min(), own.max())))
        what = f"the file gives S {shown} 1/min: process.spindle_rpm = {given.speed * 60:g} is not used where it does"
        found.append(Finding(NOTE, f"{source}: process.spindle_rpm", what))
    open_ = toolpath.sense == SENSE_OPEN
    told = toolpath.sense[cut & ~open_]
    if given.sense and len(told) and (told != given.sense).any():
        what = f"the file turns the spindle by {'M3' if told[0] == CLOCKWISE else 'M4'}: process.spindle is not used"
        found.append(Finding(NOTE, f"{source}: process.spindle", what))
    if not given.sense and (open_ & cut).any():
        what = "neither file nor cell tell which way the spindle turns: M3 taken"
        found.append(Finding(NOTE, f"{source}: process", what, 'Give spindle = "m3" or "m4"'))
    sense = np.where(open_, given.sense or 1, toolpath.sense).astype(np.int8)
    return np.where(missing, given.speed or 0.0, speed), sense, found
