"""Contacts in the way of a choice of axes: which bodies touch where nothing else would forbid a place or a way."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from compensator.axes.axis_lattice import AxisLattice, PathStages
from compensator.axes.cheapest_way import cheapest_way
from compensator.cell.external_axes import rail_shift, workobject_along
from compensator.path.pose_text import place
from compensator.scene.carrier_frames import STILL
from compensator.turn.turn_grid import COLLIDING, TurnGrid
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

NAMED = 4  # pairs of bodies in a message


def contacts_in_the_way(
    stages: PathStages, shape: tuple[int, ...], places: Floats, grids: Mapping[int, list[TurnGrid]], *, one_turn: bool
) -> str:
    """Which bodies touch at the fixed place, or along the way of the rails, that would serve but for contacts with the
    fewest of them; empty: contacts close nothing, or nothing stands around.

    Args:
        shape: of the grid of places (P, A). grids: arm configuration -> P grids.
    """
    lattices = [_but_for_contacts(stages, places, branch, some) for branch, some in grids.items()]
    found = [(one, *best) for one in lattices if (best := _fixed(one)) is not None]
    told = "stands at {}"
    if not found and stages.free.moving.any():
        found = [(one, *best) for one in lattices if (best := _way(one, shape, one_turn)) is not None]
        told = "goes from {} on"
    if not found:
        return ""
    lattice, _, at, column = min(found, key=lambda one: one[1])
    pairs = _pairs(lattice, at, column)
    if not pairs:
        return ""
    where = told.format(stages.free.told(lattice.places[at[0]]))
    return f"; contacts are in the way: where it {where}, {', '.join(pairs[:NAMED])}"


def touching(stages: PathStages, some: Toolpath, q: Floats) -> tuple[int, str] | None:
    """The first pose of a path with its axes at which something touches at joint angles ``q`` (N, n) rad, and names of
    the two bodies; None: nothing does."""
    if stages.collider is None:
        return None
    placement, tools = stages.job.placement, stages.job.arm.tools
    work, shift = workobject_along(placement, some), rail_shift(placement, some)
    for k in range(len(some)):
        world = STILL if shift is None else Frame(np.eye(3), shift[k])
        pair = stages.collider.first_touching(
            q[k : k + 1], workobject=work.take(k) if work.origin.ndim == 2 else work, world=world,
            tool=None if tools.any_number else int(some.tool[k]), cutting=bool(some.kind[k] == CUT),
        )  # fmt: skip
        if pair is not None:
            return k, " and ".join(pair)
    return None


def _but_for_contacts(stages: PathStages, places: Floats, branch: int, grids: list[TurnGrid]) -> AxisLattice:
    """A contact costs 1, and nothing else does."""
    free, hit = (np.stack([one(grid) for grid in grids], axis=1) for one in (_free, _colliding))
    q = np.stack([grid.q for grid in grids], axis=1)
    price = np.where(free, 0.0, np.where(hit, 1.0, np.inf))
    return AxisLattice(stages, places, branch, q, price=price, worth=np.zeros_like(q))


def _free(grid: TurnGrid) -> npt.NDArray[np.bool_]:
    return grid.free


def _colliding(grid: TurnGrid) -> npt.NDArray[np.bool_]:
    return np.asarray(grid.status == COLLIDING)


def _fixed(lattice: AxisLattice) -> tuple[float, Rows, Rows] | None:
    """Price, place and turn (S,) of the best fixed place."""
    total = lattice.constant()
    at, column = (int(v) for v in np.unravel_index(np.argmin(total), total.shape))
    stay = np.ones(len(lattice.price), dtype=np.intp)
    return (float(total[at, column]), at * stay, column * stay) if np.isfinite(total[at, column]) else None


def _way(lattice: AxisLattice, shape: tuple[int, ...], one_turn: bool) -> tuple[float, Rows, Rows] | None:
    """As ``_fixed``, of the cheapest way."""
    way = cheapest_way(lattice, shape, one_turn=one_turn)
    if way is None:
        return None
    at = np.array([np.argmin(np.abs(lattice.places - one).sum(axis=1)) for one in way.places], dtype=np.intp)
    turns = lattice.price.shape[2]
    return way.price, at, np.round(way.turn * turns / (2 * np.pi)).astype(np.intp) % turns


def _pairs(lattice: AxisLattice, at: Rows, column: Rows) -> list[str]:
    """What touches along a way, each pair once, with its first pose."""
    stages, found = lattice.stages, dict[str, str]()
    every = np.arange(len(at))
    for k in np.flatnonzero(lattice.price[every, at, column] > 0.0).tolist():
        moved = stages.free.on(stages.some, lattice.places[at[k]]).take([k])
        hit = touching(stages, moved, lattice.q[k, at[k], column[k]][None])
        if hit is not None:
            found.setdefault(hit[1], place(stages.toolpath, int(stages.rows[k])))
    return [f"{pair} touch at {where}" for pair, where in found.items()]
