"""Universal Robots URScript (CB3 and e-Series): one function with set_tcp, set_payload, movej to the start, then movel.

Sources: The URScript Programming Language (movej, movel, set_tcp, set_payload, pose_trans, blend radius, rotation
vectors), UR10 manual ("blends cannot overlap"), RoboDK's open post Universal_Robots (blend at most 0.4 of a move, the
call behind the function). Reasons: docs/urscript.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.finding import WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.rotation import ur_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.blending import blending, steps_within
from toolpaths.writing.checks import load_findings, six_joints, too_fast
from toolpaths.writing.lines import Between, lines_at_start, lines_before
from toolpaths.writing.marker import MARKER
from toolpaths.writing.names import legal_name, plain, words_of
from toolpaths.writing.numbers import number, printed
from toolpaths.writing.program import HEADING, Floats, Program
from toolpaths.writing.splitting import part_findings, parts

#: Moves a file: users met a UR5 that takes no more than about 2,500 targets (visose/Robots, issue 55).
MOVES_PER_FILE = 2500

#: m/s: the most that PolyScope lets a safety configuration allow.
FASTEST = 5.0

NAME_LIMIT = 28
RESERVED = words_of(
    "AND BREAK CONTINUE DEF ELIF ELSE END ENTER_CRITICAL EXIT_CRITICAL FALSE FOR GLOBAL HALT IF IN JOIN KILL LOCAL "
    "MOD NOT OR P RETURN RUN SEC SIGNAL THREAD TRUE WAIT WHILE XOR WOBJ V_RAPID MOVEJ MOVEL MOVEC MOVEP POPUP "
    "SET_TCP SET_PAYLOAD POSE_TRANS SLEEP SYNC TEXTMSG"
)
#: Blend radii, m, rising; the last is kept for links between cuts.
_RADII = (5e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 5e-3)
_BLENDS = ("", *(f", r={number(r, 6)}" for r in _RADII))
#: Two blends of half a segment each would touch: this share of the half is taken, as RoboDK's post does.
_SHARE = 0.8
_MOVE = "%s  movel(pose_trans(wobj, p[%.7f, %.7f, %.7f, %.8f, %.8f, %.8f]), a=1.2, v=%s%s)\n"


@dataclass(frozen=True)
class _Words:
    """The function's name, and per pose: how speed and blend are written, lines in front; those before the start."""

    name: str
    speed: list[str]
    blend: npt.NDArray[np.intp]
    before: dict[int, str]
    at_start: str


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What URScript cannot express, and what the user should know."""
    yield from six_joints(program, "movej of URScript takes")
    yield from name_findings(program.name, path, len(program))
    yield from too_fast(program, FASTEST, "the most that the controller lets through")
    if len(program) > MOVES_PER_FILE:
        n = len(parts(program, MOVES_PER_FILE))
        what = f"{n} programs to be run one after the other: a controller takes about {MOVES_PER_FILE} moves at a time"
        yield Finding(WARNING, path.name, what, "start them in the order of their numbers")
        yield from part_findings(program, MOVES_PER_FILE, "give the path a rapid every 1250 moves where a mark matters")
    yield from load_findings(program)


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What URScript does not take as the name of a function."""
    legal = legal_name(name, NAME_LIMIT, RESERVED)
    if legal != name:
        yield Finding(WARNING, "name", f"{name!r} is no URScript name: the function is called {legal}")


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """One .script, or several that are run one after the other, each complete in itself."""
    blocks, words = parts(program, MOVES_PER_FILE), _words(program)
    for i, block in enumerate(blocks, 1):
        following = _part_name(path, i + 1) if i < len(blocks) else None
        function = words.name if i == 1 else f"{words.name}_{i:03d}"
        yield _part_name(path, i), _text(program, words=words, function=function, block=block, following=following)


def _part_name(path: Path, i: int) -> str:
    return path.name if i == 1 else f"{path.stem}_{i:03d}{path.suffix}"


def _words(program: Program) -> _Words:
    bound = blending(program).radius
    rapid = program.kind != CUT
    texts = [number(v, 8) for v in np.where(rapid, program.rapid_speed, program.feed).tolist()]
    speed = ["v_rapid" if r else t for r, t in zip(rapid.tolist(), texts, strict=True)]
    between = Between(
        comment=lambda text: f"  # {plain(text)}\n",
        line=lambda line: f"  {line}\n",
        halt=_popup,
        mount=lambda tool: _mount(program.tools[tool]),
        go=lambda pose: _joint_move(program.joints[pose]),
    )
    name = legal_name(program.name, NAME_LIMIT, RESERVED)
    blend = steps_within(_SHARE * bound, _RADII)
    return _Words(name, speed, blend, lines_before(program, between), at_start=lines_at_start(program, between))


def _popup(text: str) -> str:
    shown = plain(text).replace('"', "'")
    return f'  popup("{shown}", title="halt", warning=False, error=False, blocking=True)\n'


def _text(program: Program, words: _Words, function: str, block: slice, following: str | None) -> Iterator[str]:
    yield f"def {function}():\n"
    yield f"  # {plain(program.heading + ' ' + program.name + ' for ' + (program.robot or 'robot'))}\n"
    yield f"  # {plain('Source: ' + program.source_name)}\n"
    yield f"  # {MARKER}\n" if program.heading == HEADING else ""
    yield from (f"  # {plain(text)}\n" for text in program.stamp if block.start == 0)
    if following:
        yield f"  # continued in: {plain(following, 200)}\n"
    yield f"  wobj = {_pose(program.workobject)}\n"
    yield f"  v_rapid = {number(program.rapid_speed, 8)}\n"
    yield from _to_start(program, block.start, words.at_start)
    yield from _moves(program, words, block)
    yield words.before.get(len(program), "") if block.stop == len(program) else ""
    yield f"end\n\n{function}()\n"


def _to_start(program: Program, first: int, ordered: str) -> Iterator[str]:
    """Joint moves to the start; a later part begins where the one before it ended, without a move."""
    at = max(first - 1, 0)
    yield _mount(program.tools[int(program.tool[at])])
    yield "" if first else ordered
    starts = () if first or program.start_joints is None else (program.start_joints,)
    for q in (*starts, program.joints[at]):
        yield _joint_move(q)


def _joint_move(q: Floats) -> str:
    return "  movej([" + ", ".join(f"{a:.9f}" for a in printed(q, 9).tolist()) + "], a=1.4, v=0.35)\n"


def _mount(tool: ToolFrame) -> str:
    """set_tcp, and set_payload where the mass is known; the centre half way to the TCP where that is not."""
    lines = f"  # tool: {plain(tool.name)}\n  set_tcp({_pose(tool.frame)})\n"
    if tool.mass is not None:
        com = 0.5 * tool.frame.origin if tool.com is None else tool.com
        place = ", ".join(number(float(c), 7) for c in com)
        lines += f"  set_payload({number(tool.mass, 3)}, [{place}])\n"
    return lines


def _pose(frame: Frame) -> str:
    vector = ur_from_matrix(frame.rotation)
    numbers = [*(number(float(v), 8) for v in frame.origin), *(number(float(v), 9) for v in vector)]
    return "p[" + ", ".join(numbers) + "]"


def _moves(program: Program, words: _Words, block: slice) -> Iterator[str]:
    for b in program.blocks(4096, block.start, block.stop):
        yield _MOVE * (b.stop - b.start) % tuple(chain.from_iterable(_rows(program, words, b, block.stop)))


def _rows(program: Program, words: _Words, block: slice, end: int) -> Iterator[tuple[object, ...]]:
    before = [words.before.get(pose, "") for pose in range(block.start, block.stop)]
    position = printed(program.position[block], 7)
    vector = printed(ur_from_matrix(program.rotation[block]), 8)
    blend = [_BLENDS[i] for i in words.blend[block].tolist()]
    if block.stop == end:
        blend[-1] = ""
    return zip(before, *position.T.tolist(), *vector.T.tolist(), words.speed[block], blend, strict=True)
