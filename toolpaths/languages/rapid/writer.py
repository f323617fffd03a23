"""ABB RAPID for IRC5: MODULE with tool, work object, speeds and zones; MoveAbsJ to the start, then MoveL.

Sources: ABB 3HAC050917 "RAPID Instructions, Functions and Data types" (confdata, robtarget, zonedata,
speeddata, tooldata, loaddata, MoveL, MoveAbsJ, ConfL, SingArea), 3HAC16580 "RAPID overview" (identifiers of
32 characters, reserved words). Reasons: docs/rapid.md.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.languages.rapid.workobject import numbers_text, pose_text, workobject_lines
from toolpaths.rotation import quaternion_from_matrix
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT
from toolpaths.writing.axes import eax
from toolpaths.writing.blending import blending, steps_within
from toolpaths.writing.checks import load_findings, six_joints
from toolpaths.writing.lines import Between, lines_at_start, lines_before, with_crlf
from toolpaths.writing.names import legal_name, plain, words_of
from toolpaths.writing.numbers import number, printed
from toolpaths.writing.program import Floats, Program

#: Moves a module: what RoboDK's ABB IRC5 post takes for the same purpose. ABB publishes no figure.
MOVES_PER_MODULE = 5000

#: Distinct feeds up to this are declared as speeddata, more are written into the moves with \V.
DECLARED_SPEEDS = 200

NAME_LIMIT = 24  # 32 less what is appended: _001, _run_001, _wobj
RESERVED = words_of(
    "ALIAS AND BACKWARD CASE CONNECT CONST DEFAULT DIV DO ELSE ELSEIF ENDFOR ENDFUNC ENDIF ENDMODULE ENDPROC "
    "ENDRECORD ENDTEST ENDTRAP ENDWHILE ERROR EXIT FALSE FOR FROM FUNC GOTO IF INOUT LOCAL MOD MODULE NOT "
    "NOSTEPIN NOVIEW OR PERS PROC RAISE READONLY RECORD RETRY RETURN STEP SYSMODULE TASK TEST THEN TO TRAP "
    "TRUE TRYNEXT UNDO VAR VIEWONLY WHILE WITH XOR MAIN USER BASE"
)
_NO_AXES = "9E9,9E9,9E9,9E9,9E9,9E9"
#: Zone names and radii, m, rising. z0, z1 and z5 are ABB's own (0.3, 1 and 5 mm; z5 turns within 8 mm).
_ZONES = (
    ("zc5", 5e-6), ("zc10", 1e-5), ("zc30", 3e-5), ("zc100", 1e-4),
    ("z0", 3e-4), ("z1", 1e-3), ("z5", 8e-3),
)  # fmt: skip
#: Zones of turns on the spot, deg.
_TURNS = (("zt10", 0.01), ("zt30", 0.03), ("zt100", 0.1))
_ZONE_NAMES = ("fine", *(z for z, _ in _ZONES), *(z for z, _ in _TURNS))
_MOVE = "%s    MoveL [[%.4f,%.4f,%.4f],[%.8f,%.8f,%.8f,%.8f],[%d,%d,%d,%d],[%s]],%s;\n"


@dataclass(frozen=True)
class _Words:
    """The names that the moves of one program use.

    Attributes:
        module: legal name of the main module.
        tools: tool number -> name of its tooldata.
        zone: (N,) index into _ZONE_NAMES.
        speed: (N,) index into ``speeds``.
        speeds: how each speed is written in a move; the last one is that of rapids.
        declared: name, mm/s of the speeddata to declare.
        before: pose -> lines in front of its move.
        at_start: lines in front of the moves to the start.
    """

    module: str
    tools: dict[int, str]
    zone: npt.NDArray[np.intp]
    speed: npt.NDArray[np.intp]
    speeds: tuple[str, ...]
    declared: tuple[tuple[str, float], ...]
    before: dict[int, str]
    at_start: str


def findings(program: Program, path: Path) -> Iterator[Finding]:
    """What RAPID cannot express, and what the user should know."""
    yield from six_joints(program, "a robtarget of RAPID has")
    yield from name_findings(program.name, path, len(program))
    if program.configuration is None:
        yield Finding(
            WARNING, program.robot or "robot", "no spherical wrist: cfx is written as 0",
            "run with ConfL \\Off, as written",
        )  # fmt: skip
    yield from load_findings(program)
    if program.carrier is not None and not program.carrier.about_z:
        what = "z of unit_rpy, or unit_xyz, is not on the axis of the table, as those of ABB's units that turn are"
        remedy = "check direction and center, and which way the value rises on the controller"
        yield Finding(WARNING, f"external.{program.carrier.axis}", what, remedy)


def name_findings(name: str, path: Path, moves: int) -> Iterator[Finding]:
    """What RAPID does not take as names of module and file."""
    if moves > MOVES_PER_MODULE and not re.fullmatch(r"[A-Za-z0-9_. -]+", path.name):
        yield Finding(
            ERROR, path.name, "a .pgf lists the modules of a program of more than "
            f"{MOVES_PER_MODULE} moves, and cannot spell this name", "use letters, digits, _, - and . only",
        )  # fmt: skip
    legal = legal_name(name, NAME_LIMIT, RESERVED)
    if legal != name:
        yield Finding(WARNING, "name", f"{name!r} is no RAPID name: the module is called {legal}")


def files(program: Program, path: Path) -> Iterator[tuple[str, Iterator[str]]]:
    """One module, or a main module that calls numbered ones, with the .pgf that lists them."""
    words = _words(program)
    n, per = len(program), MOVES_PER_MODULE
    if n <= per:
        yield path.name, with_crlf(_main(program, words, lambda: _moves(program, words, slice(0, n))))
        return
    parts = range(1, -(-n // per) + 1)
    calls = "".join(f"    {words.module}_run_{i:03d};\n" for i in parts)
    yield path.name, with_crlf(_main(program, words, lambda: iter((calls,))))
    for i in parts:
        block = slice((i - 1) * per, min(i * per, n))
        yield f"{path.stem}_{i:03d}{path.suffix}", with_crlf(_part(program, words, i, block))
    yield f"{path.stem}.pgf", with_crlf(_list_of_modules(path, parts))


def _words(program: Program) -> _Words:
    module = legal_name(program.name, NAME_LIMIT, RESERVED)
    tools = {t: f"{module}_t{t}" for t in sorted({int(t) for t in np.unique(program.tool)})}
    speed, speeds, declared = _speeds(program)
    between = Between(
        comment=lambda text: f"    ! {plain(text)}\n",
        line=lambda line: f"    {line}\n",
        halt=lambda text: f"    ! {plain(text)}\n    Stop;\n",
        mount=lambda tool: "",
        go=lambda pose: _joint_move(program, program.joints[pose], pose, module=module),
    )
    return _Words(
        module=module, tools=tools, zone=_zones(program), speed=speed, speeds=speeds, declared=declared,
        before=lines_before(program, between), at_start=lines_at_start(program, between),
    )  # fmt: skip


def _joint_move(program: Program, q: Floats, pose: int, *, module: str) -> str:
    """To joint angles, with the tool of a pose, external axes where they stand there."""
    axes, tool = eax(program, slice(pose, pose + 1))[0], f"{module}_t{int(program.tool[pose])}"
    angles = ",".join(f"{a:.6f}" for a in printed(np.degrees(q), 6).tolist())
    return f"    MoveAbsJ [[{angles}],[{axes}]],vrapid,fine,{tool}\\WObj:={module}_wobj;\n"


def _zones(program: Program) -> npt.NDArray[np.intp]:
    bound = blending(program)
    zone = steps_within(bound.radius, tuple(r for _, r in _ZONES))
    turn = steps_within(np.degrees(bound.turn), tuple(a for _, a in _TURNS))
    return np.where(turn > 0, len(_ZONES) + turn, zone)


def _speeds(
    program: Program,
) -> tuple[npt.NDArray[np.intp], tuple[str, ...], tuple[tuple[str, float], ...]]:
    """Index per pose, text of each speed, what is declared. Speeds in mm/s."""
    cut = program.kind == CUT
    values, index = np.unique(np.round(np.where(cut, program.feed, 0.0) * 1e3, 5), return_inverse=True)
    rapid = program.rapid_speed * 1e3
    numbers = [float(v) for v in values]
    if len(values) <= DECLARED_SPEEDS:
        names = [f"vf{i}" for i in range(len(values))]
        declared = [(name, v) for name, v in zip(names, numbers, strict=True) if v > 0.0]
    else:
        names = [f"vf0\\V:={number(v, 5)}" for v in numbers]
        declared = [("vf0", max(numbers))]
    index = np.where(cut, index, len(names))
    return index, (*names, "vrapid"), (("vrapid", rapid), *declared)


def _main(program: Program, words: _Words, body: Callable[[], Iterator[str]]) -> Iterator[str]:
    """The main module; ``body`` gives the moves or the calls of the parts."""
    yield "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\n\n"
    yield f"MODULE {words.module}\n"
    yield f"  ! {plain(program.heading + ' for ' + (program.robot or 'robot'))}\n"
    yield f"  ! {plain('Source: ' + program.source_name)}\n"
    yield from (f"  ! {plain(text)}\n" for text in program.stamp)
    for t, name in words.tools.items():
        yield f"  ! tool {t}: {plain(program.tools[t].name)}\n"
        yield f"  TASK PERS tooldata {name}:={_tooldata(program.tools[t])};\n"
    yield from workobject_lines(program, f"{words.module}_wobj")
    yield _speeds_and_zones(words, slice(0, len(program)))
    yield "\n  PROC main()\n"
    yield "    ConfJ \\On;\n    ConfL \\Off;\n    SingArea \\Off;\n"
    yield from _to_start(program, words)
    yield from body()
    yield words.before.get(len(program), "")
    yield "    ConfL \\On;\n  ENDPROC\nENDMODULE\n"


def _to_start(program: Program, words: _Words) -> Iterator[str]:
    yield words.at_start
    starts = () if program.start_joints is None else (program.start_joints,)
    for q in (*starts, program.joints[0]):
        yield _joint_move(program, q, 0, module=words.module)


def _part(program: Program, words: _Words, i: int, block: slice) -> Iterator[str]:
    yield "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\n\n"
    yield f"MODULE {words.module}_{i:03d}\n"
    yield _speeds_and_zones(words, block)
    yield f"\n  PROC {words.module}_run_{i:03d}()\n"
    yield from _moves(program, words, block)
    yield "  ENDPROC\nENDMODULE\n"


def _list_of_modules(path: Path, parts: range) -> Iterator[str]:
    names = [path.name, *(f"{path.stem}_{i:03d}{path.suffix}" for i in parts)]
    yield '<?xml version="1.0" encoding="ISO-8859-1" ?>\n<Program>\n'
    yield "".join(f"    <Module>{name}</Module>\n" for name in names)
    yield "</Program>\n"


def _speeds_and_zones(words: _Words, block: slice) -> str:
    """Declarations local to a module, so that two programs in one task do not collide."""
    lines = [
        f"  LOCAL CONST speeddata {name}:=[{number(v, 5)},500,5000,1000];\n" for name, v in words.declared
    ]
    used = {_ZONE_NAMES[i] for i in np.unique(words.zone[block])}
    for name, radius in _ZONES:
        if name in used and name.startswith("zc"):
            r = number(radius * 1e3, 3)
            lines.append(f"  LOCAL CONST zonedata {name}:=[FALSE,{r},{r},{r},0.01,{r},0.01];\n")
    for name, angle in _TURNS:
        if name in used:
            lines.append(f"  LOCAL CONST zonedata {name}:=[FALSE,0.005,0.005,0.005,{angle},0.005,{angle}];\n")
    return "".join(lines)


def _moves(program: Program, words: _Words, block: slice) -> Iterator[str]:
    for b in program.blocks(4096, block.start, block.stop):
        yield _MOVE * (b.stop - b.start) % tuple(chain.from_iterable(_rows(program, words, b)))


def _rows(program: Program, words: _Words, block: slice) -> Iterator[tuple[object, ...]]:
    n = block.stop - block.start
    before = [""] * n
    for pose in words.before.keys() & range(block.start, block.stop):
        before[pose - block.start] = words.before[pose]
    position = printed(program.position[block] * 1e3, 4)
    quaternion = printed(quaternion_from_matrix(program.rotation[block]), 8)
    branch = None if program.configuration is None else program.configuration[block]
    conf = confdata(program.joints[block], branch)
    axes = eax(program, block) if program.external else [_NO_AXES] * n
    return zip(
        before, *position.T.tolist(), *quaternion.T.tolist(), *conf.T.tolist(), axes, _tails(program, words, block),
        strict=True,
    )  # fmt: skip


def _tails(program: Program, words: _Words, block: slice) -> list[str]:
    """Speed, zone, tool and work object of each move; few differ, so each is made once a block."""
    keys = list(zip(
        words.speed[block].tolist(), words.zone[block].tolist(), program.tool[block].tolist(), strict=True,
    ))  # fmt: skip
    made = {
        k: f"{words.speeds[k[0]]},{_ZONE_NAMES[k[1]]},{words.tools[k[2]]}\\WObj:={words.module}_wobj"
        for k in set(keys)
    }
    return [made[k] for k in keys]


def confdata(joints: Floats, configuration: npt.NDArray[np.int32] | None) -> npt.NDArray[np.int64]:
    """(N, 4) cf1, cf4, cf6, cfx: the quarter turns that joints 1, 4 and 6 are in, and the branch 0 ... 7.

    Quarter 0 is from 0 to 90 deg, -1 from -90 to 0 deg, of the angle as MoveAbsJ would print it.
    Source: 3HAC050917, data type confdata. cfx adds 4 for a wrist centre behind axis 1, 2 for behind the
    lower arm, 1 for a negative axis 5.
    """
    degrees = printed(np.degrees(joints[:, [0, 3, 5]]), 6)
    quarters = np.floor(degrees / 90.0).astype(np.int64)
    cfx = np.zeros(len(joints), dtype=np.int64) if configuration is None else configuration.astype(np.int64)
    return np.column_stack((quarters, cfx))


def _tooldata(tool: ToolFrame) -> str:
    return f"[TRUE,{pose_text(tool.frame)},{_load(tool)}]"


def _load(tool: ToolFrame) -> str:
    """loaddata; ABB's own of tool0 (0.001 kg) where the mass is not known, half way to the TCP the centre."""
    if tool.mass is None or tool.mass < 1e-3:
        return "[0.001,[0,0,0.001],[1,0,0,0],0,0,0]"
    com = 0.5 * tool.frame.origin if tool.com is None else tool.com
    return f"[{number(tool.mass, 3)},{numbers_text(com * 1e3, 4)},[1,0,0,0],0,0,0]"
