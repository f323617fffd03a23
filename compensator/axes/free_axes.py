"""Free axes: rails and tables of a cell whose places are chosen for a path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import on_ways
from compensator.cell.placement import Placement
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

SPEED, ACCELERATION = 100.0, 100.0  # mm/s and mm/s2 of a rail, where the cell gives none: tons, and below what rails do
LIMITS = {"speed": "m/s", "acceleration": "m/s2"}
SLOW = 5.0  # mm/s and mm/s2: slower than any rail
DIGITS = 4  # of places, mm and deg: as programs have them


@dataclass(frozen=True, repr=False, eq=False)
class FreeAxes:
    """The A free axes of a cell, in its order; places are mm of a rail, deg of a table.

    Attributes:
        names: of them. rail: (A,) which are rails; the others are tables.
        low, high: (A,) range.
        speed, acceleration: (A,) per s and s2; of tables without meaning.
        ways: (A, 3) of rails, the way of the base for each mm, m, base axes; 0 of tables.
    """

    placement: Placement
    names: tuple[str, ...]
    rail: Bools
    low: Floats
    high: Floats
    speed: Floats
    acceleration: Floats
    ways: Floats

    def __repr__(self) -> str:
        return f"FreeAxes({', '.join(self.names)})"

    def __len__(self) -> int:
        return len(self.names)

    @classmethod
    def of(cls, placement: Placement) -> FreeAxes | None:
        """Those of a placement; None: it has none."""
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
        )  # fmt: skip

    def doubts(self) -> list[str]:
        """Limits of rails that were most likely meant in m."""
        given = [(n, key, getattr(self.placement.external[n], key)) for n in self.names for key in LIMITS]
        return [
            f"{key} of external.{name} is {value:g} m{LIMITS[key]}: is this in {LIMITS[key]}?"
            for name, key, value in given if value is not None and value < SLOW
        ]  # fmt: skip

    def assumptions(self) -> Iterator[Finding]:
        """Limits that the cell does not give, and those that look like others."""
        for what in self.doubts():
            yield Finding(WARNING, self.placement.source, what, "mm/s and mm/s2 are expected")
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
        """(N,) s at which the tool is at each pose: at the programmed feeds, and in the air no faster than rails go."""
        program, step = self.placement.program, np.linalg.norm(np.diff(toolpath.on_part, axis=0), axis=1)
        slowest = min(program.rapid_feed / 60e3, float(self.speed[self.rail].min(initial=np.inf)) * 1e-3)
        feed = np.where(toolpath.feed > 0, toolpath.feed, program.default_feed / 60e3)
        speed = np.where(toolpath.kind == CUT, feed, slowest)[1:]
        return np.append(0.0, np.cumsum(step / speed))
