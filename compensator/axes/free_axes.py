"""Free axes: rails and tables of a cell whose places are chosen for a path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import on_ways, reach_on_table, stray_turn
from compensator.cell.placement import Placement
from compensator.cell.placement_tables import ExternalAxisTable
from toolpaths.errors import ToolpathError
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.resample import MOST_POSES, in_parts
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

SPEED, ACCELERATION = 100.0, 100.0  # mm/s and mm/s2 of a rail, where the cell gives none: tons, and below what rails do
LIMITS = {"speed": "/s", "acceleration": "/s2"}
SLOW, SLOW_TURN = 5.0, 0.5  # mm and deg, per s and s2: slower than any rail or table
NEAREST = 0.05  # m from the axis of a table: what turns there has a size all the same
DIGITS = 4  # of places, mm and deg: as programs have them


@dataclass(frozen=True, repr=False, eq=False)
class FreeAxes:
    """The A free axes of a cell, in its order; places are mm of a rail, deg of a table.

    Attributes:
        names: of them. rail: (A,) which are rails; the others are tables.
        low, high: (A,) range.
        moving: (A,) which may move along a path: rails, and tables with speed and acceleration.
        speed, acceleration: (A,) per s and s2; of tables that are set once without meaning.
        ways: (A, 3) of rails, the way of the base for each mm, m, base axes; 0 of tables.
        size: (A,) m that the base, or the part where the path is farthest from the axis of its table, goes for each mm
            or deg.
    """

    placement: Placement
    names: tuple[str, ...]
    rail: Bools
    low: Floats
    high: Floats
    speed: Floats
    acceleration: Floats
    ways: Floats
    moving: Bools
    size: Floats

    def __repr__(self) -> str:
        return f"FreeAxes({', '.join(self.names)})"

    def __len__(self) -> int:
        return len(self.names)

    @classmethod
    def of(cls, placement: Placement, toolpath: Toolpath) -> FreeAxes | None:
        """Those of a placement, for a path with all axes at 0; None: it has none."""
        free = {name: axis for name, axis in placement.external.items() if axis.free}
        if not free:
            return None
        tables = list(free.values())
        rail = np.array([axis.carries == "robot" for axis in tables])
        unit = 10.0**DIGITS  # what is written is rounded, and stays within
        ranges = np.array([axis.range or (0.0, 0.0) for axis in tables]) * unit
        low, high = np.ceil(ranges[:, 0]) / unit, np.floor(ranges[:, 1]) / unit
        direction = np.array([axis.direction for axis in tables])
        return cls(
            placement=placement, names=tuple(free), rail=rail, low=low, high=high,
            speed=np.array([axis.speed or SPEED for axis in tables]),
            acceleration=np.array([axis.acceleration or ACCELERATION for axis in tables]),
            ways=np.where(rail[:, None], direction * 1e-3, 0.0),
            moving=rail | np.array([axis.turns for axis in tables]),
            size=np.array([1e-3 if r else _arc(placement, a, toolpath) for a, r in zip(tables, rail, strict=True)]),
        )  # fmt: skip

    def doubts(self) -> list[str]:
        """Limits that were most likely meant in m or rad."""
        out = []
        for name, rail in zip(self.names, self.rail, strict=True):
            slow, unit, meant = (SLOW, "mm", "m") if rail else (SLOW_TURN, "deg", "rad")
            for key, per in LIMITS.items():
                value = getattr(self.placement.external[name], key)
                if value is not None and value < slow:
                    out.append(f"{key} of external.{name} is {value:g} {unit}{per}: is this in {meant}{per}?")
        return out

    def assumptions(self) -> Iterator[Finding]:
        """Limits that the cell does not give, and those that look like others."""
        for what in self.doubts():
            expected = "mm/s and mm/s2 are expected" if "mm/" in what else "deg/s and deg/s2 are expected"
            yield Finding(WARNING, self.placement.source, what, expected)
        for k in np.flatnonzero(self.rail):
            name, axis = self.names[k], self.placement.external[self.names[k]]
            missing = [key for key in ("speed", "acceleration") if getattr(axis, key) is None]
            if missing:
                what = (
                    f"{' and '.join(missing)} of external.{name} are not given: {self.speed[k]:g} mm/s and "
                    f"{self.acceleration[k]:g} mm/s2 are assumed"
                )
                yield Finding(NOTE, self.placement.source, what, "Give them, from the data sheet of the rail")

    def on(self, toolpath: Toolpath, places: Floats) -> Toolpath:
        """The path as the base sees it, with axes at places (A,), or (N, A) along it."""
        wide = np.broadcast_to(np.round(places, DIGITS), (len(toolpath), len(self)))
        return on_ways(self.placement, toolpath, {name: wide[:, k].copy() for k, name in enumerate(self.names)})

    def told(self, places: Floats) -> str:
        """``E1 = 1200.0 mm, E2 = 35.0 deg``."""
        units = np.where(self.rail, "mm", "deg")
        parts = zip(self.names, places.tolist(), units.tolist(), strict=True)
        return ", ".join(f"{name} = {place:.1f} {unit}" for name, place, unit in parts)

    def by_name(self, places: Floats) -> Mapping[str, float]:
        """Places (A,) by the names of the axes."""
        return dict(zip(self.names, np.round(places, DIGITS).tolist(), strict=True))

    def time(self, toolpath: Toolpath) -> Floats:
        """(N,) s at which the tool is at each pose: at the programmed feeds, and in the air no faster than axes go."""
        program, step = self.placement.program, np.linalg.norm(np.diff(toolpath.on_part, axis=0), axis=1)
        slowest = min(program.rapid_feed / 60e3, float((self.speed * self.size)[self.moving].min(initial=np.inf)))
        feed = np.where(toolpath.feed > 0, toolpath.feed, program.default_feed / 60e3)
        speed = np.where(toolpath.kind == CUT, feed, slowest)[1:]
        return np.append(0.0, np.cumsum(step / speed))

    def sampled(self, toolpath: Toolpath) -> Toolpath:
        """The path, axes at 0, with so many poses that between two of them a table turns by no more than [sampling]
        allows, even at its speed: from pose to pose the arm goes as if it stood.

        Raises:
            ToolpathError: too many.
        """
        parts, lasts = np.ones(len(toolpath) - 1), np.diff(self.time(toolpath))
        for k in np.flatnonzero(self.moving & ~self.rail):
            reach = reach_on_table(self.placement, self.placement.external[self.names[k]], toolpath)
            parts = np.maximum(parts, np.radians(self.speed[k]) * lasts / stray_turn(self.placement, reach))
        if parts.sum() > MOST_POSES:
            what = f"a table that turns takes {parts.sum():,.0f} poses, at most {MOST_POSES:,} are computed"
            raise ToolpathError(f"{toolpath.source}: {what}: take a larger sampling.chord, or a slower table")
        count = np.ceil(parts - 1e-6).astype(np.intp)
        return in_parts(toolpath, count) if count.max(initial=1) > 1 else toolpath


def _arc(placement: Placement, axis: ExternalAxisTable, toolpath: Toolpath) -> float:
    """m for each deg that a table turns, of what is farthest from its axis on the path."""
    arm = placement.workobject.at(toolpath.position) - np.array(axis.center) * 1e-3
    return float(np.radians(max(np.linalg.norm(np.cross(arm, axis.direction), axis=1).max(), NEAREST)))
