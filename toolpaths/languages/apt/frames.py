"""Coordinate systems of an APT/CL or CLSF file: poses are given in the first one.

MSYS (NX): what follows is in its coordinates. CSYS (SolidWorks CAM): under TRNTYP/WORLD the coordinates stay those
of the first one however the part is turned, so CSYS changes none; in ``Sacrifice-Board.apt`` of the tests a part
turned over is drilled from below, axis (0, 0, -1), at the places that its mesh has in the first setup.
"""

from __future__ import annotations

import numpy as np

from toolpaths.frame import Frame, Vector
from toolpaths.languages.apt.words import CREO, UNIT_TOLERANCE, AptStatement, number, numbers, refusal

TOLERANCE = 1e-3  # how far given axes may be from unit length and from right angles
_CATIA = "*CATIA0"
_REMEDY = "Output in one coordinate system."


class CamFrames:
    """The frame in force and the way from it to the first one."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.way: Frame | None = None  # pose of the frame in force in the first one, None where they are the same
        self.first: Frame | None = None
        self.msys: Frame | None = None
        self.system: list[float] | None = None  # CSYS
        self.world = False  # TRNTYP/WORLD was given
        self.named: dict[str, list[float]] = {}  # the first systems that comments of Creo and CATIA name
        self.rows: list[float] | None = None  # numbers of *CATIA0 so far

    def read(self, s: AptStatement, *, poses: bool) -> bool:
        """MSYS, CSYS or TRNTYP; whether the frame, or the part in it, is another one from here on."""
        if s.word == "MSYS":
            return self._msys(s, poses)
        if s.word == "CSYS":
            return self._csys(s, poses)
        if s.minor[:1] != ["WORLD"] or any(number(m) != 0 for m in s.minor[1:]):
            raise refusal(self.source, s, "only TRNTYP/WORLD,0,0,0 is read")
        self.world = True
        return False

    def _msys(self, s: AptStatement, poses: bool) -> bool:
        try:
            here = _frame_from_msys(numbers(s, (9,), self.source))
        except ValueError as problem:
            raise refusal(self.source, s, str(problem)) from None
        if self.first is None or self.msys is None:
            if poses:
                raise refusal(self.source, s, "the first MSYS comes after poses: their frame is not known")
            self.first = self.msys = here
            return False
        changed = not _same(here, self.msys)
        self.msys = here
        self.way = None if _same(here, self.first) else self.first.inverse().then(here)
        return changed

    def _csys(self, s: AptStatement, poses: bool) -> bool:
        values = numbers(s, (12,), self.source)
        rows = np.array(values).reshape(3, 4)[:, :3]
        if not np.allclose(rows @ rows.T, np.eye(3), rtol=0, atol=UNIT_TOLERANCE):
            raise refusal(self.source, s, "three rows of a rotation and a shift are expected, this is none")
        if self.system is None and poses:
            raise refusal(self.source, s, "the first CSYS comes after poses: their frame is not known")
        changed = self.system not in (None, values)
        if changed and not self.world:
            raise refusal(self.source, s, "a second coordinate system without TRNTYP/WORLD", _REMEDY)
        self.system = values
        return changed

    def up(self, axis: Vector) -> bool:
        """Whether a tool axis is the z axis of the last CSYS, be it given as a row or as a column."""
        rows = np.eye(3) if self.system is None else np.array(self.system).reshape(3, 4)[:, :3]
        return any(np.allclose(axis, z, rtol=0, atol=UNIT_TOLERANCE) for z in (rows[2], rows[:, 2]))

    def comment(self, s: AptStatement) -> None:
        """``$$-> CSYS / 12 numbers`` of Creo and ``$$*CATIA0`` of CATIA: one system a file."""
        word, _, rest = s.text.removeprefix(CREO).partition("/")
        if s.text.startswith(CREO) and word.strip().upper() == "CSYS":
            self._only(s, "CSYS", numbers(AptStatement("CSYS", rest, s.line), (12,), self.source))
        elif s.text.upper().startswith(_CATIA):
            self.rows = []
        elif self.rows is not None:
            found = [number(part.upper()) for part in s.text.split()]
            if len(found) == 4 and None not in found:
                self.rows += [v for v in found if v is not None]
            if len(self.rows) == 12:
                self._only(s, _CATIA, self.rows)
                self.rows = None

    def _only(self, s: AptStatement, name: str, values: list[float]) -> None:
        if self.named.setdefault(name, values) != values:
            raise refusal(self.source, s, "a second coordinate system in a comment of the CAM system", _REMEDY)


def point(frame: Frame | None, p: Vector) -> Vector:
    """A place of the frame in force, in the first one; in file units, as frames here are."""
    if frame is None:
        return p
    x, y, z = frame.at(np.array(p)).tolist()
    return x, y, z


def vector(frame: Frame | None, v: Vector) -> Vector:
    """A direction of the frame in force, in the first one."""
    if frame is None:
        return v
    x, y, z = frame.along(np.array(v)).tolist()
    return x, y, z


def _same(a: Frame, b: Frame) -> bool:
    """Whether both are the same to the digits that files carry."""
    near = np.allclose(a.origin, b.origin, rtol=0, atol=1e-9)
    return near and np.allclose(a.rotation, b.rotation, rtol=0, atol=1e-12)


def _frame_from_msys(values: list[float]) -> Frame:
    """The frame of origin, x axis and y axis, 9 numbers.

    Raises:
        ValueError: the axes are not of unit length or not at right angles.
    """
    origin, x, y = np.array(values).reshape(3, 3)
    lengths = np.linalg.norm([x, y], axis=1)
    if not np.all(np.abs(lengths - 1.0) <= TOLERANCE) or not abs(np.dot(x, y)) <= TOLERANCE:
        raise ValueError(f"axes of length {lengths[0]:.6g} and {lengths[1]:.6g}, or not at right angles")
    x = x / lengths[0]
    z = np.cross(x, y)
    z /= np.linalg.norm(z)
    return Frame(np.column_stack([x, np.cross(z, x), z]), origin)
