"""Surface points made whole: what a report leaves out comes from a table of nominal points, by name."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.devices.numbers import number
from compensator.devices.readings import SURFACE, DeviceFile, DeviceReadings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

Floats = npt.NDArray[np.float64]

NOMINALS = ("name", "x", "y", "z", "i", "j", "k")
SAME = 0.01  # mm: two tables of one drawing agree so far
ASIDE = 0.02  # of a normal: an axis that so little of it points along need not be measured
NOT_UNIT = 0.02


class NominalPoint(NamedTuple):
    """Of a table: ``line``, (3,) place in the unit of the report, (3,) outward normal."""

    line: int
    place: Floats
    normal: Floats


def nominal_points(file: DeviceFile) -> dict[str, NominalPoint]:
    """Nominal points by name, from a csv with the columns NOMINALS.

    Raises:
        DeviceError: a column is missing, a cell is no number, a name stands twice.
    """
    reader = csv.reader(io.StringIO(file.text))
    heading = [h.strip() for h in next(reader, [])]
    if missing := [name for name in NOMINALS if name not in heading]:
        wanted = ", ".join(NOMINALS)
        raise DeviceError(f"{file.label}: line 1: no column {', '.join(missing)}; expected {wanted}, with commas")
    out: dict[str, NominalPoint] = {}
    for cells in reader:
        if not any(cell.strip() for cell in cells):
            continue
        at = reader.line_num
        if len(cells) != len(heading):
            raise DeviceError(f"{file.label}: line {at}: {len(cells)} values, the heading has {len(heading)}")
        row = dict(zip(heading, (cell.strip() for cell in cells), strict=True))
        if row["name"] in out:
            raise DeviceError(f"{file.label}: line {at}: {row['name']!r} stands twice; keep one of them")
        values = [number(row[k], file.label, at, f"column {k}") for k in NOMINALS[1:]]
        out[row["name"]] = NominalPoint(at, np.array(values[:3]), np.array(values[3:]))
    return out


def completed(given: DeviceReadings, nominals: Mapping[str, NominalPoint] | None, to_mm: float) -> DeviceReadings:
    """Surface points with place, unit normal and deviation; those that lack one are left out and counted.

    Raises:
        DeviceError: a normal is not of length 1, the two nominal places of a point differ, no point is whole.
    """
    if given.kind != SURFACE:
        return given
    made, more = (given, []) if nominals is None else _filled(given, nominals, to_mm)
    length = np.linalg.norm(made.normal, axis=1)
    wrong = np.flatnonzero(np.abs(length - 1) > NOT_UNIT)
    if len(wrong):
        k = int(wrong[0])
        why = f"the normal {made.normal[k].tolist()} has length {length[k]:.4g}, expected 1: correct it"
        raise DeviceError(f"{made.at(k)}: point {made.name[k]!r}: {why}")
    normal = made.normal / length[:, None]
    seen = np.isfinite(made.measured - made.nominal)
    along = np.where(seen, normal * np.where(seen, made.measured - made.nominal, 0.0), 0.0).sum(axis=1)
    blind = np.any(~seen & ~(np.abs(normal) <= ASIDE), axis=1)
    own = np.where(np.isfinite(made.deviation), made.deviation, np.where(blind, np.nan, along))
    whole = np.isfinite(made.nominal).all(axis=1) & np.isfinite(normal).all(axis=1) & np.isfinite(own)
    if not whole.any():
        raise DeviceError(_asks_for_nominals(made))
    left = np.flatnonzero(~whole)
    if len(left):
        names = ", ".join(made.name[k] for k in left[:8]) + (" ..." if len(left) > 8 else "")
        what = f"points whose place, normal or deviation along it is not known are left out: {names}"
        remedy = f"Give them in --nominals, with the columns {', '.join(NOMINALS)}"
        more.append(Finding(WARNING, made.place(int(left[0])), what, remedy, count=len(left)))
    return replace(made, normal=normal, deviation=own).take(np.flatnonzero(whole), *more)


def _filled(
    given: DeviceReadings, nominals: Mapping[str, NominalPoint], to_mm: float
) -> tuple[DeviceReadings, list[Finding]]:
    place, normal = given.nominal.copy(), given.normal.copy()
    for k, name in enumerate(given.name):
        found = nominals.get(name)
        if found is None:
            continue
        apart = np.abs(place[k] - found.place) * to_mm
        if np.any(apart > SAME):
            axis = int(np.nanargmax(apart))
            raise DeviceError(
                f"{given.at(k)}: {'xyz'[axis]} of {name!r} is {place[k, axis]:g} there, but {found.place[axis]:g} at "
                f"line {found.line} of the table of nominals: correct one of them"
            )
        place[k] = np.where(np.isfinite(place[k]), place[k], found.place)
        normal[k] = np.where(np.isfinite(normal[k]), normal[k], found.normal)
    strange = [name for name in nominals if name not in given.name]
    told = [Finding(NOTE, given.source, f"nominals of points that it has not: {', '.join(strange)}")] if strange else []
    return replace(given, nominal=place, normal=normal), told


def _asks_for_nominals(given: DeviceReadings) -> str:
    """What to give, with the lines to begin with."""
    lines = []
    for name, place in zip(given.name[:12], given.nominal, strict=False):
        lines.append(f"    {name}," + ",".join(f"{v:g}" if np.isfinite(v) else "?" for v in place) + ",?,?,?")
    more = "" if len(given) <= 12 else f"\n    ... {len(given)} points in all"
    head = ",".join(NOMINALS)
    return (
        f"{given.source}: its points lack their normals, or coordinates: give a table of nominal points from the "
        f"drawing as --nominals FILE.csv, lengths in the unit of the report, i j k out of the material:\n    {head}\n"
        + "\n".join(lines) + more
    )
