"""Random walks of cutters through a block, and the nodes of a field that brute force says are wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.kernels.field import CELL
from compensator.process.milling.path import MillingPath
from compensator.process.milling.remains import Remains
from tests.oracles import milling as oracle

Floats = npt.NDArray[np.float64]

BLOCK = ((-30.0, -30.0, -25.0), (30.0, 30.0, 0.0))  # mm
SHAPES: dict[str, tuple[Cutter, oracle.Shape]] = {
    "flat": (Cutter("flat", 0.010, 3, 0.014), oracle.flat(0.005, 0.014)),
    "bull": (Cutter("bull", 0.012, 4, 0.014, corner_radius=0.002), oracle.bull(0.006, 0.002, 0.014)),
    "ball": (Cutter("ball", 0.010, 2, 0.014), oracle.bull(0.005, 0.005, 0.014)),
    "taper": (Cutter("taper", 0.006, 2, 0.014, half_angle=np.radians(5)), oracle.cone(0.003, np.radians(5), 0.014)),
    "drill": (
        Cutter("drill", 0.010, 2, 0.014, half_angle=np.radians(59)), oracle.drill(0.005, np.radians(118), 0.014),
    ),
}  # fmt: skip
SURE = 1e-6  # m: nearer to a surface nobody is wrong
NEAR = 2.0  # cells


def random_walk(seed: int, turning: bool, moves: int) -> tuple[Floats, Floats]:
    """Points (N, 3) mm and axes (N, 3): to and fro in the upper part of the block, back over itself."""
    rng = np.random.default_rng(seed)
    points, axes = [np.array([-40.0, -10.0, -2.0])], [np.array([0.0, 0.0, 1.0])]
    while len(points) <= moves:
        middle = np.array([0.0, 0.0, -3.5])
        way = rng.normal(size=3) * [6, 6, 0.8] + 0.15 * (middle - points[-1])
        point = points[-1] + way
        point[2] = np.clip(point[2], -7.0, -0.5)
        points.append(point)
        lean = axes[-1] + (rng.normal(size=3) * [0.06, 0.06, 0] if turning else 0.0)
        lean[:2] *= min(1.0, 0.25 / max(float(np.hypot(*lean[:2])), 1e-9))
        axes.append(lean / np.linalg.norm(lean))
    return np.array(points), np.array(axes)


def sweeps_of(walked: MillingPath, shape: oracle.Shape) -> list[oracle.Sweep]:
    """Every move, for the oracle."""
    p, a = walked.position, walked.axis
    return [oracle.Sweep(shape, p[i], p[i + 1], a[i], a[i + 1]) for i in range(len(walked) - 1)]


def nodes(remains: Remains, near: int, far: int, seed: int = 1) -> Floats:
    """(P, 3) m: nodes of the field in the block, so many near a cut (as the field tells), and elsewhere."""
    every, rng = _all_nodes(remains), np.random.default_rng(seed)
    cell = float(remains.field.frame[CELL])
    depth = remains.depth(every)
    of_block = np.abs(depth - oracle.box(*(np.array(BLOCK) * 1e-3))(every)) < 1e-9
    close = (np.abs(depth) < (NEAR + 1.0) * cell) & ~of_block
    picked = []
    for rows, count in ((np.flatnonzero(close), near), (np.flatnonzero(~close), far)):
        picked.append(rng.permutation(rows)[:count])
    return every[np.concatenate(picked)]


def _all_nodes(remains: Remains) -> Floats:
    cell = float(remains.field.frame[CELL])
    low, high = np.array(BLOCK) * 1e-3
    axes = []
    for a in range(3):
        first = remains.field.frame[a]
        k = np.arange(np.ceil((low[a] - first) / cell), np.floor((high[a] - first) / cell) + 1)
        axes.append(first + k * cell)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


@dataclass(frozen=True)
class WrongNodes:
    """``near``: nodes within NEAR cells of a cut; ``wrong`` of all; ``worst``: m that a wrong one is away from it."""

    near: int
    wrong: int
    worst: float


def wrong_nodes(remains: Remains, places: Floats, sweeps: list[oracle.Sweep]) -> WrongNodes:
    """Compare places (P, 3) m: in the material, by the field and by every sweep."""
    low, high = np.array(BLOCK) * 1e-3
    told = remains.depth(places)
    block = oracle.box(low, high)(places)
    uncut = oracle.outside_all(sweeps, places)
    known = np.maximum(block, -uncut)
    bad = (told > 0) != (known > 0)
    bad &= (np.abs(told) > SURE) & (np.abs(known) > SURE)
    near = np.abs(uncut) < NEAR * float(remains.field.frame[CELL])
    away = np.minimum(np.abs(told), np.abs(known))[bad]
    return WrongNodes(int(near.sum()), int(bad.sum()), float(away.max(initial=0.0)))
