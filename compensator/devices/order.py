"""What has to be known for a trace beside the device's file, and how it is asked for: everything missing at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from compensator.devices.numbers import MM_IN
from compensator.devices.readings import BALLBAR, POSITIONS, SURFACE, DeviceReadings
from compensator.errors import DeviceError

UNITS = ("mm", "inch", "um", "m")
BASE, WORKOBJECT, FREE = FRAMES = ("base", "workobject", "free")
HOME = {POSITIONS: BASE, SURFACE: WORKOBJECT}  # where a registered trace stands


@dataclass(frozen=True, kw_only=True)
class TraceOrder:
    """What the command line says of a measurement; None: nothing.

    Attributes:
        units: of the lengths in the file, one of UNITS. frame: of its points, one of FRAMES.
        noise: mm, one sigma of a reading. index: rows of the program. dry: the program ran in air.
        group, point: which readings. center: mm, base. radius: mm, nominal length of the ball-bar. calibrated: its
            length is known.
    """

    units: str | None = None
    frame: str | None = None
    noise: float | None = None
    index: str | None = None
    dry: bool = False
    group: str | None = None
    point: str | None = None
    center: tuple[float, float, float] | None = None
    radius: float | None = None
    calibrated: bool = False


def refuse_incomplete(given: DeviceReadings, order: TraceOrder) -> float:
    """Refuse what neither file nor command line gives, all of it in one message.

    Returns:
        mm in the unit of the file's lengths.

    Raises:
        DeviceError: something is missing, or the command line contradicts the file.
    """
    missing = list(_missing(given, order))
    if missing:
        listed = "".join(f"\n  {m}" for m in missing)
        raise DeviceError(f"{given.source}: does not tell what a trace has to have; give{listed}")
    _refuse_contradictions(given, order)
    return MM_IN[order.units] if order.units else float(given.to_mm or 1.0)


def _missing(given: DeviceReadings, order: TraceOrder) -> Iterator[str]:
    if given.to_mm is None and order.units is None:
        yield f"--units {' | '.join(UNITS)}: of the lengths in the file"
    if given.kind != BALLBAR and order.frame is None:
        home = HOME[given.kind]
        where = "the base of the robot" if home == BASE else "the work object of the cell, as the program's poses"
        named = f" (the file calls its frame {given.frame!r})" if given.frame else ""
        yield f"--frame {home} where its points stand in {where}, --frame free where in any other frame{named}"
    if order.noise is None and not np.isfinite(given.sd).all():
        yield "--noise MM: standard deviation of a reading, such as 0.01 of a tracker, 0.002 of a measuring machine"
    if given.kind == BALLBAR:
        if order.center is None:
            yield "--center X Y Z: of the ball-bar, mm in the base, roughly"
        if order.radius is None:
            yield "--radius MM: nominal length of the ball-bar"
    timed = given.kind == POSITIONS and np.isfinite(given.time).all()
    if given.kind != SURFACE and not timed and order.index is None and not np.isfinite(given.index).all():
        yield "--index ROWS: rows of the program csv that the readings belong to, from 0, such as 4,8,12 or 0:100:2"


def _refuse_contradictions(given: DeviceReadings, order: TraceOrder) -> None:
    def refuse(why: str) -> None:
        raise DeviceError(f"{given.source}: {why}")

    if order.units and given.to_mm is not None and not np.isclose(MM_IN[order.units], given.to_mm):
        refuse(f"--units {order.units}: but the file has a unit of {given.to_mm:g} mm; leave --units out")
    if order.frame is not None and given.kind == BALLBAR:
        refuse("--frame: a ball-bar has no frame; leave it out")
    if order.frame not in (None, FREE, HOME.get(given.kind)):
        refuse(f"--frame {order.frame}: {given.kind} stand in {HOME[given.kind]}, or in a frame of their own: free")
    if given.needs_free_frame and order.frame != FREE:
        refuse(f"{given.needs_free_frame}; give --frame free, or inspect in the work plane of the setup")
    if order.noise is not None and not 0 < order.noise < 10:
        refuse(f"--noise {order.noise:g}: expected mm above 0, below 10")
    if order.radius is not None and not 5 <= order.radius <= 5000:
        refuse(f"--radius {order.radius:g}: expected mm, 5 ... 5000")
    if given.kind != BALLBAR and (order.center or order.radius or order.calibrated):
        refuse("--center, --radius and --calibrated belong to a ball-bar, whose table has a column radius")
    if given.kind == SURFACE and order.dry:
        refuse("--dry: a surface was cut; leave it out")
    if order.index is not None and np.isfinite(given.index).any():
        refuse("--index: the file has a column index; leave one of the two out")
