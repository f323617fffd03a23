"""The samples of a trace: readings in mm, with rows of the program and runs, checked; and their csv."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.devices.index_rows import index_rows
from compensator.devices.order import TraceOrder
from compensator.devices.readings import BALLBAR, POSITIONS, SURFACE, DeviceReadings
from compensator.errors import DeviceError
from toolpaths.finding import NOTE, WARNING, Finding

Floats = npt.NDArray[np.float64]

FARTHEST = 1e5  # mm
LARGE = 5.0  # mm: a deviation that is rather a wrong frame or unit
DECIMALS = 6  # of a millimetre, a second: a tenth of what any instrument of a shop resolves, and more


@dataclass(frozen=True, repr=False)
class SampleTable:
    """Samples of a trace: N rows.

    Attributes:
        kind: as in DeviceReadings. columns: name -> (N,) in the units of trace/1 (mm, s, deg C), as in samples.csv.
        findings: about them.
    """

    kind: str
    columns: Mapping[str, Floats]
    findings: tuple[Finding, ...] = ()

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def __repr__(self) -> str:
        return f"SampleTable({len(self)} {self.kind})"

    @property
    def runs(self) -> int:
        """How many runs of the program."""
        return len(np.unique(self.columns["run"])) if "run" in self.columns else 1

    def csv(self) -> str:
        """The text of samples.csv."""
        return csv_text(self.columns)


def csv_text(columns: Mapping[str, Sequence[float] | Floats]) -> str:
    """Columns as csv, a row per sample; NaN is an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    rows = zip(*([_text(name, v) for v in values] for name, values in columns.items()), strict=True)
    writer.writerows(rows)
    return text.getvalue()


def _text(name: str, value: float) -> str:
    if np.isnan(value):
        return ""
    digits = 9 if name in ("i", "j", "k") else DECIMALS
    shown = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if shown == "-0" else shown


def samples_of(given: DeviceReadings, order: TraceOrder, to_mm: float, rows: int | None) -> SampleTable:
    """The samples that readings are; ``rows``: how many the program has, None: not known.

    Raises:
        DeviceError: by line, where a number cannot be.
    """
    index, run = _index(given, order, rows)
    columns: dict[str, Floats] = {}
    if index is not None:
        columns["index"] = index
    if given.kind == POSITIONS:
        columns |= dict(zip("xyz", (given.measured * to_mm).T, strict=True))
    elif given.kind == BALLBAR:
        nominal = np.nan if order.radius is None else order.radius
        columns["radius"] = np.where(np.isfinite(given.radius), given.radius, nominal / to_mm + given.deviation) * to_mm
    else:
        columns |= dict(zip("xyz", (given.nominal * to_mm).T, strict=True))
        columns |= dict(zip("ijk", given.normal.T, strict=True))
        columns["deviation"] = given.deviation * to_mm
    if run is not None:
        columns["run"] = run
    if np.isfinite(given.time).all():
        columns["time"] = given.time - given.time.min()
    if np.isfinite(given.sd).all():
        columns["sd"] = given.sd * to_mm
    columns |= given.columns
    _refuse_impossible(given, columns, order)
    return SampleTable(given.kind, columns, tuple(_findings(given, columns, to_mm)))


def _index(given: DeviceReadings, order: TraceOrder, rows: int | None) -> tuple[Floats | None, Floats | None]:
    """(N,) rows of the program, and runs; None where there are none."""
    run = given.run if np.isfinite(given.run).all() else None
    index = given.index if np.isfinite(given.index).all() else None
    if order.index is not None:
        each = index_rows(order.index)
        times, left = divmod(len(given), len(each))
        if left:
            raise DeviceError(
                f"{given.source}: --index {order.index}: {len(each)} rows for {len(given)} readings: give a row for "
                "every reading, or of every run the same rows"
            )
        index = np.tile(each, times)
        if times > 1:
            if run is not None:
                why = "the file has runs; give a row for every reading"
                raise DeviceError(f"{given.source}: --index {order.index}: {why}")
            run = np.repeat(np.arange(1.0, times + 1), len(each))
    if index is not None:
        last = np.inf if rows is None else rows - 1
        bad = np.flatnonzero((index < 0) | (index > last))
        if len(bad):
            k = int(bad[0])
            bound = "0" if index[k] < 0 else f"{last:g}, the last row of the program, counted from 0"
            raise DeviceError(f"{given.at(k)}: index {index[k]:g} is beyond {bound}")
    if run is not None and np.any(run != np.rint(run)):
        k = int(np.argmax(run != np.rint(run)))
        raise DeviceError(f"{given.at(k)}: run {run[k]:g}: expected a whole number")
    return index, run


def _refuse_impossible(given: DeviceReadings, columns: Mapping[str, Floats], order: TraceOrder) -> None:
    for name in (*"xyz", "deviation", "radius"):
        bad = np.flatnonzero(np.abs(columns.get(name, np.zeros(1))) > FARTHEST)
        if len(bad):
            k = int(bad[0])
            raise DeviceError(f"{given.at(k)}: {name} = {columns[name][k]:g} mm is beyond {FARTHEST:g}: check --units")
    if order.radius is not None and given.kind == BALLBAR:
        bad = np.flatnonzero(np.abs(columns["radius"] - order.radius) > LARGE)
        if len(bad):
            k = int(bad[0])
            raise DeviceError(
                f"{given.at(k)}: radius {columns['radius'][k]:g} mm, nominal {order.radius:g}: no ball-bar is pulled "
                f"out by {LARGE:g} mm. Deviations want --column deviation=... instead"
            )
    if given.kind == POSITIONS and "index" not in columns:
        back = np.flatnonzero(np.diff(columns["time"]) < 0)
        if len(back):
            why = "time runs backwards; put the rows in order, or give --index"
            raise DeviceError(f"{given.at(int(back[0]) + 1)}: {why}")
    if "sd" in columns and np.any(columns["sd"] <= 0):
        k = int(np.argmax(columns["sd"] <= 0))
        raise DeviceError(f"{given.at(k)}: sd = {columns['sd'][k]:g} mm, expected above 0")


def _findings(given: DeviceReadings, columns: Mapping[str, Floats], to_mm: float) -> Iterator[Finding]:
    if given.kind == POSITIONS and "index" not in columns:
        what = "no index: a stream, matched with the program by arc length and time"
        yield Finding(NOTE, given.source, what, "Where the tool stood still for each reading, give --index")
    if given.kind != SURFACE:
        return
    deviation = columns["deviation"]
    out = np.flatnonzero((deviation > given.high * to_mm) | (deviation < given.low * to_mm))
    if len(out):
        what = "points out of their tolerance; they are kept"
        yield Finding(NOTE, given.place(int(out[0])), what, count=len(out))
    large = np.flatnonzero(np.abs(deviation) > LARGE)
    if len(large):
        k = int(large[0])
        what = f"deviations above {LARGE:g} mm"
        remedy = "Check units, the frame of the measurement, and that normals point out of the material"
        yield Finding(WARNING, given.place(k), what, remedy, count=len(large))
