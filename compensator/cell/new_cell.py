"""The text of a new cell, made of the answers; what was assumed stands in its comments."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

from compensator.cell.new_cut import numbered
from compensator.cell.new_cut import quoted as _quoted
from compensator.errors import CellError

Numbers = tuple[float, ...]
GRAVITY = 9.80665  # m/s2

#: On the robot, path axes, N: a light finishing cut in aluminium, as in examples/cell.toml. The cell says so.
ASSUMED_FORCE = (-120.0, 80.0, -60.0)
#: Of the weight that an arm moves: a larger force is none that a light arm is used for.
MOST = 0.1


def assumed_wrench(mass: float | None) -> Numbers:
    """Six numbers, N and N*m, path axes, for an arm with this moving mass, kg; None: not known."""
    size = sum(f**2 for f in ASSUMED_FORCE) ** 0.5
    share = 1.0 if mass is None else min(1.0, MOST * mass * GRAVITY / size)
    return (*(round(share * f, 0 if share == 1.0 else 1) for f in ASSUMED_FORCE), 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class CellAnswers:
    """What a cell is made of.

    Attributes:
        robot: as the cell names it. base, tip: of the robot, where they have to be named; else None.
        tools: number in the file, or None: the only one -> flange to TCP, mm; mass, kg, where it is known.
        part: base to the zero of the CAM file, mm; roll, pitch, yaw, deg, where it is turned: 3 or 6 numbers.
        cam: the file, as seen from the cell.
        model: as the cell names it. known: whether somebody measured it.
        process: lines of its table.
        controller: language of the program. suffix: of its files.
    """

    robot: str
    base: str | None
    tip: str | None
    tools: Mapping[int | None, Numbers]
    part: Numbers
    cam: str
    model: str
    known: bool
    process: tuple[str, ...]
    controller: str
    suffix: str


def numbers_of(words: str, counts: tuple[int, ...], what: str) -> Numbers:
    """Numbers of an answer, separated by spaces or commas.

    Raises:
        CellError: names what was asked, what was answered and what was expected.
    """
    try:
        found = tuple(float(word) for word in words.replace(",", " ").split())
    except ValueError:
        found = ()
    if len(found) not in counts or not all(abs(v) < 1e9 for v in found):
        raise CellError(f"{what} = {words!r}: expected {' or '.join(map(str, counts))} numbers, such as 0 0 250")
    return found


def tools_of(words: str, used: Sequence[int]) -> dict[int | None, Numbers]:
    """``0 0 250 35``, or ``1=0 0 250 35; 2=0 0 230 35``; one is taken for each of several tools that the file uses.

    Raises:
        CellError: names what was answered and what was expected.
    """
    out: dict[int | None, Numbers] = {}
    for number, numbers in numbered(words, "tool"):
        out[number] = numbers_of(numbers, (3, 4), "tool")
    if None in out and len(used) > 1:
        return dict.fromkeys(used, out[None])
    if None not in out and (missing := [n for n in used if n not in out]):
        raise CellError(f"tool = {words!r}: the CAM file cuts with tool {missing[0]} too, and none is given for it")
    return out


def cell_text(a: CellAnswers, name: str) -> str:
    """The cell file; ``name``: how it is called."""
    cam = Path(a.cam)
    program = f"{cam.stem}_c{a.suffix}" if cam.suffix.lower() == a.suffix else f"{cam.stem}{a.suffix}"
    assumed = "" if a.known else "  # NOT MEASURED: a wide band; `compensator plan` says what to measure"
    cell = _shell(name)
    lines = [
        f"# Written by `compensator init` for {_plain(a.cam)}: mm, deg, kg, N, N*m; every key: docs/compensate.md",
        "# Next, in this folder:",
        f"#   compensator check {cell} {_shell(a.cam)}",
        f"#   compensator compensate {_shell(a.cam)} --cell {cell} -o {_shell(program)} --format {a.controller}",
        f"#   compensator verify {_shell(program)} --cell {cell}",
        'schema = "cell/1"',
        f"robot = {_quoted(a.robot)}",
        *([f"base = {_quoted(a.base)}  # [workobject] is measured from the controller's own base"] if a.base else []),
        *([f"tip = {_quoted(a.tip)}  # tools are measured from the maker's own flange"] if a.tip else []),
        f"model = {_quoted(a.model)}{assumed}",
        'gravity = "calibrated-out"  # the controller is taken to know the sag of arm and tool; else "uncompensated"',
        "",
        "[controller]",
        "# absolute_accuracy = true  # NOT KNOWN: look up whether its absolute accuracy or elasticity option is on",
        "",
        *(line for number, tool in a.tools.items() for line in _tool_lines(number, tool)),
        "[workobject]",
        f"xyz = {_listed(a.part[:3])}  # base to the zero of the CAM file, mm",
        f"rpy = {_listed(a.part[3:] or (0.0, 0.0, 0.0))}  # roll, pitch, yaw, deg",
        "# touched_off = [[0.0, 0.0, 0.0]]  # points touched with this tool, mm; [] if measured otherwise",
        "",
        "# [start]  # where the arm stands before the first pose: picks configuration and flanks of the gears",
        "# joints = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
        "",
        *a.process,
        "",
    ]
    return "\n".join(lines)


def _tool_lines(number: int | None, tool: Numbers) -> list[str]:
    xyz, mass = tool[:3], tool[3] if len(tool) > 3 else None
    head = "[tool]" if number is None else f"[tools.{number}]  # T{number} of the CAM file"
    return [head, f"xyz = {_listed(xyz)}  # flange to the tip of the cutter, mm", *_mass_lines(xyz, mass), ""]


def _mass_lines(xyz: Numbers, mass: float | None) -> list[str]:
    half = _listed([v / 2 for v in xyz])
    if mass is None:
        return ["# mass = 30.0          # of spindle and cutter, kg, not known", f"# com = {half}  # where it acts"]
    return [f"mass = {mass:g}", f"com = {half}  # ASSUMED: half way to the TCP, flange frame"]


def _listed(values: Iterable[float]) -> str:
    return str([float(v) for v in values])


def _plain(text: str) -> str:
    """Without what would end a comment."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _shell(text: str) -> str:
    return quote(_plain(text))
