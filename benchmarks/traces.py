"""Seconds to diagnose a ball-bar trace of 2,000 samples, against one evaluation of it.

The trace is what the product itself previews for an arm with a gap, with noise: what a diagnosis finds is a matter of
the tests.
"""

from __future__ import annotations

import csv
import statistics
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.table import Row
from benchmarks.timing import interleaved, on_cores
from compensator.tasks.compensate import preview_file
from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import evaluate_file

SAMPLES = 2_000
ROUNDS = 1
GOAL = "under 60 s"
NOISE = 0.005  # mm
RADIUS = 150.0  # mm
CENTRE = (1500.0, 0.0, 900.0)  # mm
STIFFNESS = "k_nm_per_rad = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]"
GAP = "gap_rad = [1.2e-4, 0, 0, 0, 0, 0]\nbreakaway_nm = [5000, 1, 1, 1, 1, 1]\nside = [1, 1, 1, 1, 1, 1]"
CELL = f"""schema = "cell/1"
robot = "abb-irb6600-175-255"
model = "MODEL"
workobject = {{ xyz = {list(CENTRE)}, rpy = [0, 0, 0] }}
tool = {{ xyz = [40, -10, 220], rpy = [0, 30, 0], mass = 35.0, com = [20, 5, 110] }}
start = {{ joints = [0, 10, 20, 0, 60, 0] }}
process = {{ kind = "constant", frame = "path", wrench = [0, 400, -100, 0, 0, 0] }}
"""
TRACE = f"""schema = "trace/1"
cell = "cell.toml"
program = "run.csv"
samples = "samples.csv"
kind = "ballbar"
instrument = {{ noise = {NOISE} }}
ballbar = {{ center = {list(CENTRE)}, radius = {RADIUS} }}
"""


def run(samples: int = SAMPLES, rounds: int = ROUNDS) -> Iterator[Row]:
    """Circles in two planes, both directions; nothing wrong, and a gap in joint 1."""
    group = f"traces (abb-irb6600-175-255; a ball-bar of {samples:,} samples; two cores)"
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        cases = {what: _trace(Path(name) / str(k), samples, gap) for k, (what, gap) in enumerate(_CASES.items())}
        tasks = {
            what: on_cores(2, lambda t=trace: diagnose_files([t], t.with_name("model.toml")))  # type: ignore[misc]
            for what, trace in cases.items()
        }
        one = cases["nothing wrong"]
        tasks["evaluated"] = on_cores(2, lambda: evaluate_file(one, one.with_name("model.toml")))
        times = interleaved(tasks, rounds)
    base = statistics.median(times["evaluated"])
    for what in cases:
        seconds = statistics.median(times[what])
        yield Row(group, what, seconds, "s", GOAL)
        yield Row(group, f"{what}, against one evaluation of the trace", seconds / base, "x", "")


_CASES = {"nothing wrong": False, "a gap in joint 1": True}


def _trace(folder: Path, samples: int, gap: bool) -> Path:
    folder.mkdir()
    plain = f'schema = "model/1"\nrobot = "abb-irb6600-175-255"\n[effects.joint-stiffness]\n{STIFFNESS}\n'
    (folder / "model.toml").write_text(plain)
    (folder / "ill.toml").write_text(plain + (f"[effects.backlash]\n{GAP}\n" if gap else ""))
    (folder / "cell.toml").write_text(CELL.replace("MODEL", "ill.toml"))
    with (folder / "path.csv").open("w", newline="") as stream:
        out = csv.writer(stream)
        out.writerow(["x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind"])
        for place, kind in _circles(samples // 4):
            out.writerow([*place, 0, 0, 1, 1000.0, kind])
    preview_file(folder / "path.csv", folder / "cell.toml", csv=folder / "run.csv")
    rows = list(csv.DictReader((folder / "run.csv").read_text().splitlines()))
    at = np.array([[float(r[a]) + float(r[d]) for a, d in zip(PLACE, MOVED, strict=True)] for r in rows])
    radius = np.linalg.norm(at, axis=1) + np.random.default_rng(1).normal(0, NOISE, len(at))
    lines = [f"{k},{value:.6f}" for k, value in enumerate(radius)]
    (folder / "samples.csv").write_text("\n".join(["index,radius", *lines]) + "\n")
    (folder / "cell.toml").write_text(CELL.replace("MODEL", "model.toml"))
    (folder / "trace.toml").write_text(TRACE)
    return folder / "trace.toml"


PLACE, MOVED = ("x_mm", "y_mm", "z_mm"), ("dx_mm", "dy_mm", "dz_mm")


def _circles(points: int) -> Iterator[tuple[list[float], str]]:
    """(x, y, z) mm about the work object, and rapid or cut."""
    angle, first = np.linspace(0, 2 * np.pi, points), True
    for upright in (False, True):
        for way in (1, -1):
            for a in way * angle:
                x, y = RADIUS * np.cos(a), RADIUS * np.sin(a)
                yield [x, 0.0, y] if upright else [x, y, 0.0], "rapid" if first else "cut"
                first = False
