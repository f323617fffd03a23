"""The names of the columns of CSV poses, and what a file is told that has no line with them."""

from __future__ import annotations

import math
import re

from toolpaths.errors import ReadError

POSITION = ("x_mm", "y_mm", "z_mm")
AXIS = ("i", "j", "k")
QUATERNION = ("qw", "qx", "qy", "qz")
UNIT_TOLERANCE = 1e-3


def refuse_headerless(first: str, source: str) -> None:
    """Refuse a file whose first line is numbers, with the header that fits them: nobody but its author knows its units.

    Raises:
        ReadError: names line 1.
    """
    row = _numbers(first.split(","))
    commas = row is not None
    if row is None:
        row = _numbers(re.split(r"[;\s]+", first.strip()))
    if row is None or len(row) < 3:
        return
    problem = f"{first.strip()[:60]!r}: numbers, where the header line is expected"
    names, what = _header(row)
    separated = "" if commas else "Put commas between the columns. "
    raise ReadError(source, 1, problem, f"{separated}Paste this line on top, {what}: {','.join(names)}")


def _numbers(cells: list[str]) -> list[float] | None:
    try:
        return [float(cell.strip().strip('"')) for cell in cells]
    except ValueError:
        return None


def _header(row: list[float]) -> tuple[tuple[str, ...], str]:
    """Names for the columns of a row, as far as its numbers tell, and what has to be true of them."""
    units = "if these are x, y, z in mm"
    if len(row) in (7, 8) and _is_unit(row[3:7]) and not _is_unit(row[3:6]):
        feed = ("feed_mm_min",) * (len(row) - 7)
        return (*POSITION, *QUATERNION, *feed), f"{units} and the quaternion of the TCP{_FEED * len(feed)}"
    if len(row) in (6, 7) and _is_unit(row[3:6]):
        feed = ("feed_mm_min",) * (len(row) - 6)
        away = f"{units} and the tool axis, from the tip to the spindle{_FEED * len(feed)}"
        return (*POSITION, *AXIS, *feed), away
    if len(row) == 3:
        return (*POSITION, *AXIS), f"{units}, and add the tool axis to every row, such as 0,0,1"
    return (*POSITION, *AXIS), "with a name for each column that the file has"


_FEED = " and the feed in mm/min"


def _is_unit(vector: list[float]) -> bool:
    return abs(math.hypot(*vector) - 1.0) <= UNIT_TOLERANCE
