"""Fanuc TP programs as ASCII (.ls) for R-30iA to R-30iB Plus: UFRAME and UTOOL, a joint move, then L moves.

Sources: RoboDK's open post Fanuc_R30iA (sections, UFRAME and UTOOL through a position register, 9999 lines),
Autodesk's Fanuc LS post (names of 30 characters), programs printed by controllers (speeds as ``12mm/sec``,
``7cm/min``, ``2.8inch/min``; remarks; positions). CONFIG: config.py. Reasons: docs/fanuc.md.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from toolpaths.external_axes import axis_number
from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.languages.fanuc.config import config_texts, controller_joints
from toolpaths.languages.fanuc.speeds import FASTEST, SPEED_ERROR, speed_texts, terminations
from toolpaths.rotation import fanuc_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.axes import printed_places
from toolpaths.writing.checks import six_joints
from toolpaths.writing.lines import Between, lines_at_start, lines_before, with_crlf
from toolpaths.writing.names import is_legal, plain
from toolpaths.writing.numbers import printed
from toolpaths.writing.program import Program
from toolpaths.writing.splitting import part_findings, parts

#: Moves a file: with their comments they stay within the 9999 lines that RoboDK's post takes.
MOVES_PER_FILE = 5000

#: User frame, tool and position register that the program sets; the same spare ones that RoboDK's post takes.
FRAME = 9

NAME_LIMIT = 30
_REMARK = 32
HEAD = """/PROG  {name}
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "{comment}";
PROG_SIZE	= 0;
CREATE		= DATE 80-01-01  TIME 00:00:00;
MODIFIED	= DATE 80-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= {lines};
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
"""
EXTENDED = 3  # axes of group 1 beside those of the arm
_POSITION = (
    "P[%d]{\n   GP1:\n"
    f"\tUF : {FRAME}, UT : {FRAME},\t\tCONFIG : '%s',\n"
    "\tX = %10.4f  mm,\tY = %10.4f  mm,\tZ = %10.4f  mm,\n"
    "\tW = %10.5f deg,\tP = %10.5f deg,\tR = %10.5f deg%s\n};\n"
)
JOINT_POSITION = (
    "P[%d]{\n   GP1:\n"
    f"\tUF : {FRAME}, UT : {FRAME},\t\n"
    "\tJ1= %11.6f deg,\tJ2= %11.6f deg,\tJ3= %11.6f deg,\n"
    "\tJ4= %11.6f deg,\tJ5= %11.6f deg,\tJ6= %11.6f deg\n};\n"
)


@dataclass(frozen=True)
class _Words:
    """Per pose: how speed and termination are written."""

    speed: list[str]
    termination: list[str]


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What a TP program cannot express, and what the user should know."""
    robot = program.robot or "robot"
    yield from six_joints(program, "group 1 of a TP program has")
    if program.configuration is None:
        what = "no spherical wrist: the CONFIG of its positions is not known"
        yield Finding(ERROR, robot, what, "write CSV for this arm")
    yield from name_findings(program.name, path, len(program))
    for axis in program.external:
        if (axis_number(axis.name) or 0) >= EXTENDED:
            what = f"external axis {axis.name}: group 1 of a TP program has E1 to E{EXTENDED}"
            yield Finding(ERROR, f"external.{axis.name}", what, "call it by the number that it has on this controller")
    if program.start_joints is not None:
        what = "J3 of the start is written as q3 - q2: Fanuc counts J3 from the horizontal"
        yield Finding(WARNING, "start", what, "run the first move slowly; the model needs Fanuc's signs and zeros")
    yield from _speed_findings(program)
    yield from part_findings(program, MOVES_PER_FILE, "check the mark that a stop leaves")


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What a controller does not take as the name of a file."""
    limit = NAME_LIMIT - (4 if moves > MOVES_PER_FILE else 0)
    if not is_legal(path.stem, limit, ()):
        what = f"{path.stem!r} is no TP program name: a letter, then letters, digits and _, at most {limit} characters"
        yield Finding(ERROR, path.name, what, "name the file so: the controller calls programs by their file's name")


def _speed_findings(program: Program) -> Iterator[Finding]:
    feed = np.where(program.kind == CUT, program.feed, np.nan)
    texts, written = speed_texts(np.append(feed, program.rapid_speed))
    with np.errstate(invalid="ignore"):
        for fast in np.flatnonzero(np.append(feed, program.rapid_speed) > FASTEST)[:1]:
            place = "rapid speed" if fast == len(program) else program.place(int(fast))
            what = f"faster than {FASTEST * 1e3:g} mm/sec, the most a TP program takes"
            yield Finding(ERROR, place, what, "lower the speed")
        off = np.abs(written[:-1] / feed - 1.0) > SPEED_ERROR
    if off.any():
        at = int(np.argmax(off))
        what = f"the feed {feed[at] * 6e4:g} mm/min becomes {texts[at]}, the nearest a TP program can say"
        yield Finding(
            level=WARNING,
            place=program.place(at),
            what=what,
            remedy="take a feed that is a multiple of 10 mm/min",
            count=int(off.sum()),
        )


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """One .ls, or a main one that calls numbered ones."""
    name, blocks = path.stem.upper(), parts(program, MOVES_PER_FILE)
    words = _words(program)
    if len(blocks) == 1:
        moves = _instructions(program, words, blocks[0])
        lines = [*_ordered_at_start(program), *_to_start(program, 1, len(program) + 1), *moves]
        yield (
            path.name,
            with_crlf(
                _text(program, name=name, lines=[*_frames(program), *lines], block=blocks[0], start=len(program) + 1)
            ),
        )
        return
    calls = [f"  CALL {name}_{i:03d}" for i in range(1, len(blocks) + 1)]
    lines = [*_frames(program), *_ordered_at_start(program), *_to_start(program, 1, 2), *calls]
    yield path.name, with_crlf(_text(program, name=name, lines=lines, block=slice(0, 1), start=2))
    for i, block in enumerate(blocks, 1):
        lines = [f"  UFRAME_NUM={FRAME}", f"  UTOOL_NUM={FRAME}", *_instructions(program, words, block)]
        yield (
            f"{path.stem}_{i:03d}{path.suffix}",
            with_crlf(_text(program, name=f"{name}_{i:03d}", lines=lines, block=block, start=None)),
        )


def _words(program: Program) -> _Words:
    speed = np.where(program.kind == CUT, program.feed, program.rapid_speed)
    texts, written = speed_texts(speed)
    return _Words(texts, terminations(program, written))


def _between(program: Program, first: int) -> Between:
    """Instructions between the moves of a program whose positions are counted from pose ``first`` on."""
    return Between(
        comment=lambda text: _joined(remarks(text)),
        line=lambda line: f"  {line.removesuffix(';').rstrip()}\n",
        halt=lambda text: _joined([*remarks(text), "  PAUSE"]),
        mount=lambda tool: _joined(_mount(program.tools[tool])),
        go=lambda pose: f"J P[{pose - first + 1}] 10% FINE\n",
    )


def _joined(lines: list[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _ordered_at_start(program: Program) -> list[str]:
    return lines_at_start(program, _between(program, 0)).splitlines()


def remarks(text: str) -> list[str]:
    """Remarks of at most 32 characters; a semicolon would end the line."""
    clean = plain(text, 200).replace(";", ",")
    return [f"  !{line}" for line in textwrap.wrap(clean, _REMARK)] or ["  !"]


def _frames(program: Program) -> list[str]:
    """Remarks on what is run, and instructions that set the user frame and the first tool."""
    head = f"{program.heading} {program.name} for {program.robot or 'robot'}"
    frame = _frame("UFRAME", program.workobject)
    stamp = [remark for text in program.stamp for remark in remarks(text)]
    lines = [*remarks(head), *remarks(f"Source: {program.source_name}"), *stamp, *frame]
    return [*lines, *_mount(program.tools[int(program.tool[0])])]


def _mount(tool: ToolFrame) -> list[str]:
    """UTOOL, and the load as a remark: a TP program can only choose payload schedules, not set them."""
    lines = remarks(f"tool: {tool.name}")
    if tool.mass is not None:
        lines += remarks(f"PAYLOAD to set: {tool.mass:.3f} kg")
    if tool.com is not None:
        lines += remarks("centre mm " + " ".join(f"{c:.1f}" for c in (tool.com * 1e3 + 0.0).tolist()))
    return lines + _frame("UTOOL", tool.frame)


def _frame(word: str, frame: Frame) -> list[str]:
    """A frame through a position register; LPOS makes the register a Cartesian one first."""
    values = [*(frame.origin * 1e3), *np.degrees(fanuc_from_matrix(frame.rotation))]
    lines = [f"  PR[{FRAME}]=LPOS"]
    for i, value in enumerate(values, 1):
        text = f"{round(float(value), 5) + 0.0:.5f}"
        lines.append(f"  PR[{FRAME},{i}]=" + (f"({text})" if text.startswith("-") else text))
    return [*lines, f"  {word}[{FRAME}]=PR[{FRAME}]", f"  {word}_NUM={FRAME}"]


def _to_start(program: Program, first: int, start: int) -> list[str]:
    """Joint moves: to the start joints, if given, and to the first pose, which its CONFIG makes definite."""
    lines = [] if program.start_joints is None else [f"J P[{start}] 10% FINE"]
    return [*lines, f"J P[{first}] 10% FINE"]


def _instructions(program: Program, words: _Words, block: slice) -> list[str]:
    lines: list[str] = []
    before = lines_before(program, _between(program, block.start), block)
    for pose in range(block.start, block.stop):
        if pose in before:
            lines += before[pose].splitlines()
        lines.append(f"L P[{pose - block.start + 1}] {words.speed[pose]} {words.termination[pose]}")
    return lines + before.get(len(program), "").splitlines()


def _text(program: Program, name: str, lines: list[str], block: slice, start: int | None) -> Iterator[str]:
    """The file: head, numbered lines, positions of the poses of ``block``, and of the start where it has one."""
    yield HEAD.format(name=name, comment="compensated", lines=len(lines))
    for at in range(0, len(lines), 4096):
        yield "".join(f"{i:4d}:{line} ;\n" for i, line in enumerate(lines[at : at + 4096], at + 1))
    yield "/POS\n"
    for b in program.blocks(4096, block.start, block.stop):
        yield _POSITION * (b.stop - b.start) % tuple(chain.from_iterable(_rows(program, b, block.start)))
    if start is not None and program.start_joints is not None:
        text = JOINT_POSITION % (start, *printed(np.degrees(controller_joints(program.start_joints)), 6).tolist())
        yield text.replace("\n};", f"{_axes(program, slice(0, 1))[0]}\n}};")
    yield "/END\n"


def _rows(program: Program, block: slice, first: int) -> Iterator[tuple[object, ...]]:
    position = printed(program.position[block] * 1e3, 4)
    angles = printed(np.degrees(fanuc_from_matrix(program.rotation[block])), 5)
    branch = program.configuration
    configs = config_texts(program.joints[block], None if branch is None else branch[block])
    numbers = range(block.start - first + 1, block.stop - first + 1)
    return zip(numbers, configs, *position.T.tolist(), *angles.T.tolist(), _axes(program, block), strict=True)


def _axes(program: Program, block: slice) -> list[str]:
    """E1 ... E3 behind each position; empty where there are none."""
    columns = []
    for axis in program.external:
        name = f"E{(axis_number(axis.name) or 0) + 1}"
        columns.append([f"\t{name}= {text:>10}  {axis.unit}" for text in printed_places(axis, block)])
    if not columns:
        return [""] * (block.stop - block.start)
    return [",\n" + ",".join(row) for row in zip(*columns, strict=True)]
