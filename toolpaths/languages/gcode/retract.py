"""Moves that make no poses: retracts to places of the machine (G28, G30, G53), and feeds to a height at the begin.

The way that is left must be free, and what is left out must not cut.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Floats, Toolpath
from toolpaths.writing.marker import MARKER

UP = np.array([0.0, 0.0, 1.0])
_WAY = np.linspace(0.0, 1.0, 101)[:, None]  # places on the way between two poses
_UPRIGHT = 1e-9


class Retract(NamedTuple):
    """A retract of the file: how many moves come before it, its line, its words."""

    moves: int
    line: int
    words: str


class Clearance(NamedTuple):
    """A feed in Z alone before X and Y are known: the height that it leads to, m, its line, the refusal if it cuts."""

    height: float
    line: int
    problem: str
    remedy: str


def check_clearances(path: Toolpath, clearances: list[Clearance]) -> None:
    """Feeds that are left out must end where the file has its clearance: no cut is higher, and some are lower.

    A file that this project wrote has been looked at before: its cuts are a correction away from there.

    Raises:
        ReadError: one does not: it may cut.
    """
    if any(MARKER in event.word for event in path.events):
        return
    lowest = float(np.min(path.position[:, 2], where=path.kind == CUT, initial=np.inf))
    for c in clearances:
        if not (c.height >= highest_cut(path) and c.height > lowest):
            raise ReadError(path.source, c.line, c.problem, c.remedy)


def check_retracts(path: Toolpath, retracts: list[Retract]) -> None:
    """The straight way between the poses around a retract must run above all cuts of the file.

    Above: along the tool of the pose before, or of that after; between tools that stand differently all of the way.

    Raises:
        ReadError: it does not.
    """
    poses = [(int(np.searchsorted(path.row, r.moves - 1e-9)), r) for r in retracts]
    tops: dict[bytes, float] = {}
    for after, r in poses:
        if not 0 < after < len(path):
            continue
        way = path.position[after - 1] + _WAY * (path.position[after] - path.position[after - 1])
        above = np.full(len(_WAY), -np.inf)
        for axis in path.axis[after - 1 : after + 1]:
            if (key := axis.round(9).tobytes()) not in tops:
                tops[key] = highest_cut(path, axis)
            above = np.maximum(above, way @ axis - tops[key])
        if not above.min() > 0:
            low = float(way[int(np.argmin(above))] @ axis)
            along = "Z" if abs(axis[2] - 1.0) < _UPRIGHT else "along the tool"
            problem = f"{r.words} is no place in the work object, and without it the tool would travel at "
            problem += f"{along} {low * 1e3:g} mm, cuts reach up to {along} {tops[key] * 1e3:g} mm"
            raise ReadError(path.source, r.line, problem, "Add a rapid to a higher Z before it, and approach from one.")


def highest_cut(path: Toolpath, axis: Floats = UP) -> float:
    """How far along an axis the highest cutting pose lies, m; moves straight up are retracts, whatever their feed."""
    height = path.position @ axis
    step = np.diff(path.position, axis=0, prepend=path.position[:1])
    rise = step @ axis
    up = (rise >= 0) & (np.linalg.norm(step - rise[:, None] * axis, axis=1) < 1e-12)
    up[0] = False
    return float(np.max(height, where=(path.kind == CUT) & ~up, initial=-np.inf))
