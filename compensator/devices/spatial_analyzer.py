"""SpatialAnalyzer: points exported as text: collection, group, point, x, y, z, date and time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, timedelta
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.devices.numbers import MM_IN, is_number, number
from compensator.devices.readings import POSITIONS, DeviceFile, DeviceReadings, readings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

NAME = "spatial-analyzer"
_STAMP = re.compile(r"(\d\d)/(\d\d)/(\d\d(?:\d\d)?) (\d\d):(\d\d):(\d\d)(\.\d+)?$")
_FRAME = re.compile(r"//\s*Points Relative to Coordinate Frame\s+'(.*)'", re.IGNORECASE)
_AXES = re.compile(r"//\s*AXES\s*=\s*(\w+)\s*:.*?(?:\(([^)]*)\))?\s*$", re.IGNORECASE)
_BARE = re.compile(r"[^,]+(?:,  [^,]+)?(?:,  -?\d+\.\d{4,}){3}\s*$")  # without its header: two spaces, many decimals
#: s: what a date is counted in where it has no fraction.
SECOND = 1.0


class _Row(NamedTuple):
    line: int
    group: str
    name: str
    xyz: tuple[float, float, float]
    stamp: str


def recognised(file: DeviceFile) -> bool:
    """By its header, or by the way in which it writes numbers where the header was left out."""
    first = next((line for line in file.lines if line.strip()), "")
    return first.startswith("// SpatialAnalyzer") or bool(_BARE.match(first))


def read(file: DeviceFile) -> DeviceReadings:
    """The points of an export, in the order of the file.

    Raises:
        DeviceError: no point, another layout, axes that are not Cartesian, a unit nobody knows, time runs backwards.
    """
    to_mm, frame, rows = None, "", list[_Row]()
    for at, text in enumerate(file.lines, 1):
        if text.startswith("//"):
            if found := _FRAME.match(text):
                frame = found[1]
            if found := _AXES.match(text):
                to_mm = _unit(file, at, found)
        elif text.strip():
            rows.append(_row(file, at, text))
    if not rows:
        raise DeviceError(f"{file.label}: no point in it; export points as text: name, x, y, z")
    time, found_times = _times(file, rows)
    return readings(
        file,
        NAME,
        kind=POSITIONS,
        line=[r.line for r in rows],
        to_mm=to_mm,
        frame=frame,
        name=[r.name for r in rows],
        group=[r.group for r in rows],
        numbers={"measured": [r.xyz for r in rows], "time": time},
        findings=tuple(found_times),
    )


def _unit(file: DeviceFile, at: int, found: re.Match[str]) -> float | None:
    if found[1].upper() != "CARTESIAN":
        why = f"axes are {found[1]}, expected CARTESIAN: export the points in a Cartesian frame"
        raise DeviceError(f"{file.label}: line {at}: {why}")
    if found[2] is None:
        return None
    word = found[2].strip().lower()
    if word not in MM_IN:
        raise DeviceError(f"{file.label}: line {at}: unit {found[2]!r}, expected mm, inch, m: export in one of them")
    return MM_IN[word]


def _row(file: DeviceFile, at: int, text: str) -> _Row:
    cells = [cell.strip() for cell in text.rstrip().rstrip(",").split(",")]
    stamp = cells.pop() if _STAMP.match(cells[-1]) else ""
    if not 4 <= len(cells) <= 6:
        layout = "expected [collection,] [group,] point, x, y, z [, date time]: export in this layout"
        raise DeviceError(f"{file.label}: line {at}: {len(cells)} values ({text.strip()[:60]!r}), {layout}")
    *names, x, y, z = cells
    xyz = (number(x, file.label, at, "x"), number(y, file.label, at, "y"), number(z, file.label, at, "z"))
    if is_number(names[-1]) and len(names) > 1 and "." in names[-1]:
        raise DeviceError(f"{file.label}: line {at}: more than three coordinates: {text.strip()[:60]!r}")
    return _Row(line=at, group="::".join(names[:-1]), name=names[-1], xyz=xyz, stamp=stamp)


def _times(file: DeviceFile, rows: Sequence[_Row]) -> tuple[npt.NDArray[np.float64], list[Finding]]:
    """(N,) s; where dates are of a whole second, the points of one are spread evenly within it."""
    if not any(r.stamp for r in rows):
        return np.full(len(rows), np.nan), []
    bare = next((r for r in rows if not r.stamp), None)
    if bare is not None:
        raise DeviceError(f"{file.label}: line {bare.line}: no date and time, other points have one: export it for all")
    seconds = np.array([_seconds(file, r) for r in rows])
    dates, per_second = np.unique(seconds, return_counts=True)
    if np.any(np.mod(seconds, SECOND)) or per_second.max() == 1:
        return seconds, []
    counts = dict(zip(dates.tolist(), per_second.tolist(), strict=True))
    place: dict[float, int] = {}
    spread = np.empty(len(rows))
    for k, s in enumerate(seconds.tolist()):
        place[s] = place.get(s, -1) + 1
        spread[k] = s + (place[s] + 0.5) / counts[s] * SECOND
    what = (
        f"dates are of a second and {per_second.min()} to {per_second.max()} points have the same: they are spread "
        "evenly within it, times may be up to a second off"
    )
    remedy = "What is left of it is estimated as a lag; export times with a fraction where the instrument has it"
    return spread, [Finding(NOTE if per_second.max() < 3 else WARNING, file.label, what, remedy)]


def _seconds(file: DeviceFile, row: _Row) -> float:
    """s of a date since 2000; whether month or day stands first does not matter to differences within a day."""
    found = _STAMP.match(row.stamp)
    one, two, year, hour, minute, second = (int(g) for g in found.groups()[:6]) if found else (0, 0, 0, 0, 0, 0)
    month, day = (one, two) if one <= 12 else (two, one)
    try:
        day_begins = datetime(year if year > 99 else 2000 + year, month, day)
        date = day_begins + timedelta(hours=hour, minutes=minute, seconds=second)
    except ValueError as e:
        raise DeviceError(f"{file.label}: line {row.line}: date {row.stamp!r}: {e}; export again") from e
    fraction = float(found[7] or 0.0) if found else 0.0
    return (date - datetime(2000, 1, 1)).total_seconds() + fraction
