"""A milled path as a command of its own: ``python -m benchmarks.milled POSES [--backlash]`` prints its peak memory.

The stock is a block of a few bricks of its grid, whatever the number of poses. Prints JSON.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line has it

import numpy as np

from benchmarks.job import CELL, MEMORY, SPRINGS
from benchmarks.timing import peak_mb

LANE = 200  # poses, half a millimetre apart
PROCESS = """[process]
kind = "milling"
material = "own.toml"
spindle_rpm = 9000.0
spindle = "m3"
cutter = { shape = "flat", diameter = 12.0, flutes = 3, length = 30.0 }
[process.stock]
box = [[0.0, 0.0, -30.0], [100.0, 40.0, 0.0]]
grid = 3.0
"""
MATERIAL = """schema = "material/1"
name = "own"
source = "a test"
sign = "as measured"
[coefficients]
ktc = 700.0
krc = 150.0
kac = 200.0
kte = 20.0
kre = 20.0
kae = 1.0
[sd]
ktc = 70.0
"""


def write_job(folder: Path, poses: int, *, memory: bool) -> None:
    """Lanes to and fro over a block, a layer of 0.05 mm every ten of them."""
    begin, end = CELL.index("[process]"), CELL.index("[solve]")
    (folder / "cell.toml").write_text(CELL[:begin] + PROCESS + CELL[end:])
    (folder / "model.toml").write_text(MEMORY if memory else SPRINGS)
    (folder / "own.toml").write_text(MATERIAL)
    along, lane = np.arange(poses) % LANE, np.arange(poses) // LANE
    x = 0.5 * np.where(lane % 2, LANE - 1 - along, along)
    up = np.broadcast_to([0.0, 0.0, 1.0], (poses, 3))
    table = np.column_stack([x, 4.0 * (lane % 10), -1.0 - 0.05 * (lane // 10), up, np.full(poses, 1800.0)])
    header = "x_mm,y_mm,z_mm,i,j,k,feed_mm_min"
    np.savetxt(folder / "path.csv", table, fmt="%.5f", delimiter=",", header=header, comments="")


def run(folder: Path) -> int:
    """The whole command, the cut as csv with it; gives the number of poses."""
    from compensator.tasks.compensate import compensate_file

    done = compensate_file(
        folder / "path.csv", folder / "cell.toml", folder / "out.mod", engagement=folder / "cut.csv"
    )
    return len(done.result)


def main() -> None:
    """Mill, and print the figures."""
    given = sys.argv[1:]
    if not given or not given[0].isdecimal() or given[1:] not in ([], ["--backlash"]):
        raise SystemExit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        write_job(Path(name), int(given[0]), memory=bool(given[1:]))
        poses = run(Path(name))
    print(json.dumps({"poses": poses, "peak_mb": peak_mb()}))


if __name__ == "__main__":
    main()
