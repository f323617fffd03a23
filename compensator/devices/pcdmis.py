"""PC-DMIS: text reports of dimensions; of each, the rows AX that place a point of a surface."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from compensator.devices.numbers import MM_IN, is_number, number
from compensator.devices.readings import SURFACE, DeviceFile, DeviceReadings, readings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

NAME = "pc-dmis"
_DIMENSION = re.compile(r"(?:DIM\s+)?(.*?)\s*=\s*(.+?)\s+UNITS\s*=\s*(\w+)")
_PLACE = re.compile(r"(?:LOCATION|POSITION) OF (\w+) (\S+)")
_HEADING = re.compile(r"AX\s+NOMINAL\s")
_PAGE = re.compile(r"PART NUMBER=.*PAGE#=")  # a heading of a page may stand within a table
_REPORT = re.compile(r"^AX\s+NOMINAL\s+\+TOL\s+-TOL", re.MULTILINE)
SURFACES = ("POINT", "PLANE")  # of the others the location is that of an axis or a centre
AXES = ("X", "Y", "Z")
ALONG = "T"  # the deviation along the normal of the point
ROUNDING = 1.6e-3  # of a report: three numbers with three decimals


class _Axis(NamedTuple):
    """A row of a point: the numbers of one axis, the limits of its deviation."""

    nominal: float
    measured: float
    deviation: float
    low: float = np.nan
    high: float = np.nan


NOT_REPORTED = _Axis(np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class _Point:
    """What the report has of a feature, by axis; ``line`` of its first dimension."""

    name: str
    line: int
    axes: dict[str, _Axis] = field(default_factory=dict)

    def axis(self, name: str) -> _Axis:
        return self.axes.get(name, NOT_REPORTED)


def recognised(file: DeviceFile) -> bool:
    """By the heading of its tables."""
    return bool(_REPORT.search(file.text))


def read(file: DeviceFile) -> DeviceReadings:
    """The points and planes of a report. It has no normals: they, and the axes that it leaves out, come from elsewhere.

    Raises:
        DeviceError: nothing of a surface in it; a row that cannot be read, or whose deviation is another.
    """
    points: dict[str, _Point] = {}
    units: dict[str, int] = {}
    left: Counter[str] = Counter()
    twice: list[str] = []
    point, within = None, False
    for at, text in enumerate(file.lines, 1):
        if found := _DIMENSION.match(text):
            within = True
            point = _begun(points, found[2], at)
            if point is None:
                left[found[2].split(" OF ")[0].split("  ")[0] + _of_what(found[2])] += 1
            else:
                units.setdefault(found[3].upper(), at)
        elif _HEADING.match(text) or _PAGE.match(text) or not text.strip():
            continue
        elif within and point is not None and _is_row(text) and _row(file, at, text.split(), point):
            twice.append(f"{file.label}:{at}")
    chosen = [p for p in points.values() if p.axes]
    if not chosen:
        kinds = ", ".join(f"{n} {what}" for what, n in left.most_common(6)) or "no dimension"
        raise DeviceError(
            f"{file.label}: no location of a point or plane in it ({kinds}): a surface trace needs points; report "
            "them with LOCATION and the axes X, Y, Z, or T along their normal"
        )
    return readings(
        file,
        NAME,
        kind=SURFACE,
        line=[p.line for p in chosen],
        to_mm=_unit(file, units),
        name=[p.name for p in chosen],
        numbers={
            "nominal": [[p.axis(k).nominal for k in AXES] for p in chosen],
            "measured": [[p.axis(k).measured for k in AXES] for p in chosen],
            "deviation": [p.axis(ALONG).deviation for p in chosen],
            "low": [p.axis(ALONG).low for p in chosen],
            "high": [p.axis(ALONG).high for p in chosen],
        },
        findings=tuple(_findings(file, left, twice)),
    )


def _is_row(text: str) -> bool:
    return text.split()[0] in (*AXES, ALONG)


def _begun(points: dict[str, _Point], what: str, at: int) -> _Point | None:
    """The feature of a dimension that places a point of a surface."""
    found = _PLACE.match(what)
    if found is None or found[1].upper() not in SURFACES:
        return None
    return points.setdefault(found[2], _Point(found[2], at))


def _of_what(dimension: str) -> str:
    found = _PLACE.match(dimension)
    return f" OF {found[1]}" if found else ""


def _row(file: DeviceFile, at: int, words: list[str], point: _Point) -> bool:
    """Take a row up; whether the axis was there before."""
    name = words[0]
    numbers = [w for w in words[1:] if is_number(w)]
    if len(numbers) < 3:
        raise DeviceError(
            f"{file.label}: line {at}: {' '.join(words)[:60]!r} has {len(numbers)} numbers, expected at least NOMINAL, "
            "MEAS, DEV: the row may be cut off; export the report again"
        )
    values = [number(w, file.label, at, f"axis {name}") for w in numbers]
    nominal = values[0]
    measured, deviation = values[1:3] if len(values) == 3 else values[-3:-1]  # OUTTOL is the last of a full row
    if name != ALONG and abs(measured - nominal - deviation) > ROUNDING:
        raise DeviceError(
            f"{file.label}: line {at}: axis {name} of {point.name}: DEV {deviation:g}, but MEAS - NOMINAL is "
            f"{measured - nominal:.4g}: export the report with signed deviations and the usual columns"
        )
    again = name in point.axes
    limits = (-abs(values[2]), values[1]) if len(values) > 5 else (np.nan, np.nan)
    point.axes[name] = _Axis(nominal, measured, deviation, *limits)
    return again


def _unit(file: DeviceFile, units: dict[str, int]) -> float:
    known = {name: MM_IN.get(name.lower()) for name in units}
    strange = next((name for name, size in known.items() if size is None), None)
    if strange is not None:
        raise DeviceError(f"{file.label}: line {units[strange]}: UNITS={strange}, expected MM or IN")
    if len(set(known.values())) > 1:
        places = ", ".join(f"{name} (line {at})" for name, at in units.items())
        raise DeviceError(f"{file.label}: points in several units: {places}; export the report in one")
    return next(size for size in known.values() if size is not None)


def _findings(file: DeviceFile, left: Counter[str], twice: list[str]) -> Iterable[Finding]:
    if left:
        kinds = ", ".join(f"{n} {what}" for what, n in left.most_common())
        yield Finding(NOTE, file.label, f"{left.total()} dimensions are no points of a surface, left out: {kinds}")
    if twice:
        what = "an axis of a point is reported again: the last one counts"
        yield Finding(WARNING, twice[0], what, count=len(twice))
