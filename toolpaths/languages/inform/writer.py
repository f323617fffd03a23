"""Yaskawa INFORM jobs (.jbi) for DX100 to YRC1000: Cartesian positions in the robot frame, MOVJ to the start, MOVL.

A relative job (ATTR RJ): positions C00000 ... in mm and deg with RCONF, then one move for each. Sources: Yaskawa
DX100 (HW0482494) "Data Transmission", job data format; DX200 and YRC1000 INFORM Language manuals (MOVL: V in
0.1 mm/s, PL); YMConnect SDK (figures of the arm); jobs saved by controllers.
Reasons: docs/inform.md.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from textwrap import wrap

import numpy as np
import numpy.typing as npt

from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.languages.inform.moves import InformMoves, frame_text, moves, rconf
from toolpaths.toolpath import CUT
from toolpaths.writing.checks import six_joints
from toolpaths.writing.lines import Between, interrupted, joint_moves, lines_at_start, lines_before, with_crlf
from toolpaths.writing.names import plain
from toolpaths.writing.program import Program
from toolpaths.writing.splitting import part_findings, parts
from toolpaths.writing.tool_load import load_words

#: Moves a job; lines a job; steps that all jobs of a DX200 hold together.
MOVES_PER_JOB = 5000
LINES = 9999
STEPS = 200_000

#: m/s: what V takes.
SLOWEST, FASTEST = 1e-4, 1.5

#: Largest number of a tool.
TOOLS = 63

_NAME_LIMIT = 32
_COMMENT = 30
_POSITION = "%sC%05d=%.3f,%.3f,%.3f,%.4f,%.4f,%.4f\n"


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What INFORM cannot express, and what the user should know."""
    if program.joints.shape[1] != 6:
        yield from six_joints(program, "a position of INFORM has")
        return
    yield from name_findings(program.name, path, len(program))
    yield from _speed_findings(program)
    yield from _tool_findings(program)
    yield from _branch_findings(program)
    yield from _corner_findings(program)
    yield from _size_findings(program, path)


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What a controller does not take as the name of a job."""
    count = -(-2 * moves // MOVES_PER_JOB)  # a part ends behind a rapid in its second half
    limit = _NAME_LIMIT - (len(f"_{count:03d}") if moves > MOVES_PER_JOB else 0)
    if not re.fullmatch(rf"[A-Za-z0-9][A-Za-z0-9_-]{{0,{limit - 1}}}", path.stem):
        yield Finding(
            ERROR, path.name, f"{path.stem!r} is no INFORM name: letters, digits, _ and -, at most {limit} characters",
            "name the file so: a job is called like its file, in capitals",
        )  # fmt: skip


def _speed_findings(program: Program) -> Iterator[Finding]:
    cut = program.kind == CUT
    feed = np.where(cut, program.feed, program.rapid_speed)
    what = f"V takes {SLOWEST * 1e3:g} to {FASTEST * 1e3:g} mm/s"
    with np.errstate(invalid="ignore"):
        out = cut & ((feed < SLOWEST * (1 - 1e-9)) | (feed > FASTEST * (1 + 1e-9)))
        coarse = cut & ~out & (np.abs(np.round(feed, 4) / feed - 1.0) > 0.01)
    if out.any():
        yield Finding(
            level=ERROR,
            place=program.place(int(np.argmax(out))),
            what=what,
            remedy="change the feed",
            count=int(out.sum()),
        )
    if not SLOWEST <= program.rapid_speed <= FASTEST:
        yield Finding(ERROR, "rapid speed", what, "change the rapid speed")
    if coarse.any():
        yield Finding(
            level=WARNING, place=program.place(int(np.argmax(coarse))),
            what="the feed changes by more than 1 %: V has steps of 0.1 mm/s", remedy="take feeds in such steps",
            count=int(coarse.sum()),
        )  # fmt: skip


def _tool_findings(program: Program) -> Iterator[Finding]:
    for n in sorted({int(t) for t in np.unique(program.tool)}):
        if not 0 <= n <= TOOLS:
            yield Finding(ERROR, f"tool {n}", f"a tool of INFORM has a number from 0 to {TOOLS}", "number it so")
        elif n in program.tools:
            x, y, z, rx, ry, rz = frame_text(program.tools[n].frame)
            load = "".join(f", {words}" for words in load_words(program.tools[n]))
            yield Finding(
                WARNING, f"tool {n}", "a job holds no tool data",
                f"tool file {n} of the controller has to be X {x} Y {y} Z {z} mm, Rx {rx} Ry {ry} Rz {rz} deg{load}",
            )  # fmt: skip
    if program.start_joints is not None:
        yield Finding(
            WARNING, "start", "joint positions stand in encoder pulses of one robot in a job: [start] is not written",
            "drive there by hand before running: the job begins with a joint move to the first pose",
        )  # fmt: skip


def _branch_findings(program: Program) -> Iterator[Finding]:
    c = program.configuration
    if c is None:
        yield Finding(
            WARNING, program.robot or "robot", "no spherical wrist: RCONF says front and upper arm",
            "check the first move",
        )  # fmt: skip
    elif ((c & 4) > 0).any():
        at = (c & 4) > 0
        yield Finding(
            level=WARNING, place=program.place(int(np.argmax(at))), what="the arm reaches behind its axis 1",
            remedy="check RCONF of the first move before running", count=int(at.sum()),
        )  # fmt: skip


def _corner_findings(program: Program) -> Iterator[Finding]:
    """Poses in the middle of a cut where the arm has to stand although nobody asked for it."""
    cut = program.kind == CUT
    inside = moves(program).stop[1:-1] & cut[1:-1] & cut[2:] & (np.diff(program.tool) == 0)[1:]
    if program.exact is not None:
        inside = inside & ~program.exact[1:-1]
    asked = np.zeros(len(program) + 1, dtype=bool)
    asked[interrupted(program)] = True
    inside = inside & ~asked[2:-1]
    if inside.any():
        yield Finding(
            level=WARNING, place=program.place(int(np.argmax(inside)) + 1),
            what="the arm stands in the cut (PL=0): a job cannot say how far to round a corner",
            remedy="sample curves more finely, or set PL by hand", count=int(inside.sum()),
        )  # fmt: skip


def _size_findings(program: Program, path: Path) -> Iterator[Finding]:
    n = len(program)
    for block in parts(program, MOVES_PER_JOB):
        said = "".join(_before(program, block, 0).values())
        if block.stop - block.start + said.count("\n") + _said(program).count("\n") + 3 > LINES:
            what = f"more than {LINES} lines of moves and comments in a job"
            yield Finding(ERROR, program.place(block.start), what, "take comments out")
    yield from part_findings(program, MOVES_PER_JOB, "give the toolpath a rapid there")
    if n > STEPS:
        yield Finding(
            WARNING, path.name, f"{n} moves: the jobs of a DX200 hold {STEPS} steps together",
            "load the parts one after the other, or sample the path more coarsely",
        )  # fmt: skip


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """One job, or a main one that calls numbered ones."""
    stem, words, blocks = path.stem, moves(program), parts(program, MOVES_PER_JOB)
    head = _said(program) + lines_at_start(program, _between(lambda pose: pose)) + "MOVJ C00000 VJ=10.00 PL=0\n"
    if len(blocks) == 1:
        body, poses = chain((head,), _moves(program, words, blocks[0], 1)), _poses(program, blocks[0], 1)
        yield (
            path.name,
            _job(
                stem,
                comment=program.name,
                count=len(poses),
                positions=_positions(program, words, poses),
                body=body,
            ),
        )
        return
    names = [f"{stem}_{i:03d}" for i in range(1, len(blocks) + 1)]
    calls = "".join(f"CALL JOB:{name.upper()}\n" for name in names)
    yield (
        path.name,
        _job(
            stem,
            comment=program.name,
            count=1,
            positions=_positions(program, words, _poses(program, slice(0, 0), 1)),
            body=iter((head + calls,)),
        ),
    )
    for name, block in zip(names, blocks, strict=True):
        poses, text = _poses(program, block, 0), _moves(program, words, block, 0)
        yield (
            name + path.suffix,
            _job(
                name, comment=program.name, count=len(poses), positions=_positions(program, words, poses), body=text
            ),
        )


def _job(name: str, comment: str, count: int, positions: Iterator[str], body: Iterator[str]) -> Iterator[str]:
    """A job with CR LF; its date is fixed, so that the same program gives the same bytes."""
    head = f"/JOB\n//NAME {name.upper()}\n//POS\n///NPOS {count},0,0,0,0,0\n"
    middle = f"//INST\n///DATE 2000/01/01 00:00\n///COMM {plain('Compensated ' + comment, _NAME_LIMIT)}\n"
    middle += "///ATTR SC,RW,RJ\n////FRAME ROBOT\n///GROUP1 RB1\nNOP\n"
    return with_crlf(chain((head,), positions, (middle,), body, ("END\n",)))


def _poses(program: Program, block: slice, first: int) -> npt.NDArray[np.intp]:
    """The poses of a job's positions: ``first`` times that of the MOVJ to the start, then those of the block.

    Every move has a position of its own: poses that a MOVJ and a MOVL go to stand twice.
    """
    twice = [pose for pose in joint_moves(program) if block.start <= pose < block.stop]
    rows = np.insert(np.arange(block.start, block.stop), np.array(twice, dtype=np.intp) - block.start, twice)
    return np.concatenate([np.zeros(first, dtype=np.intp), rows])


def _positions(program: Program, words: InformMoves, poses: npt.NDArray[np.intp]) -> Iterator[str]:
    """Positions of these poses, numbered from 0."""
    tool, conf = -1, ""
    number = 0
    for b in (poses[at : at + 4096] for at in range(0, len(poses), 4096)):
        heads: list[str] = []
        for t, c in zip(program.tool[b].tolist(), rconf(program, b), strict=True):
            kind = "" if tool >= 0 else "///POSTYPE ROBOT\n///RECTAN\n"
            heads.append((f"///TOOL {t}\n" if t != tool else "") + kind + (f"///RCONF {c}\n" if c != conf else ""))
            tool, conf = t, c
        numbers = range(number, number + len(heads))
        rows = zip(heads, numbers, *words.numbers(b).T.tolist(), strict=True)
        yield _POSITION * len(heads) % tuple(chain.from_iterable(rows))
        number += len(heads)


def _moves(program: Program, words: InformMoves, block: slice, first: int) -> Iterator[str]:
    before, own = _before(program, block, first), _own(program, block, first)
    for b in program.blocks(4096, block.start, block.stop):
        numbers = own[b.start - block.start : b.stop - block.start].tolist()
        said = [before.get(i, "") for i in range(b.start, b.stop)]
        ends = [" PL=0\n" if stop else "\n" for stop in words.stop[b].tolist()]
        rows = zip(said, numbers, words.speed[b].tolist(), ends, strict=True)
        yield "%sMOVL C%05d V=%.1f%s" * len(said) % tuple(chain.from_iterable(rows))
    yield before.get(len(program), "")


def _own(program: Program, block: slice, first: int) -> npt.NDArray[np.intp]:
    """The number of the position that the MOVL of each pose of a block goes to; a MOVJ goes to the one before."""
    rows = _poses(program, block, first)[first:]
    return np.asarray(np.searchsorted(rows, np.arange(block.start, block.stop), side="right") - 1 + first)


def _before(program: Program, block: slice, first: int) -> dict[int, str]:
    own = _own(program, block, first)
    return lines_before(program, _between(lambda pose: int(own[pose - block.start]) - 1), block)


def _between(position: Callable[[int], int]) -> Between:
    """Lines between the moves of a job; ``position``: the number of that which the joint move to a pose has."""
    return Between(
        comment=_comment,
        line=lambda line: f"{line}\n",
        halt=lambda text: _comment(text) + "PAUSE\n",
        mount=lambda tool: "",
        go=lambda pose: f"MOVJ C{position(pose):05d} VJ=10.00 PL=0\n",
    )


def _said(program: Program) -> str:
    """The head of the job: where from, and the frames as the operator has to check them."""
    lines = _comment(f"{program.heading} {program.name} for {program.robot or 'robot'}")
    lines += _comment(f"Source: {program.source_name}") + "'Speeds V in mm/s\n"
    lines += "".join(_comment(text) for text in program.stamp)
    for n in sorted({int(t) for t in np.unique(program.tool)}):
        tool = program.tools[n]
        lines += _comment(f"Tool {n} {tool.name}") + _frame_comment(tool.frame)
        lines += "".join(_comment(words) for words in load_words(tool))
    lines += "'Work object in the robot frame\n"
    return lines + _frame_comment(program.workobject)


def _frame_comment(frame: Frame) -> str:
    x, y, z, rx, ry, rz = frame_text(frame)
    return f"'X {x} Y {y}\n'Z {z} mm\n'Rx {rx} Ry {ry}\n'Rz {rz} deg\n"


def _comment(text: str) -> str:
    return "".join(f"'{line}\n" for line in _wrapped(text))


def _wrapped(text: str) -> list[str]:
    """A comment in lines of at most 30 characters; a job takes 32."""
    return wrap(plain(text), _COMMENT) or [""]
