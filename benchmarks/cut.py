"""Cutting a stock along a path: seconds, memory and growth of the engine, ratios to a voxel loop and to booleans."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from benchmarks.table import Row
from benchmarks.timing import peak_mb
from compensator.process.milling.cutter import Cutter
from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stock import Stock, box_stock

Floats = npt.NDArray[np.float64]
T = TypeVar("T")

COEFFICIENTS = np.array([796e6, 168e6, 222e6, 27.7e3, 30.8e3, 1.4e3])
CELL = 1e-3
MOVE = 9e-3  # m: 20,000 of them are 180 m
SAMPLES = 10  # poses in a move, where it is cut in pieces
FLAT = Cutter("flat", 0.020, 4, 0.030, helix=np.radians(30))
BALL = Cutter("ball", 0.012, 2, 0.030, helix=np.radians(30))
SIZE = np.array([0.3, 0.3, 0.1])
ROUNDS = 3


def stock() -> Stock:
    """300 x 300 x 100 mm, its top at 0."""
    return box_stock(np.array([0.0, 0.0, -SIZE[2]]), np.array([SIZE[0], SIZE[1], 0.0]))


def roughing(moves: int) -> MillingPath:
    """Lanes to and fro, 8 mm apart and 6 mm deep, of slightly bent moves of 9 mm in ten pieces each."""
    ends = _lanes(moves + 1, step=MOVE, over=8e-3, down=6e-3)
    ends[:, 1] += 4e-4 * np.sin(2.1 * np.arange(len(ends)))
    share = np.linspace(0, 1, SAMPLES + 1)[1:, None]
    inner = ends[:-1, None] + share[None] * np.diff(ends, axis=0)[:, None]
    points = np.concatenate([ends[:1], inner.reshape(-1, 3)])
    return _path(points, np.broadcast_to([0.0, 0.0, 1.0], points.shape), FLAT)


def finishing(moves: int) -> MillingPath:
    """Lanes over a wavy surface with a ball, 0.6 mm apart; the axis leans with the surface, and turns in every move."""
    points = _lanes(moves + 1, step=2e-3, over=6e-4, down=0.0)
    x, y = points[:, 0] / 0.05, points[:, 1] / 0.06
    points[:, 2] = -4e-3 + 2e-3 * np.sin(x) * np.cos(y)
    axis = np.column_stack([-0.2 * np.cos(x) * np.cos(y), 0.25 * np.sin(y), np.ones(len(x))])
    return _path(points, axis / np.linalg.norm(axis, axis=1, keepdims=True), BALL)


def _lanes(count: int, *, step: float, over: float, down: float) -> Floats:
    """(count, 3) points of lanes along x that go up and down the block, layer by layer."""
    along = round(SIZE[0] / step)
    lanes = int(SIZE[1] / over)
    k = np.arange(count)
    lane, at = k // (along + 1), k % (along + 1)
    x = np.where(lane % 2 == 0, at, along - at) * step
    layer, inside = lane // lanes, lane % lanes
    y = np.where(layer % 2 == 0, inside, lanes - 1 - inside) * over + over / 2
    return np.column_stack([x, y, -down * (layer + 1)])


def _path(points: Floats, axis: Floats, cutter: Cutter) -> MillingPath:
    n = len(points)
    return MillingPath(
        points, np.array(axis), feed=np.full(n, 0.04), spindle=np.full(n, 200.0), sense=np.ones(n, dtype=np.int8),
        rapid=np.zeros(n, dtype=bool), cutter=np.zeros(n, dtype=np.int32), cutters=(cutter,),
    )  # fmt: skip


def cut(path: MillingPath) -> tuple[Cut, float]:
    """The cut and its seconds of processor time."""
    begin = time.process_time()
    done = mill(path, stock(), COEFFICIENTS, cell=CELL)
    return done, time.process_time() - begin


def run(moves: int = 20_000, few: int = 200) -> Iterator[Row]:
    """Roughing, finishing, growth, and the ratios; about two minutes of processor time, the compiler's included."""
    cut(roughing(20)), cut(finishing(20))  # compile
    large = alone("roughing", moves)
    metres, seconds = large["metres"], large["seconds"]
    what = f"roughing, {moves:,} moves, {large['poses']:,.0f} poses, {metres:.0f} m"
    yield Row("cut", what, seconds, "s", "45 s of one core" if moves == 20_000 else "")
    yield Row("cut", f"{what}, memory", large["peak_mb"], "MB", "400 MB" if moves == 20_000 else "")
    five = alone("finishing", moves)
    what = f"finishing in 5 axes, {moves:,} moves"
    yield Row("cut", what, five["seconds"], "s", "60 s of one core" if moves == 20_000 else "")
    path = roughing(few)
    product = min(cut(path)[1] for _ in range(ROUNDS))
    sizes = f"{few * SAMPLES:,} to {moves * SAMPLES:,} poses"
    yield Row("cut", f"seconds per pose, {sizes}", seconds / moves / (product / few), "x", "1.3x")
    yield Row("cut", f"a voxel loop in numpy against the engine, {few} moves", _seconds(voxels, path) / product, "x")
    ends = path.position[::SAMPLES]
    yield Row("cut", f"manifold3d against the engine, {few} moves", _seconds(booleans, ends) / product, "x")


def _seconds(task: Callable[[T], object], argument: T) -> float:
    begin = time.process_time()
    task(argument)
    return time.process_time() - begin


def alone(name: str, moves: int) -> dict[str, float]:
    """What ``print_figures`` prints in a process of its own."""
    code = f"from benchmarks import cut; cut.print_figures(cut.{name}({moves}))"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


def print_figures(path: MillingPath) -> None:
    """Seconds of processor time, poses, length, and the most memory that this process had."""
    cut(_path(path.position[:30], path.axis[:30], path.cutters[0]))  # the machine code is loaded
    done, seconds = cut(path)
    metres = float(np.linalg.norm(done.path.way, axis=1).sum())
    print(json.dumps({"seconds": seconds, "poses": len(done), "metres": metres, "peak_mb": peak_mb()}))


def voxels(path: MillingPath) -> float:
    """What one would write first: a block of booleans, the cutter's disc put in pose by pose, the material in front of
    it counted. It gives a volume and no angle; the volume, m3."""
    count = np.round(SIZE / CELL).astype(int)
    full = np.ones(count, dtype=bool)
    x, y, z = (np.arange(n) * CELL + 0.5 * CELL for n in count)
    z -= SIZE[2]
    gone = 0
    for p in path.position:
        i = slice(*np.searchsorted(x, [p[0] - FLAT.radius, p[0] + FLAT.radius]))
        j = slice(*np.searchsorted(y, [p[1] - FLAT.radius, p[1] + FLAT.radius]))
        k = slice(np.searchsorted(z, p[2]), None)
        disc = (x[i, None] - p[0]) ** 2 + (y[None, j] - p[1]) ** 2 < FLAT.radius**2
        there = full[i, j, k] & disc[:, :, None]
        gone += int(there.sum())
        full[i, j, k] &= ~there
    return gone * CELL**3


def booleans(ends: Floats) -> float:
    """The same by exact booleans, a move at a time: the hull of the cutter at both of its ends; the volume, m3."""
    from manifold3d import Manifold

    left = Manifold.cube(tuple(SIZE * 1e3)).translate((0.0, 0.0, -SIZE[2] * 1e3))
    body = Manifold.cylinder(FLAT.length * 1e3, FLAT.radius * 1e3, circular_segments=64)
    before = left.volume()
    for a, b in zip(ends[:-1] * 1e3, ends[1:] * 1e3, strict=True):
        left -= Manifold.batch_hull([body.translate(tuple(a)), body.translate(tuple(b))])
        left.num_tri()  # evaluated now, as an engagement in between would need
    return (before - left.volume()) * 1e-9
