"""Made by: the poses of points of a surface whose rows are not told, from the cutter of the cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import Cell
from compensator.errors import TraceError
from compensator.trace.contact import TouchingCutter, contacts
from compensator.trace.trace_samples import TraceSamples
from stiffness.session.path_trace import CommandedRows

Floats = npt.NDArray[np.float64]

NAMED = 12  # lines that a note has room for


def at_rows(samples: TraceSamples) -> Floats:
    """(N,) rows of readings.

    Raises:
        TraceError: they are not known.
    """
    if samples.index is None:
        raise TraceError("column index missing: add it")
    return samples.index


def with_contacts(
    samples: TraceSamples, rows: CommandedRows, cell: Cell, label: str
) -> tuple[TraceSamples, str]:
    """Samples with the rows that made them, without those that no cut made; and a note that lists these.

    Raises:
        TraceError: the rows are not told, and no cutter is there to find them, or none of the points was cut.
    """
    if samples.index is not None:
        return samples, ""
    cutter = _cutter(cell, label)
    index = contacts(cell.workobject.frame().at(samples.read[:, :3]), rows, cutter)
    made = np.isfinite(index)
    if not made.any():
        raise TraceError(
            f"{label}: no cut of the program touches its points with a cutter of {2e3 * cutter.radius:g} mm: are "
            "x, y, z nominal points in the work object, mm, and is it this program? Or give the column index"
        )
    found = replace(samples, index=index).take(np.flatnonzero(made))
    if made.all():
        return found, ""
    lines = samples.line[~made]
    more = f" and {len(lines) - NAMED} more" if len(lines) > NAMED else ""
    listed = ", ".join(map(str, lines[:NAMED]))
    return found, f"{label}: {len(lines)} points that no cut made take no part: rows {listed}{more}"


def _cutter(cell: Cell, label: str) -> TouchingCutter:
    cutter = getattr(cell.process, "cutter", None)
    if cutter is None or cutter.diameter is None:
        raise TraceError(
            f"{label}: column index missing, and {cell.source} has no [process.cutter] with a diameter to find the "
            "poses with: add one of the two"
        )
    radius = cutter.diameter / 2e3
    corner = radius if cutter.shape == "ball" else (cutter.corner_radius or 0.0) / 1e3
    return TouchingCutter(radius, min(corner, radius), (cutter.length or 1e3) / 1e3)
