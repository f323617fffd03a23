"""Reversals along a path: where a joint turns round, how well a reading shows it there, how far the others' are.

A gap shows where its joint turns round: the reading steps by the gap times the lever of the joint along the direction
that is read. Two joints that turn round at one place cannot be told apart there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

LEAST_TRAVEL = 1e-3  # rad before and after a reversal: longer than any gap, which has to be crossed
SEEN = 0.03  # of its lever: a joint whose step is so much smaller does not hide it, with a gap three times as large
STILL = 1e-9  # rad from pose to pose: a joint that moves less stands


@dataclass(frozen=True)
class Reversal:
    """A joint that turns round.

    Attributes:
        joint: counted from 0. row: of the path. along: rad, place on the circle. angle: rad, of the joint there.
        lever: m/rad along the direction that is read, signed. apart: rad on the circle to the nearest reversal of
            another joint that is seen beside it; inf: there is none.
    """

    joint: int
    row: int
    along: float
    angle: float
    lever: float
    apart: float


def reversals(along: Floats, q: Floats, lever: Floats) -> list[Reversal]:
    """The reversals of one way along a path, in its order.

    Args:
        along: (N,) rad on the circle. q: (N, n) rad. lever: (N, n) m/rad along the direction that is read.
    """
    turned = [(j, row) for j in range(q.shape[1]) for row in _turns(q[:, j])]
    out = []
    for j, row in sorted(turned, key=lambda t: (t[1], t[0])):
        seen = SEEN * abs(lever[row, j])
        others = [abs(along[row] - along[r]) for k, r in turned if k != j and abs(lever[r, k]) > seen]
        apart = float(min(others, default=np.inf))
        place, angle, by = float(along[row]), float(q[row, j]), float(lever[row, j])
        out.append(Reversal(joint=j, row=row, along=place, angle=angle, lever=by, apart=apart))
    return out


def _turns(angle: Floats) -> list[int]:
    """Rows where a joint turns round, with enough travel before and after."""
    step = np.diff(angle)
    moving = np.flatnonzero(np.abs(step) > STILL)
    turns = [int(b) for a, b in pairwise(moving) if step[a] * step[b] < 0]
    ends = [0, *turns, len(angle) - 1]
    travel = [abs(float(angle[b] - angle[a])) for a, b in pairwise(ends)]
    return [t for k, t in enumerate(turns) if min(travel[k], travel[k + 1]) > LEAST_TRAVEL]


def sides(q: Floats) -> Floats:
    """(N, n) sign of the last move of every joint along a path; that of its first move before it, 0: it never moves."""
    step = np.where(np.abs(np.diff(q, axis=0)) > STILL, np.sign(np.diff(q, axis=0)), np.nan)
    out = np.vstack([np.full((1, q.shape[1]), np.nan), step])
    for j in range(q.shape[1]):
        known = np.flatnonzero(np.isfinite(out[:, j]))
        if not len(known):
            out[:, j] = 0.0
            continue
        last = np.maximum(np.searchsorted(known, np.arange(len(q)), side="right") - 1, 0)
        out[:, j] = out[known[last], j]
    return out


def gap_sd(rows: Sequence[Floats], nuisance: Sequence[Floats], noise: float) -> Floats:
    """(n,) rad, standard deviation of the gap of every joint, from readings on both sides; inf: not determined.

    The reading of a joint with gap g that came from the side s is lever * (-s) * g / 2.

    Args:
        rows: parts of the readings, (N, n) m by gap, ``-side * lever / 2``. nuisance: (N, k) m by what is estimated
            beside the gaps, such as centre and length. noise: m of a reading.
    """
    design, beside = np.vstack(rows), np.vstack(nuisance)
    n = design.shape[1]
    seen = np.linalg.norm(design, axis=0) > 1e-9 * np.sqrt(len(design))
    # what the nuisances cannot explain of a column, and then what the other joints cannot
    left = design - beside @ np.linalg.lstsq(beside, design, rcond=None)[0]
    out = np.full(n, np.inf)
    for j in np.flatnonzero(seen):
        others = left[:, [k for k in np.flatnonzero(seen) if k != j]]
        own = left[:, j] - others @ np.linalg.lstsq(others, left[:, j], rcond=None)[0] if others.size else left[:, j]
        size = float(np.linalg.norm(own))
        out[j] = noise / size if size > 1e-6 * np.linalg.norm(design[:, j]) else np.inf
    return out
