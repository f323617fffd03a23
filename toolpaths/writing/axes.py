"""External axes beside the poses of a program, in the words of a language."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolpaths.external_axes import axis_number
from toolpaths.writing.numbers import number, printed
from toolpaths.writing.program import ExternalAxis, Floats, Program

DIGITS = {"mm": 4, "deg": 6}


def printed_places(axis: ExternalAxis, block: slice) -> list[str]:
    """Where the axis stands at some poses; a rail that stands still is formatted once."""
    digits = DIGITS[axis.unit]
    values = printed(axis.places[block], digits).tolist()
    made = {value: number(value, digits) for value in set(values)}
    return [made[value] for value in values]


def eax(program: Program, block: slice) -> list[str]:
    """``1200.5,9E9,...``: six places of an extjoint of RAPID."""
    columns = [["9E9"] * (block.stop - block.start)] * 6
    for axis in program.external:
        columns[axis_number(axis.name) or 0] = printed_places(axis, block)
    return [",".join(row) for row in zip(*columns, strict=True)]


def named(program: Program, block: slice) -> list[str]:
    """``,E1 1200.5`` for each axis by its number."""
    names = [f"E{(axis_number(axis.name) or 0) + 1}" for axis in program.external]
    columns = [printed_places(axis, block) for axis in program.external]
    rows = zip(*columns, strict=True) if columns else [()] * (block.stop - block.start)
    return ["".join(f",{name} {text}" for name, text in zip(names, row, strict=True)) for row in rows]


def places_of(texts: Sequence[Sequence[str]]) -> Floats | None:
    """(N, K) of the texts of K axes at N poses; None where there are none."""
    if not texts or not texts[0]:
        return None
    known: dict[str, float] = {}
    rows = [[known.setdefault(t, float(t)) if t not in known else known[t] for t in row] for row in texts]
    return np.array(rows, dtype=np.float64)
