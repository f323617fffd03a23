"""Machines with rotary axes: where the tool stands in the work object for given X, Y, Z and A, B, C.

Directions are those in which the TOOL turns relative to the work (right-handed, for growing angles), whatever part of
the machine moves: a table that turns right-handed about +z for growing C has the direction (0, 0, -1).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from toolpaths.errors import ReadError
from toolpaths.reading.move_buffer import Vector, most_poses
from toolpaths.toolpath import CUT, Floats, Toolpath

KINEMATICS = ("table", "head", "table-table", "head-head", "head-table")
WIDEST = np.radians(2.0)  # a turn of the axes is followed in steps of at most this
MOST_STEPS = 100_000
UNIT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class RotaryAxis:
    """One rotary axis.

    Attributes:
        letter: A, B or C.
        direction: unit vector at zero angles, in the axes of the work object: the tool turns about it.
        centre: a point of the axis at zero angles, m in the work object; None: not known (then only G43.4 is read).
    """

    letter: str
    direction: Vector
    centre: Vector | None = None


@dataclass(frozen=True)
class Machine:
    """The machine that a file with rotary words was posted for.

    Attributes:
        kinematics: one of KINEMATICS, a word for each axis.
        axes: in that order; the first of two tables or heads carries the second.
        pivot: m from where the axes of the head meet to the tip of the tool; None: not known.
        systems: where G54, G55 ... lie in the work object, m; needed when a file uses several.

    Raises:
        ValueError: the values contradict each other; says which.
    """

    kinematics: str = ""
    axes: tuple[RotaryAxis, ...] = ()
    pivot: float | None = None
    systems: Mapping[str, Vector] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.kinematics and self.kinematics not in KINEMATICS:
            raise ValueError(f"kinematics {self.kinematics!r}: one of {', '.join(KINEMATICS)} is expected")
        if len(self.axes) != len(self.places):
            given = f"{len(self.axes)} are given"
            raise ValueError(f"kinematics {self.kinematics!r} needs {len(self.places)} axes, {given}")
        letters = [a.letter for a in self.axes]
        if len(set(letters)) != len(letters) or not set(letters) <= set("ABC"):
            raise ValueError(f"axes {', '.join(letters)}: different ones of A, B, C are expected")
        for a in self.axes:
            if not abs(np.linalg.norm(a.direction) - 1.0) <= UNIT_TOLERANCE:
                raise ValueError(f"direction {a.direction} of axis {a.letter}: a unit vector is expected")

    @property
    def places(self) -> tuple[str, ...]:
        """table or head, for each axis."""
        return tuple(self.kinematics.split("-")) if self.kinematics else ()

    @property
    def letters(self) -> str:
        """The letters of the axes."""
        return "".join(a.letter for a in self.axes)

    def missing(self) -> str:
        """What has to be known of the machine to read rotary moves without G43.4; empty: nothing."""
        tables = [a.letter for a, p in zip(self.axes, self.places, strict=True) if p == "table" and a.centre is None]
        lacking = [f"centre of axis {letter}" for letter in tables]
        return " and ".join(lacking + ["pivot"] * ("head" in self.places and self.pivot is None))

    def poses(self, xyz: Floats, angles: Floats, tip: npt.NDArray[np.bool_]) -> tuple[Floats, Floats]:
        """(N, 3) tip and (N, 3) tool axis in the work object.

        Args:
            xyz: (N, 3) m as programmed.
            angles: (N, k) rad.
            tip: (N,) G43.4 is on: xyz is the tip in the work object already.
        """
        up = np.array([0.0, 0.0, 1.0])
        axis, place = np.tile(up, (len(xyz), 1)), xyz.copy()
        for a, where, angle in reversed(list(zip(self.axes, self.places, angles.T, strict=True))):
            if where == "head":
                axis = _turn(axis, a.direction, angle)
        if self.pivot is not None:
            place += self.pivot * (up - axis)
        for a, where, angle in zip(self.axes, self.places, angles.T, strict=True):
            if where == "table":
                centre = np.array(a.centre or (0.0, 0.0, 0.0))
                place = _turn(place - centre, a.direction, angle) + centre
                axis = _turn(axis, a.direction, angle)
        return np.where(tip[:, None], xyz, place), axis


def _turn(vectors: Floats, about: Vector, angle: Floats) -> Floats:
    """(N, 3) vectors turned by (N,) angles about a unit vector (Rodrigues)."""
    k, c, s = np.array(about), np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.asarray(vectors * c + np.cross(k, vectors) * s + (vectors @ k)[:, None] * k * (1.0 - c))


@dataclass(frozen=True)
class Turns:
    """What a reader noted of the rotary axes, a row per move.

    Attributes:
        angles: (M, k) rad.
        tip: (M,) G43.4 was on.
        time: (M,) s that the move takes, NaN where its feed is that of the tip.
    """

    angles: Floats
    tip: npt.NDArray[np.bool_]
    time: Floats


def in_work(path: Toolpath, machine: Machine, turns: Turns, chord: float) -> Toolpath:
    """The poses of a machine with rotary axes: ``path`` holds X, Y, Z as programmed.

    Moves that turn get poses in between, so that the tip stays within ``chord`` (m) of its way.

    Raises:
        ReadError: more poses than a file of this size may become.
    """
    move = np.ceil(path.row).astype(np.intp)
    angles, tip = turns.angles[move], turns.tip[move]
    count = _steps(path.position, angles, tip, machine, chord)
    if (total := int(count.sum())) > (most := len(path) + most_poses(len(turns.angles))):
        problem = f"its turns make {total} poses; at most {most}"
        raise ReadError(path.source, int(path.line[np.argmax(count)]), problem, "Check the angles.")
    to = np.repeat(np.arange(len(path)), count)
    first = np.cumsum(count) - count
    share = (np.arange(len(to)) - first[to] + 1) / count[to]
    rest, before = (1.0 - share)[:, None], np.maximum(to - 1, 0)
    xyz = share[:, None] * path.position[to] + rest * path.position[before]
    xyz[first + count - 1] = path.position  # ends to the last digit
    position, axis = machine.poses(xyz, share[:, None] * angles[to] + rest * angles[before], tip[to])
    row = share * path.row[to] + (1.0 - share) * path.row[before]
    row[first + count - 1] = path.row
    return replace(
        path,
        position=position, axis=axis, row=row,
        feed=_feeds(position, to, path.feed, turns.time[move], path.kind),
        kind=path.kind[to], tool=path.tool[to], line=path.line[to],
        events=tuple(replace(e, pose=int(first[e.pose]) if e.pose < len(path) else len(to)) for e in path.events),
    )  # fmt: skip


def _steps(
    xyz: Floats, angles: Floats, tip: npt.NDArray[np.bool_], machine: Machine, chord: float
) -> npt.NDArray[np.intp]:
    """(N,) into how many parts the move to each pose is cut."""
    turn = np.abs(np.diff(angles, axis=0, prepend=angles[:1])).sum(axis=1)
    way = np.linalg.norm(np.diff(xyz, axis=0, prepend=xyz[:1]), axis=1)
    centres = [a.centre for a in machine.axes if a.centre is not None] or [(0.0, 0.0, 0.0)]
    radius = np.max([np.linalg.norm(xyz - np.array(c), axis=1) for c in centres], axis=0)
    radius = np.maximum(radius, np.roll(radius, 1)) + (machine.pivot or 0.0)
    # the chord of a curve p(s), 0 <= s <= 1, cut into n parts misses it by at most |p''| / (8 n^2)
    bend = np.where(tip, 0.0, turn**2 * radius + 2.0 * turn * way)
    count = np.maximum(np.ceil(turn / WIDEST), np.ceil(np.sqrt(bend / (8.0 * chord))))
    switched = np.diff(tip, prepend=tip[:1])
    return np.asarray(np.clip(np.where(switched, 1, count), 1, MOST_STEPS), dtype=np.intp)


def _feeds(
    position: Floats, to: npt.NDArray[np.intp], feed: Floats, time: Floats, kind: npt.NDArray[np.uint8]
) -> Floats:
    """(P,) m/s of the tip; where it stands still while the axes turn, the feed of the cut before."""
    way = np.bincount(to, np.linalg.norm(np.diff(position, axis=0, prepend=position[:1]), axis=1), len(feed))
    out = np.where(np.isnan(time), feed, way / np.where(np.isnan(time), 1.0, time))
    still = np.flatnonzero((kind == CUT) & ~(out > 1e-9))
    moving = np.flatnonzero((kind == CUT) & (out > 1e-9))
    if len(still):
        last = np.searchsorted(moving, still) - 1
        out[still] = np.where(last >= 0, out[moving[np.maximum(last, 0)]], 1e-3) if len(moving) else 1e-3
    return np.asarray(out[to], dtype=np.float64)
