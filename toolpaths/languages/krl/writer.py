"""KUKA KRL for KR C2 to KR C5: DEF with $TOOL, $BASE, speeds; PTP to the start, then LIN with C_DIS.

Sources: KUKA System Software 8.3, Operating and Programming Instructions for System Integrators (Status and
Turn, approximate positioning, $APO, $VEL, names of 24 characters), KR C2 Expert Programming 5.2 (E6POS,
FRAME, basic and overhead area). Reasons: docs/krl.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.external_axes import axis_number
from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.rotation import kuka_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.axes import named
from toolpaths.writing.blending import blending, steps_within
from toolpaths.writing.checks import load_findings, six_joints, too_fast
from toolpaths.writing.lines import Between, lines_at_start, lines_before, with_crlf
from toolpaths.writing.names import is_legal, plain, words_of
from toolpaths.writing.numbers import number, printed
from toolpaths.writing.program import Floats, Program

#: Moves a file. KUKA publishes no limit; files of 5,000 lines run, longer ones stall the smartPAD's editor.
MOVES_PER_FILE = 5000

#: All files of a program together, bytes, above which a warning is due: users met limits of 4 to 8 MB in the
#: RAM drive (R1) of a KR C4 with KSS 8.3.
MEMORY = 4_000_000

#: m/s: KUKA's own upper bound of $VEL.CP.
FASTEST = 3.0

NAME_LIMIT = 24
RESERVED = words_of(
    "AND ANIN ANOUT AXIS B_AND B_EXOR B_NOT B_OR BAS BOOL BRAKE CASE CAST_FROM CAST_TO CHAR CIRC CIRC_REL "
    "CONFIRM CONST CONTINUE DECL DEF DEFAULT DEFDAT DEFFCT DO E6AXIS E6POS ELSE END ENDDAT ENDFCT ENDFOR "
    "ENDIF ENDLOOP ENDSWITCH ENDWHILE ENUM EXIT EXOR EXT EXTFCT FALSE FOR FRAME GLOBAL GOTO HALT IF IMPORT "
    "INT INTERRUPT IS LIN LIN_REL LOOP MAXIMUM MINIMUM NOT OFF ON OR POS PRIO PTP PTP_REL PUBLIC PULSE "
    "REAL REPEAT RESUME RETURN SCIRC SEC SIGNAL SLIN SPL SPLINE SPS SPTP STRUC SWITCH THEN TO TRIGGER TRUE "
    "UNTIL WAIT WHEN WHILE"
)
#: $APO.CDIS in m, and $APO.CORI in deg for turns on the spot, rising.
_DISTANCES = (5e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 5e-3)
_TURNS = (0.01, 0.03, 0.1)
_APO = ("", *(" C_DIS" for _ in _DISTANCES), *(" C_ORI" for _ in _TURNS))
_LIN = "%s  LIN {X %.4f,Y %.4f,Z %.4f,A %.5f,B %.5f,C %.5f%s%s}%s\n"


@dataclass(frozen=True)
class _Words:
    """Per pose: the rounding (index into _APO), and lines in front of the move; those before the start."""

    apo: npt.NDArray[np.intp]
    before: dict[int, str]
    at_start: str


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What KRL cannot express, and what the user should know."""
    yield from six_joints(program, "an AXIS of KRL has")
    yield from name_findings(program.name, path, len(program))
    yield from too_fast(program, FASTEST, "the most that $VEL.CP takes")
    if program.configuration is None:
        yield Finding(WARNING, program.robot or "robot", "no spherical wrist: S and T are left out")
    size = len(program) * 90
    if size > MEMORY:
        yield Finding(
            WARNING, path.name, f"about {size / 1e6:.0f} MB of KRL: a KR C4 holds 4 to 8 MB at a time",
            "load the parts one after the other (DirLoader), or sample the path more coarsely",
        )  # fmt: skip
    yield from load_findings(program)


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What KRL does not take as the name of a file."""
    limit = NAME_LIMIT - (4 if moves > MOVES_PER_FILE else 0)
    if not is_legal(path.stem, limit, RESERVED):
        yield Finding(
            ERROR, path.name, f"{path.stem!r} is no KRL name: a letter, then letters, digits and _, at most "
            f"{limit} characters, no reserved word",
            "name the file so: KUKA calls programs by their file's name",
        )  # fmt: skip


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """One .src, or a main one that calls numbered ones."""
    n, per, stem = len(program), MOVES_PER_FILE, path.stem
    bound = blending(program)
    distance = steps_within(bound.radius, _DISTANCES)
    turn = steps_within(np.degrees(bound.turn), _TURNS)
    between = Between(
        comment=lambda text: f"  ; {plain(text)}\n",
        line=lambda line: f"  {line}\n",
        halt=lambda text: f"  ; {plain(text)}\n  HALT\n",
        mount=lambda tool: _mount(program.tools[tool]),
        go=lambda pose: _joint_move(program, program.joints[pose], pose),
    )
    apo = np.where(turn > 0, len(_DISTANCES) + turn, distance)
    words = _Words(apo, lines_before(program, between), lines_at_start(program, between))
    if n <= per:
        yield path.name, with_crlf(_main(program, words, stem, lambda: _moves(program, words, slice(0, n))))
        return
    parts = range(1, -(-n // per) + 1)
    calls = "".join(f"  {stem}_{i:03d}()\n" for i in parts)
    yield path.name, with_crlf(_main(program, words, stem, lambda: iter((calls,))))
    for i in parts:
        block = slice((i - 1) * per, min(i * per, n))
        yield f"{stem}_{i:03d}{path.suffix}", with_crlf(_part(program, words, f"{stem}_{i:03d}", block))


def _main(program: Program, words: _Words, name: str, body: Callable[[], Iterator[str]]) -> Iterator[str]:
    """The program that is selected; ``body`` gives the moves or the calls of the parts."""
    yield _head(name)
    yield (
        "  ;FOLD INI\n"
        "  GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM()\n"
        "  INTERRUPT ON 3\n"
        "  BAS(#INITMOV,0)\n"
        "  ;ENDFOLD (INI)\n"
    )
    yield f"  ; {plain(program.heading + ' ' + program.name + ' for ' + (program.robot or 'robot'))}\n"
    yield f"  ; {plain('Source: ' + program.source_name)}\n"
    yield from (f"  ; {plain(text)}\n" for text in program.stamp)
    yield from _base(program)
    yield _mount(program.tools[int(program.tool[0])])
    yield "  $IPO_MODE=#BASE\n  $ORI_TYPE=#VAR\n  $ADVANCE=5\n  BAS(#VEL_PTP,20)\n"
    yield words.at_start
    for q in (*(() if program.start_joints is None else (program.start_joints,)), program.joints[0]):
        yield _joint_move(program, q, 0)
    yield from body()
    yield words.before.get(len(program), "") + "END\n"


def _base(program: Program) -> Iterator[str]:
    """$BASE: fixed, or on an external kinematic system, which the controller couples to it."""
    carrier = program.carrier
    if carrier is None:
        yield f"  $BASE={_frame(program.workobject)}\n"
        return
    axis, machine = f"E{(axis_number(carrier.axis) or 0) + 1}", f"MACHINE_DEF[{carrier.unit}]"
    for text in (
        f"{axis} turns the part while it cuts: {machine}, mathematically coupled.",
        f"The controller has to have {axis} its axis, synchronous, and its flange,",
        f"with {axis} at 0, in the world here:",
        _frame(carrier.stands),
    ):
        yield f"  ; {plain(text, 120)}\n"
    yield f"  $BASE=EK({machine}.ROOT,{machine}.MECH_TYPE,{_frame(carrier.on_unit(program.workobject))})\n"


def _joint_move(program: Program, q: Floats, pose: int) -> str:
    """To joint angles, external axes where they stand at a pose; an AXIS has none, an E6AXIS has."""
    kind, axes = "E6AXIS" if program.external else "AXIS", named(program, slice(pose, pose + 1))[0]
    angles = ",".join(f"A{i + 1} {a:.6f}" for i, a in enumerate(printed(np.degrees(q), 6).tolist()))
    return f"  PTP {{{kind}: {angles}{axes}}}\n"


def _part(program: Program, words: _Words, name: str, block: slice) -> Iterator[str]:
    yield _head(name)
    yield from _moves(program, words, block)
    yield "END\n"


def _head(name: str) -> str:
    return f"&ACCESS RVP\n&REL 1\n&PARAM EDITMASK = *\nDEF {name}()\n"


def _mount(tool: ToolFrame) -> str:
    """$TOOL, and $LOAD where mass and centre of mass are known."""
    lines = f"  ; tool: {plain(tool.name)}\n  $TOOL={_frame(tool.frame)}\n"
    if tool.mass is not None and tool.com is not None:
        com = _frame(Frame(np.eye(3), tool.com))
        lines += f"  $LOAD={{LOAD: M {number(tool.mass, 3)},CM {com},J {{INERTIA: X 0,Y 0,Z 0}}}}\n"
    return lines


def _moves(program: Program, words: _Words, block: slice) -> Iterator[str]:
    """LIN moves; a file begins with its own speed and rounding, so that it can be started alone."""
    speed, apo = float("nan"), -1
    for b in program.blocks(4096, block.start, block.stop):
        speeds = printed(np.where(program.kind[b] == CUT, program.feed[b], program.rapid_speed), 8)
        before = _before(words, block=b, speeds=speeds, speed=speed, apo=apo)
        speed, apo = float(speeds[-1]), _last_apo(words.apo[b], apo)
        yield _LIN * (b.stop - b.start) % tuple(chain.from_iterable(_rows(program, words, b, before)))


def _before(words: _Words, block: slice, speeds: Floats, speed: float, apo: int) -> list[str]:
    """Lines in front of each move of a block: comments, $VEL and $APO where they change."""
    before = [""] * (block.stop - block.start)
    for pose in words.before.keys() & range(block.start, block.stop):
        before[pose - block.start] = words.before[pose]
    for i in np.flatnonzero(np.diff(speeds, prepend=speed)).tolist():
        before[i] += f"  $VEL.CP={number(float(speeds[i]), 8)}\n"
    steps = words.apo[block]
    rounded = np.flatnonzero(steps > 0)
    for i in rounded[np.diff(steps[rounded], prepend=apo) != 0].tolist():
        before[i] += _apo(int(steps[i]))
    return before


def _last_apo(steps: npt.NDArray[np.intp], apo: int) -> int:
    rounded = steps[steps > 0]
    return int(rounded[-1]) if len(rounded) else apo


def _apo(step: int) -> str:
    if step > len(_DISTANCES):
        return f"  $APO.CORI={_TURNS[step - len(_DISTANCES) - 1]:g}\n"
    return f"  $APO.CDIS={number(_DISTANCES[step - 1] * 1e3, 3)}\n"


def _rows(program: Program, words: _Words, block: slice, before: list[str]) -> Iterator[tuple[object, ...]]:
    position = printed(program.position[block] * 1e3, 4)
    angles = printed(np.degrees(kuka_from_matrix(program.rotation[block])), 5)
    apo = [_APO[i] for i in words.apo[block].tolist()]
    axes = named(program, block)
    return zip(before, *position.T.tolist(), *angles.T.tolist(), _branches(program, block), axes, apo, strict=True)


def _branches(program: Program, block: slice) -> list[str]:
    """S and T of each pose as text, empty where the arm has no spherical wrist."""
    if program.configuration is None:
        return [""] * (block.stop - block.start)
    s, t = status_and_turn(program.joints[block], program.configuration[block])
    texts = [f",S {i // 64},T {i % 64}" for i in range(8 * 64)]
    return [texts[k] for k in (s * 64 + t).tolist()]


def status_and_turn(
    joints: Floats, configuration: npt.NDArray[np.int32]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """(N,) S and (N,) T of joint angles (N, 6) rad and configuration bits (N,).

    T: bit i - 1 is set where axis i is negative. S: bit 0 is set in the overhead area (wrist root point
    behind axis 1), bit 1 where axis 3 is bent forward (wrist root point in front of the lower arm, as at the
    usual A2 -90, A3 90), bit 2 where axis 5 is negative. Source: KSS 8.3, "Status" and "Turn"; points
    taught on real robots agree: S 2,T 35 with A5 positive, S 6,T 50 with A5 negative.
    """
    negative = printed(np.degrees(joints[:, :6]), 6) < 0.0
    turn = negative @ (1 << np.arange(6))
    c = configuration.astype(np.int64)
    status = ((c >> 2) & 1) | ((1 - ((c >> 1) & 1)) << 1) | ((c & 1) << 2)
    return status, turn.astype(np.int64)


def _frame(frame: Frame) -> str:
    values = (*(frame.origin * 1e3), *np.degrees(kuka_from_matrix(frame.rotation)))
    parts = [f"{k} {number(float(v), 5)}" for k, v in zip("XYZABC", values, strict=True)]
    return "{FRAME: " + ",".join(parts) + "}"
