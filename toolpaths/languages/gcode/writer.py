"""G-code (RS-274, Fanuc dialect): position and vector of the tool under G43.4, one move a line.

Sources: Fanuc Series 30i operator's manual B-64484EN, "Tool center point control" and "Feed functions" (G61, G64);
LinuxCNC G-code reference. What a controller has to be able to do: docs/gcode.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.finding import WARNING, Finding
from toolpaths.rotation import rpy_from_matrix
from toolpaths.toolpath import CUT
from toolpaths.writing.lines import MOUNT, Between, lines_at_start, lines_before
from toolpaths.writing.marker import MARKER
from toolpaths.writing.names import plain
from toolpaths.writing.numbers import number
from toolpaths.writing.program import Floats, Order, Program

#: Comments that are words of G-code: spindle and coolant come back as what they were.
_WORDS = re.compile(r"(?:S\d+(?:\.\d+)? ?)?(?:M0?[345789])?")
_M_WORD = re.compile(r"M\d+")
_CALL = re.compile(r"(?:T\d+ ?)?M0?6")
_XYZ, _IJK = 4, 7  # decimals of mm and of the vector: 0.05 um, 0.1 urad
_FEED = 4  # decimals of mm/min


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What G-code cannot express."""
    yield Finding(
        WARNING, path.name, "G-code carries position and vector of the tool: the turn about it and the arm "
        "configuration are left to the controller",
        "compare the joint angles on the controller with those of the program as csv",
    )  # fmt: skip


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """Nothing: a name is a comment."""
    yield from ()


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """The one file."""
    yield path.name, _text(program)


def _text(program: Program) -> Iterator[str]:
    yield f"%\n({MARKER})\n"
    yield f"({_comment('program ' + program.name + ' for ' + (program.robot or 'robot'))})\n"
    yield f"({_comment('source: ' + program.source_name)})\n"
    yield from (f"({_comment(text)})\n" for text in program.stamp)
    angles = np.degrees(rpy_from_matrix(program.workobject.rotation))
    values = [number(float(v), 4) for v in (*(program.workobject.origin * 1e3), *angles)]
    yield f"(G54 is the work object: xyz {' '.join(values[:3])} mm, rpy {' '.join(values[3:])} deg in the base)\n"
    yield "G21 G90 G94 G17 G40 G54\n"
    before = _before(program)
    last: _Last = (np.full(8, np.nan), False)
    for block in program.blocks():
        lines, last = _lines(program, block, before, last)
        yield "".join(lines)
    yield before.get(len(program), "") + "G49\nM30\n%\n"


#: Numbers of the line before (x, y, z, i, j, k, feed, motion), and whether it had to be reached.
_Last = tuple[Floats, bool]


def _before(program: Program) -> dict[int, str]:
    """Lines in front of moves: comments, spindle and coolant, tool calls."""
    between = Between(
        comment=lambda text: (text if text and _WORDS.fullmatch(text) else f"({_comment(text)})") + "\n",
        line=lambda line: f"{line}\n",
        halt=lambda text: f"({_comment(text)})\nM0\n",
        change=lambda tool: f"G49\n{_call(program, tool)}",
        mount=lambda tool: f"G43.4 H{max(tool, 1)}\n",
        go=lambda pose: "",
        say=_said,
    )
    mounted = _mounted(program)
    said = {(order.pose, order.text) for order in program.orders if _is_said(order, mounted)}
    rest = tuple((pose, text) for pose, text in program.comments if (pose, text) not in said)
    before = lines_before(replace(program, comments=rest), between)
    first = int(program.tool[0]) or mounted.pop(0, 0)
    given = any(o.pose == 0 and o.command.word == MOUNT and o.lines is not None for o in program.orders)
    call = "" if given else _call(program, first)
    before[0] = before.get(0, "") + call + lines_at_start(program, between) + between.mount(first)
    for pose, tool in mounted.items():
        before[pose] = f"G49\n{_call(program, tool)}" + before.get(pose, "") + between.mount(tool)
    return before


def _mounted(program: Program) -> dict[int, int]:
    """Pose -> number of the tool that the source mounts in front of it, where the cell has one tool for all of them."""
    out: dict[int, int] = {}
    for order in program.orders if not program.tool.any() else ():
        number = int(order.command.values.get("T", 0.0)) if order.command.word == MOUNT and order.lines is None else 0
        if number and number != next(reversed(out.values()), 0):
            out[order.pose] = number
    return out


def _call(program: Program, tool: int) -> str:
    name = program.tools[tool if tool in program.tools else 0].name
    return f"({_comment(f'tool {tool}: {name}')})\n" + (f"T{tool} M6\n" if tool else "")


def _is_said(order: Order, mounted: dict[int, int]) -> bool:
    """Whether an order stands in the program as words, so that its text need not be a comment."""
    call = order.command.word == MOUNT and order.pose in mounted and _CALL.fullmatch(order.text) is not None
    return call or order.lines is not None or bool(_said(order))


def _said(order: Order) -> str:
    """The words of an order; empty where G-code has none, or they stand elsewhere."""
    word, values = order.command.word, order.command.values
    if word == "T":
        return f"T{values['T']:g}\n"
    if word == "G4":
        return f"G4 P{number(values['P'], 4)}\n"
    if word == MOUNT or not _M_WORD.fullmatch(word):
        return ""
    speed = f"S{number(values['S'], 3)} " if "S" in values else ""
    return f"{speed}{word}\n"


def _changes(program: Program) -> npt.NDArray[np.intp]:
    """Poses in front of which a tool is called."""
    changed = np.flatnonzero(np.diff(program.tool, prepend=program.tool[0] - 1))
    return np.union1d(changed, list(_mounted(program))).astype(np.intp)


def _comment(text: str) -> str:
    return plain(text).replace("(", "[").replace(")", "]")


def _lines(program: Program, block: slice, before: dict[int, str], last: _Last) -> tuple[list[str], _Last]:
    """The lines of one block of poses; words that are in force are left out."""
    table = _table(program, block, last[0])
    new = np.diff(table, axis=0, prepend=last[0][None]) != 0.0
    tools = _changes(program)
    new[tools[(tools >= block.start) & (tools < block.stop)] - block.start] = True
    new[:, 3:6] |= new[:, 3:6].any(axis=1, keepdims=True)  # a vector is written whole
    new[:, 0] |= ~new[:, :6].any(axis=1)  # a line moves, if only to where it is
    new[:, 6] &= table[:, 7] == 1.0
    columns = [_column(" X", _XYZ, table[:, 0], new[:, 0]), _column(" Y", _XYZ, table[:, 1], new[:, 1]),
               _column(" Z", _XYZ, table[:, 2], new[:, 2]), _column(" I", _IJK, table[:, 3], new[:, 3]),
               _column(" J", _IJK, table[:, 4], new[:, 4]), _column(" K", _IJK, table[:, 5], new[:, 5])]  # fmt: skip
    feeds = [
        f" F{number(f, _FEED)}" if n else "" for f, n in zip(table[:, 6].tolist(), new[:, 6].tolist(), strict=True)
    ]
    motion = [f" G{int(m)}" if n else "" for m, n in zip(table[:, 7].tolist(), new[:, 7].tolist(), strict=True)]
    exact = np.zeros(len(table), dtype=np.bool_) if program.exact is None else program.exact[block]
    stop = _column_exact(exact, last[1])
    lines = [
        before.get(block.start + k, "") + "".join(words).lstrip() + "\n"
        for k, words in enumerate(zip(stop, motion, *columns, feeds, strict=True))
    ]
    return lines, (table[-1], bool(exact[-1]))


def _table(program: Program, block: slice, last: Floats) -> Floats:
    """(B, 8) numbers as they are printed: x, y, z mm, i, j, k, feed mm/min, motion; rapids keep the feed in force."""
    cut = program.kind[block] == CUT
    feed = np.where(cut, np.round(program.feed[block] * 6e4, _FEED), np.nan)
    at = np.maximum.accumulate(np.where(cut, np.arange(len(cut)), -1))
    feed = np.where(at >= 0, feed[np.maximum(at, 0)], last[6])
    xyz = np.round(program.position[block] * 1e3, _XYZ)
    ijk = np.round(-program.rotation[block][:, :, 2], _IJK)
    return np.column_stack((xyz, ijk, feed, cut)) + 0.0


def _column(word: str, digits: int, values: Floats, new: npt.NDArray[np.bool_]) -> list[str]:
    return [f"{word}{v:.{digits}f}" if n else "" for v, n in zip(values.tolist(), new.tolist(), strict=True)]


def _column_exact(exact: npt.NDArray[np.bool_], last: bool) -> list[str]:
    """G61 where a pose has to be reached, G64 behind it."""
    words = {1: " G61", -1: " G64", 0: ""}
    return [words[c] for c in np.diff(exact.astype(np.int8), prepend=np.int8(last)).tolist()]
