"""Walking the joint memory along a path, and reading CAM files."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.job import write_inputs
from benchmarks.rig import Floats
from benchmarks.table import Row
from benchmarks.timing import interleaved, ratio
from stiffness.effects.backlash import EFFECT as BACKLASH
from stiffness.memory.preload import PreloadState, walk
from toolpaths.files import read_toolpath

GAP = {"gap_rad": np.full(6, 1e-4), "breakaway_nm": np.full(6, 20.0), "side": np.ones(6)}
START = PreloadState(np.full(6, -5e-5), np.full(6, 5e-5))


def walked(move: Floats, torque: Floats) -> PreloadState:
    """The product: the state of six joints with a gap at every pose."""
    return walk((BACKLASH,), {BACKLASH.name: GAP}, move, torque, START)


def naive_walk(move: Floats, torque: Floats) -> tuple[Floats, Floats]:
    """The same play operator pose after pose: lowest and highest state."""
    half, breakaway = GAP["gap_rad"] / 2, GAP["breakaway_nm"]
    low, high = START.low, START.high
    lows, highs = np.empty_like(move), np.empty_like(move)
    for k in range(len(move)):
        held = np.abs(torque[k]) > breakaway
        side = np.sign(torque[k]) * half
        floor, ceiling = np.where(held, side, -half), np.where(held, side, half)
        low = np.minimum(np.maximum(low + move[k], floor), ceiling)
        high = np.minimum(np.maximum(high + move[k], floor), ceiling)
        lows[k], highs[k] = low, high
    return lows, highs


def moves(count: int) -> tuple[Floats, Floats]:
    """Moves that turn around now and then, and torques that hold a flank now and then."""
    t = np.arange(count)[:, None] * np.array([1.0, 0.83, 0.71, 0.57, 0.43, 0.31])
    return 2e-5 * np.sin(0.02 * t), 100.0 * np.sin(0.003 * t)


def write_gcode(file: Path, count: int) -> None:
    """Feed moves on a wave, half a millimetre each, as a post-processor writes them."""
    x = 0.5 * np.arange(count)
    rows = [f"N{k + 2} G1 X{v:.3f} Y{10 * np.sin(v / 20):.3f} Z{np.cos(v / 30):.3f}" for k, v in enumerate(x)]
    file.write_text("\n".join(["N1 G21 G90 G54 G17", "N2 F1200.", *rows, "M30", ""]))


def run(many: int = 200_000, few: int = 2000, rounds: int = 5) -> Iterator[Row]:
    """Nanoseconds per pose, moves per second."""
    group = "along the path"
    move, torque = moves(many)
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        folder = Path(name)
        write_inputs(folder, many)
        write_gcode(folder / "path.nc", many)
        tasks = {
            "walk": lambda: walked(move, torque),
            "row by row": lambda: naive_walk(move[:few], torque[:few]),
            "csv": lambda: read_toolpath(folder / "path.csv", chord=1e-5),
            "gcode": lambda: read_toolpath(folder / "path.nc", chord=1e-5),
            "lines": lambda: (folder / "path.nc").read_text().splitlines(),
        }
        seconds = interleaved(tasks, rounds)
    yield Row(group, "backlash of 6 joints", statistics.median(seconds["walk"]) / many * 1e9, "ns/pose")
    yield Row(group, "  against row by row in numpy", ratio(seconds["row by row"], seconds["walk"]) * many / few, "x")
    yield Row(group, "csv", many / statistics.median(seconds["csv"]), "poses/s")
    yield Row(group, "G-code", many / statistics.median(seconds["gcode"]), "moves/s")
    yield Row(group, f"G-code of {many:,} moves", statistics.median(seconds["gcode"]), "s", "seconds")
