"""Checks that hold for a program in every controller language."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from toolpaths.columns import blocks
from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.toolpath import CUT, RAPID
from toolpaths.writing.program import Floats, Program

#: Rotations further from orthonormal than this are not rotations.
ORTHONORMAL = 1e-6

_ARRAYS = ("position", "rotation", "joints", "nominal_position", "nominal_rotation", "wrench", "deflection")


def common_findings(program: Program) -> Iterator[Finding]:
    """Everything that no controller language can write."""
    if len(program) == 0:
        yield Finding(ERROR, program.source or program.name, "no pose", "give a toolpath with moves")
        return
    yield from _numbers(program)
    yield from _rotations(program)
    yield from _speeds(program)
    yield from _kinds_and_tools(program)


def _numbers(program: Program) -> Iterator[Finding]:
    for name in _ARRAYS:
        value = getattr(program, name)
        if isinstance(value, np.ndarray):  # what is made where it is written is made of these
            bad = np.zeros(len(value), dtype=bool)
            for block in blocks(len(program)):
                bad[block] = ~np.isfinite(value[block].reshape(block.stop - block.start, -1)).all(axis=1)
            yield from _at(program, bad, f"{name} is not a finite number", "report this as a defect")
    if not np.isfinite(program.workobject.matrix).all():
        yield Finding(ERROR, "workobject", "not a finite number")
    for axis in program.external:
        bad = np.ones(len(program), dtype=bool) if len(axis.places) != len(program) else ~np.isfinite(axis.places)
        yield from _at(program, bad, f"external axis {axis.name} is not a finite number", "report this as a defect")
    if program.start_joints is not None and not np.isfinite(program.start_joints).all():
        yield Finding(ERROR, "start_joints", "not a finite number")
    for number, tool in program.tools.items():
        parts = [tool.frame.matrix, tool.com, tool.mass]
        if not all(np.isfinite(np.asarray(p, dtype=float)).all() for p in parts if p is not None):
            yield Finding(ERROR, f"tool {number}", "not a finite number")


def _rotations(program: Program) -> Iterator[Finding]:
    bad = np.zeros(len(program), dtype=bool)
    for block in blocks(len(program)):
        bad[block] = ~_is_rotation(program.rotation[block])
    yield from _at(program, bad, "the orientation is no rotation", "report this as a defect")
    frames = {"workobject": program.workobject}
    frames.update({f"tool {n}": tool.frame for n, tool in program.tools.items()})
    for name, frame in frames.items():
        if not _is_rotation(frame.rotation[None])[0]:
            yield Finding(ERROR, name, "the orientation is no rotation")


def _is_rotation(r: Floats) -> npt.NDArray[np.bool_]:
    """(N,) of (N, 3, 3)."""
    with np.errstate(invalid="ignore"):
        off = np.abs(np.einsum("nij,nkj->nik", r, r) - np.eye(3)).max(axis=(1, 2))
        return np.asarray((off <= ORTHONORMAL) & (np.linalg.det(r) > 0.0))


def _speeds(program: Program) -> Iterator[Finding]:
    cut = program.kind == CUT
    missing = cut & np.isnan(program.feed)
    yield from _at(program, missing, "a cutting move without a feed", "give feeds in the toolpath")
    with np.errstate(invalid="ignore"):
        stopped = cut & ~np.isnan(program.feed) & ~((program.feed > 0.0) & np.isfinite(program.feed))
    yield from _at(program, stopped, "a feed that is not above 0", "correct the feed in the toolpath")
    if not (np.isfinite(program.rapid_speed) and program.rapid_speed > 0.0):
        yield Finding(ERROR, "rapid speed", f"{program.rapid_speed} m/s is not above 0")


def _kinds_and_tools(program: Program) -> Iterator[Finding]:
    strange = (program.kind != CUT) & (program.kind != RAPID)
    yield from _at(program, strange, "neither a rapid nor a cut")
    for number in np.unique(program.tool):
        if int(number) not in program.tools:
            bad = program.tool == number
            remedy = f"declare [tools.{number}] in the cell"
            yield from _at(program, bad, f"tool {number} has no frame", remedy)
    for number, tool in program.tools.items():
        if tool.mass is not None and tool.mass < 0.0:
            yield Finding(ERROR, f"tool {number}", f"mass {tool.mass:g} kg is negative")


def unsaid(program: Program, language: str, says: Callable[[str], bool]) -> Iterator[Finding]:
    """A warning that lists what the source asks of the machine and the program leaves out.

    Args:
        language: of the program.
        says: whether it has a word for a command of G-code.
    """
    left = [o for o in program.orders if o.lines is None and o.command.word != "T" and not says(o.command.word)]
    if left:
        words = ", ".join(sorted({o.command.word for o in left}, key=lambda word: (len(word), word)))
        what = f"a program in {language} has no words of its own for {words}: they are comments in it"
        remedy = '[program.events] of the cell says what the controller does, such as M3 = ["..."], or [] for nothing'
        places = tuple(dict.fromkeys(f"{o.source or program.source}:{o.line}" for o in left))
        yield Finding(WARNING, places[0], what, remedy, count=len(left), places=places if len(places) > 1 else ())


def six_joints(program: Program, what: str) -> Iterator[Finding]:
    """An error for arms with another number of joints; ``what`` has or takes 6."""
    if program.joints.shape[1] != 6:
        problem = f"{program.joints.shape[1]} joints: {what} 6"
        yield Finding(ERROR, program.robot or "robot", problem, "write CSV for this arm")


def too_fast(program: Program, fastest: float, limit: str) -> Iterator[Finding]:
    """Errors for speeds above ``fastest``, m/s: ``limit`` is what the language takes."""
    with np.errstate(invalid="ignore"):
        fast = (program.kind == CUT) & (program.feed > fastest)
    what = f"faster than {fastest:g} m/s, {limit}"
    yield from _at(program, fast, what, "lower the feed")
    if program.rapid_speed > fastest:
        yield Finding(ERROR, "rapid speed", what, "lower the rapid speed")


def load_findings(program: Program) -> Iterator[Finding]:
    """Warnings for tools whose load is not known, in languages that write it."""
    for number in sorted({int(t) for t in np.unique(program.tool)}):
        tool = program.tools.get(number)
        if tool is not None and (tool.mass is None or tool.com is None):
            what = "mass" if tool.mass is None else "centre of mass"
            yield Finding(
                WARNING, f"tool {number}", f"the {what} is not known: the program declares no real load",
                "give mass and com in the cell, or set the load on the controller before running",
            )  # fmt: skip


def _at(program: Program, bad: npt.NDArray[np.bool_], what: str, remedy: str = "") -> Iterator[Finding]:
    if bad.any():
        yield Finding(
            level=ERROR, place=program.place(int(np.argmax(bad))), what=what, remedy=remedy, count=int(bad.sum())
        )


def without_axes(names: Sequence[str], language: str) -> list[Finding]:
    """An error where a program has external axes, and its language no word for them."""
    if not names:
        return []
    what = f"a program in {language} has no place for external axes, and {', '.join(names)} would be lost"
    remedy = "write RAPID, KRL, Fanuc TP or csv, or take free = true away"
    return [Finding(ERROR, f"external.{names[0]}", what, remedy)]
