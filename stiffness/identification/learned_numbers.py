"""Learned numbers: which numbers of tables the readings have taught."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.unknowns import Unknowns

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

# studied in tests/contracts/test_angle_tables.py
MEDIAN_TO_SD = 1.4826  # of the absolute value, normal distribution
FAR = 6.0  # spreads of a table: a number so far out is learned from too little, or from wrong readings


def learned_numbers(layout: Unknowns, parameters: Floats, seen: Bools, prior_sd: Floats) -> Bools:
    """(P,) false for numbers of tables that are not ``seen`` by a reading, or far out of the spread of their table:
    that of its median, and ``prior_sd`` at least."""
    out = np.ones(len(layout), dtype=bool)
    tables: dict[tuple[str, str, int], list[int]] = {}
    for k, u in enumerate(layout.free):
        if u.parameter.each > 1:
            tables.setdefault((u.effect, u.parameter.name, u.index // u.parameter.each), []).append(k)
    for at in (np.array(numbers) for numbers in tables.values()):
        size = np.abs(parameters[at])
        spread = MEDIAN_TO_SD * float(np.median(size[seen[at]])) if seen[at].any() else 0.0
        out[at] = seen[at] & (size <= FAR * np.maximum(prior_sd[at], spread))
    return out
