"""Moves that make no poses: retracts to places of the machine (G28, G30, G53), and feeds to a height at the begin.

The way that is left must be free, and what is left out must not cut.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT, Toolpath
from toolpaths.writing.marker import MARKER


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

    Raises:
        ReadError: it does not.
    """
    poses = [(int(np.searchsorted(path.row, r.moves - 1e-9)), r) for r in retracts]
    inner = [(after, r) for after, r in poses if 0 < after < len(path)]
    if not inner:
        return
    height = path.position[:, 2]
    top = highest_cut(path)
    for after, r in inner:
        if not (low := float(min(height[after - 1], height[after]))) > top:
            problem = f"{r.words} is no place in the work object, and without it the tool would travel at "
            problem += f"Z {low * 1e3:g} mm, cuts reach up to Z {top * 1e3:g} mm"
            raise ReadError(path.source, r.line, problem, "Add a rapid to a higher Z before it, and approach from one.")


def highest_cut(path: Toolpath) -> float:
    """Z of the highest cutting pose, m; moves straight up are retracts, whatever their feed."""
    step = np.diff(path.position, axis=0, prepend=path.position[:1])
    up = (step[:, 0] == 0) & (step[:, 1] == 0) & (step[:, 2] >= 0)
    up[0] = False
    return float(np.max(path.position[:, 2], where=(path.kind == CUT) & ~up, initial=-np.inf))
