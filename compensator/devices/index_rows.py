"""Rows of the program that readings belong to, as the command line gives them: 4,8,12 or 0:100:2 with both ends."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from compensator.errors import DeviceError

Floats = npt.NDArray[np.float64]
_PART = re.compile(r"(\d+(?:\.\d+)?)(?::(\d+)(?::(\d+))?)?$")
MOST = 10_000_000


def index_rows(text: str) -> Floats:
    """(M,) rows in the order given; ascending as a program runs.

    Raises:
        DeviceError: a part is no row and no range; rows go backwards.
    """
    rows: list[float] = []
    for part in (p.strip() for p in text.split(",")):
        found = _PART.match(part)
        if found is None:
            raise DeviceError(f"--index {text}: {part!r} is no row; expected rows such as 4,8,12 or 0:100:2 (from 0)")
        begin = float(found[1])
        if found[2] is None:
            rows.append(begin)
            continue
        end, step = int(found[2]), int(found[3] or 1)
        if step < 1 or end < begin or (end - begin) / step > MOST:
            raise DeviceError(f"--index {text}: {part!r}: expected FIRST:LAST:STEP, the last not before the first")
        rows += np.arange(begin, end + 0.5, step).tolist()
    back = next((k for k in range(1, len(rows)) if rows[k] < rows[k - 1]), None)
    if back is not None:
        raise DeviceError(f"--index {text}: row {rows[back]:g} after {rows[back - 1]:g}: a program runs forwards")
    return np.array(rows)
