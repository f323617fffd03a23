"""Windows: keys of a path decided part by part, parts overlapping, each by steps that are shortened until they pay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.turn.turn_cost import ROUGH, KeyMotion

Floats = npt.NDArray[np.float64]

WINDOW, OVERLAP = 240, 40  # keys
HELD = 2  # first keys of a part that stay: it goes on from what is decided, with its speed
STILL = 2e-5  # rad: travel below it costs as its square
ENOUGH = 1e-4  # of the cost: a step that gains less is the last
DAMPING = 1e-6  # of the largest curvature
SHORTER = (1.0, 0.5, 0.2, 0.05)  # of a step, until one pays


@dataclass(frozen=True, eq=False)
class Refined:
    """What is chosen at every key (K, ...), the number of windows, and of those that failed and kept their start."""

    values: Floats
    windows: int
    failed: int


def refined_in_windows(values: Floats, solve: Callable[[slice, int, Floats], Floats | None]) -> Refined:
    """Values (K, ...) window by window.

    Args:
        solve: of keys, the number of the first ones that stay, and their values; None where a program failed.
    """
    out, count, failed, windows, begin = values.copy(), len(values), 0, 0, 0
    while begin < count - 1:
        end = min(begin + WINDOW, count)
        found = solve(slice(begin, end), 0 if begin == 0 else HELD, out[begin:end])
        failed += found is None
        windows += 1
        if found is not None:
            out[begin:end] = found
        begin = end if end == count else end - OVERLAP
    return Refined(out, windows, failed)


def descended(
    values: Floats, *, size: Callable[[Floats], float], step: Callable[[Floats], Floats | None],
    moved: Callable[[Floats, Floats], Floats], steps: int,
) -> Floats | None:  # fmt: skip
    """Values after at most so many steps, each shortened until ``size`` falls; None where a step has none."""
    now = size(values)
    for _ in range(steps):
        whole = step(values)
        if whole is None:
            return None
        tried = (moved(values, share * whole) for share in SHORTER)
        sized = ((one, size(one)) for one in tried)
        better = next(((one, less) for one, less in sized if less < now), None)
        if better is None:
            break
        gained, (values, now) = now - better[1], better
        if gained < ENOUGH * now:
            break
    return values


def smooth_weights(motion: KeyMotion, part: slice) -> tuple[Floats, Floats, Floats, Floats]:
    """Of the keys (m,); of accelerations (m - 2, 1), and shares (m - 2, 1) of the ways before and after in them."""
    a, b = part.start, part.stop
    time = np.where(motion.time > 0, motion.time, 1.0)[a : b - 1, None]
    mean = (time[1:] + time[:-1]) / 2
    counts = motion.smooth[a + 1 : b - 1, None] * motion.weight[a + 1 : b - 1, None]
    return motion.weight[a:b], ROUGH**2 * counts, 1 / (time[:-1] * mean), 1 / (time[1:] * mean)


def travelled(price: Floats, way: Floats) -> float:
    """m3, of ways (m - 1, n) rad at a price (m - 1, n) m3/rad."""
    return float((price * (np.sqrt(way**2 + STILL**2) - STILL)).sum())


def minimised(solver: ca.Function, **given: Any) -> Floats | None:
    """(x,) that a quadratic program gives; None where its status is not that of success."""
    x = np.asarray(solver(**given)["x"], dtype=float).ravel()
    return x if solver.stats()["success"] and np.isfinite(x).all() else None
