"""Frames of SINUMERIK programs: G54 to G599, TRANS, ROT and their additive forms, and the planes of CYCLE800.

Order as in the control: settable frame, frame of the tilted plane, programmable frame. Sources: NC programming
(Fundamentals, Coordinate transformations): rotations of ROT in the order Z, Y', X'' (RPY, MD10600 = 1); TRANS, ROT
replace all programmable frames before them; Job planning, CYCLE800.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from toolpaths.frame import Vector
from toolpaths.interpreting.values import Runtime
from toolpaths.languages.siemens.block import Arguments
from toolpaths.reading.plain_frame import PlainFrame

FRAME_WORDS = frozenset(("TRANS", "ATRANS", "ROT", "AROT"))
_COUNT = 16  # of the arguments of CYCLE800
_AXES = {1: 0, 2: 1, 3: 2}  # of two bits of _MODE
FrameState = tuple[str | None, PlainFrame, PlainFrame, PlainFrame]


class Swivel(NamedTuple):
    """CYCLE800 as it is called.

    Attributes:
        frame: of the plane, in the frame that it stands on.
        adds: it stands on the plane before; else on the settable frame.
        turns: the control turns the rotary axes; else only the coordinates are tilted.
        follows: the tip stays where it is on the work.
        level: it is the untilted plane.
    """

    frame: PlainFrame
    adds: bool
    turns: bool
    follows: bool
    level: bool


class SiemensFrames:
    """The frames in force; ``offsets``: where G54 ... lie in the work object, m."""

    def __init__(self, offsets: Mapping[str, Vector]) -> None:
        self.offsets = offsets
        self._system: str | None = None
        self._base = self._plane = self._program = PlainFrame()

    def total(self) -> PlainFrame:
        """The frame that coordinates count in, in the work object."""
        return self._base.then(self._plane).then(self._program)

    def state(self) -> FrameState:
        """For ``put_back``."""
        return self._system, self._base, self._plane, self._program

    def put_back(self, state: FrameState) -> None:
        """The frames as they were; a tilted plane stays."""
        self._system, self._base, _, self._program = state

    def choose(self, system: str, used: bool) -> None:
        """G54 and its like; ``used``: coordinates were read already.

        Raises:
            ValueError: a second one, and how the two lie to each other is not known.
        """
        before = self._system or ("G54" if used else system)
        self._system = system
        if self.offsets:
            if system not in self.offsets:
                raise ValueError(f"{system}: the machine's offsets name only {', '.join(self.offsets)}")
            self._base = PlainFrame(self.offsets[system])
        elif before != system:
            problem = f"{system} after {before}: how the two lie to each other is not in the file"
            raise ValueError(problem, "Post with one of them, or declare their offsets in [machine] of the cell.")

    def program(self, word: str, values: Mapping[str, float], normal: int) -> None:
        """TRANS, ATRANS (m), ROT, AROT (deg); ``normal``: of the plane in force.

        Raises:
            ValueError: RPL beside other words.
        """
        if word in ("TRANS", "ATRANS"):
            new = PlainFrame((values.get("X", 0.0), values.get("Y", 0.0), values.get("Z", 0.0)))
        elif "RPL" in values:
            if len(values) > 1:
                raise ValueError(f"{word} with RPL and axes")
            new = PlainFrame.turned([(normal, math.radians(values["RPL"]))])
        else:
            new = PlainFrame.turned([(k, math.radians(values.get("XYZ"[k], 0.0))) for k in (2, 1, 0)])
        self._program = self._program.then(new) if word.startswith("A") else new

    def swivel(self, to: Swivel) -> None:
        """The plane of CYCLE800.

        Raises:
            ValueError: it adds to a plane while TRANS or ROT are on.
        """
        if to.adds and self._program != PlainFrame():
            raise ValueError("CYCLE800 adds to the plane before, and TRANS or ROT is on", "Write TRANS before it.")
        self._plane = self._plane.then(to.frame) if to.adds else to.frame
        self._program = PlainFrame()


class FrameShifts:
    """By how much, m, frames have changed the coordinates of axes since the program named them.

    An increment then leads to one of two places: with SD42440 FRAME_OFFSET_INCR_PROG set the change is traversed too.
    """

    def __init__(self) -> None:
        self._by: dict[str, float] = {}

    def changed(self, before: Vector, after: Vector) -> None:
        """Another frame: where the tool is, in the one and in the other."""
        for axis, a, b in zip("XYZ", before, after, strict=True):
            self._by[axis] = self._by.get(axis, 0.0) + (b - a if a == a and b == b else 0.0)

    def named(self, axis: str) -> None:
        """The program says where the axis goes."""
        self._by.pop(axis, None)

    def check(self, axis: str) -> None:
        """The axis goes by an increment.

        Raises:
            ValueError: where that leads depends on a setting of the machine.
        """
        if by := round(self._by.get(axis, 0.0) * 1e3, 6):
            problem = f"{axis} by an increment, and the frame has shifted it by {by:g} mm since {axis} was named"
            remedy = f"The machine's setting SD42440 decides whether that counts: name {axis} in G90 before."
            raise ValueError(problem, remedy)


def swivel(given: Arguments, unit: float) -> Swivel:
    """CYCLE800(_FR, _TC, _ST, _MODE, _X0, _Y0, _Z0, _A, _B, _C, _X1, _Y1, _Z1, _DIR, _FR_I, _DMODE); ``unit``: m.

    Raises:
        ValueError: a mode that only the machine's data explain.
    """
    if any(isinstance(v, Runtime | bool) for v in given) or len(given) > _COUNT + 2:
        raise ValueError("CYCLE800 with a value that is not in the file")
    name = given[1] if len(given) > 1 else None
    if not any(isinstance(v, float) for v in given) or (isinstance(name, str) and name == "0"):
        return Swivel(PlainFrame(), adds=False, turns=True, follows=False, level=True)
    values = [v if isinstance(v, float) else 0.0 for v in [*given, *[None] * _COUNT][:_COUNT]]
    status, mode, direction = int(values[2]), int(values[3]), values[13]
    if status // 100 % 10:
        raise ValueError("CYCLE800 aligns a tool (_ST above 99)", "Post with TRAORI.")
    angles = _rotations(mode, [math.radians(v) for v in values[7:10]])
    before, after = (PlainFrame((v[0] * unit, v[1] * unit, v[2] * unit)) for v in (values[4:7], values[10:13]))
    frame = before.then(PlainFrame.turned(angles)).then(after)
    return Swivel(
        frame,
        adds=status % 10 == 1,
        turns=direction != 0,
        follows=status // 10 % 10 == 1 and direction != 0,
        level=frame.rows is None and frame.origin == (0.0, 0.0, 0.0) and status % 10 == 0,
    )


def _rotations(mode: int, angles: list[float]) -> list[tuple[int, float]]:
    """Axes and angles, in their order; from bits 7 and 6 of the mode."""
    kind = mode >> 6 & 3
    if kind == 1:  # solid angles: about Z, then about the new Y
        return [(2, angles[0]), (1, angles[1])]
    if kind == 0:
        axes = [_AXES.get(mode >> shift & 3) for shift in (0, 2, 4)]
        named = [(axis, angle) for axis, angle in zip(axes, angles, strict=True) if axis is not None]
        if len(named) == 3 or all(angle == 0 for axis, angle in zip(axes, angles, strict=True) if axis is None):
            return named
        raise ValueError(f"CYCLE800 with mode {mode}: which axes it turns about is not in it")
    if any(angles):
        what = "projection angles" if kind == 2 else "positions of the rotary axes"
        raise ValueError(
            f"CYCLE800 by {what} (mode {mode})", "Post axis by axis (mode 27, 39, 57) or by solid angles (64)."
        )
    return []
