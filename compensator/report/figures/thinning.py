"""How much of a long path goes into a figure, and how its numbers are rounded."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.scene.packing import packed
from compensator.solve.compensation import Compensation

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

LIMIT = 5000  # points per curve; a screen cannot resolve more


def thin(columns: Floats, limit: int = LIMIT) -> Index:
    """Rows to draw: in every stretch those with the least and the largest value of every column (N, k).

    First and last row are kept, and so is every extreme of the whole; at most ``limit`` rows.
    """
    rows, k = columns.shape
    if rows <= limit:
        return np.arange(rows)
    stretches = max(1, (limit - 2) // (2 * k))
    length = -(-rows // stretches)
    stretches = -(-rows // length)
    padded = np.concatenate([columns, np.repeat(columns[-1:], stretches * length - rows, axis=0)])
    blocks = padded.reshape(stretches, length, k)
    first = np.arange(stretches)[:, None] * length
    picked = np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1)]).ravel()
    return np.unique(np.minimum(np.concatenate([picked, [0, rows - 1]]), rows - 1)).astype(np.intp)


def path_length(c: Compensation) -> Floats:
    """(N,) m along the nominal path, rapids included."""
    step = np.linalg.norm(np.diff(c.path.toolpath.on_part, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(step)])


def typed(values: npt.NDArray[Any], kind: str) -> dict[str, str]:
    """As plotly.js takes arrays of numbers of one kind: a third of the text."""
    rounded = values.round() if kind.startswith("u") else values
    return {"dtype": kind, "bdata": packed(rounded, kind)}


def numbers(values: Floats, digits: int | None = None) -> list[float | None]:
    """Rounded for the page, by default to a 100,000th of the largest; null where not finite."""
    if digits is None:
        largest = float(np.max(np.abs(values), initial=0.0, where=np.isfinite(values)))
        digits = 5 - int(np.floor(np.log10(largest))) if largest > 0 else 0
    rounded = np.round(values, digits) + 0.0  # no -0
    return [v if np.isfinite(v) else None for v in rounded.tolist()]
