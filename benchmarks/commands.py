"""The whole command in a process of its own, against reading and writing the same text."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.job import write_inputs
from benchmarks.table import Row
from benchmarks.timing import cores, family_mb, hashing, ratio

ROUNDS = 3
LARGE = 1_000_000
CORES_AT = 100_000  # poses
HASHED_MB = 400


LOOK = 1.0  # s between two looks at the memory of all processes of a job; each takes a hundredth of a second


@dataclass(frozen=True)
class Run:
    """One job.

    Attributes:
        seconds: from the shell, with the start of Python. processor: s of all its processes.
        poses: made.
        peak_mb: of memory: the most of its first process, or of all together, what they share counted once.
    """

    seconds: float
    processor: float
    poses: int
    peak_mb: float


def run_job(job: str, folder: Path) -> Run:
    """One job of ``benchmarks.job``."""
    began = time.perf_counter()
    command = [sys.executable, "-m", "benchmarks.job", job, str(folder)]
    together, before = 0.0, _processor()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[1]) as process:
        while True:
            try:
                told, _ = process.communicate(timeout=LOOK)
                break
            except subprocess.TimeoutExpired:
                together = max(together, family_mb(process.pid))
    seconds = time.perf_counter() - began
    if process.returncode:
        raise SystemExit(f"benchmarks.job {job} failed")
    figures = json.loads(told)
    return Run(seconds, _processor() - before, figures["poses"], max(figures["peak_mb"], together))


def _processor() -> float:
    """s of all processes that have ended below this one."""
    spent = os.times()
    return spent.children_user + spent.children_system


def run(sizes: Sequence[int] = (10_000, 100_000), rounds: int = ROUNDS) -> Iterator[Row]:
    """CSV in and RAPID out, without and with joint memory."""
    for memory in (False, True):
        group = "compensate, csv to RAPID, from the shell" + (" (backlash and preload)" if memory else "")
        medians: dict[int, float] = {}
        for poses in sizes:
            text, whole = measured(poses, rounds if poses < LARGE else 1, memory=memory)
            medians[poses] = statistics.median(r.seconds for r in whole)
            name = f"{poses:,} poses"
            yield Row(group, name, medians[poses], "s")
            against = ratio([r.seconds for r in whole], [r.seconds for r in text])
            goal = f"{5 if memory else 2} at 1,000,000" if poses == LARGE else ""
            yield Row(group, "  against reading and writing the text", against, "x", goal)
            against = ratio([r.processor for r in whole], [r.processor for r in text])
            yield Row(group, "  the same of processor time, all processes", against, "x")
            peak = max(r.peak_mb for r in whole)
            yield Row(group, "  peak memory", peak, "MB", "1000 at 1,000,000" if poses == LARGE else "")
        yield from on_all_cores(group, min(sizes[-1], CORES_AT), rounds, memory=memory)
        first, last = sizes[0], sizes[-1]
        if last > first:
            goal = "110" if (first, last) == (10_000, LARGE) else ""
            yield Row(group, f"growth {first:,} to {last:,}", medians[last] / medians[first], "x", goal)


def on_all_cores(group: str, poses: int, rounds: int, *, memory: bool) -> Iterator[Row]:
    """What all cores bring, and what they bring to plain hashing at the same moment."""
    seconds: dict[str, list[float]] = {"one": [], "all": [], "hash one": [], "hash all": []}
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if count == 1:
        return
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        write_inputs(Path(name), poses, memory=memory)
        for _ in range(rounds):
            for what, some in (("one", 1), ("all", count)):
                with cores(some):
                    seconds[what].append(run_job("compensate", Path(name)).seconds)
                began = time.perf_counter()
                hashing(some, HASHED_MB)
                seconds[f"hash {what}"].append(time.perf_counter() - began)
    yield Row(group, f"  one core against {count}, {poses:,} poses", ratio(seconds["one"], seconds["all"]), "x")
    yield Row(group, f"  plain hashing, one core against {count}", ratio(seconds["hash one"], seconds["hash all"]), "x")


def run_filter(sizes: Sequence[int] = (100_000,)) -> Iterator[Row]:
    """A RAPID program in modules of 5,000 moves, filtered in place, without and with joint memory."""
    for memory in (False, True):
        group = "a RAPID program filtered in place, from the shell" + (" (backlash and preload)" if memory else "")
        for moves in sizes:
            with tempfile.TemporaryDirectory(prefix="bench-") as name:
                write_inputs(Path(name), moves, memory=memory)
                run_job("program", Path(name))
                text, whole = run_job("text", Path(name)), run_job("filter", Path(name))
            yield Row(group, f"{moves:,} moves", whole.seconds, "s")
            against = ratio([whole.seconds], [text.seconds])
            yield Row(group, "  against reading a csv and writing RAPID of as many", against, "x")
            yield Row(group, "  peak memory", whole.peak_mb, "MB", "1000" if moves == LARGE else "")


def measured(poses: int, rounds: int, *, memory: bool) -> tuple[list[Run], list[Run]]:
    """Runs of the text alone and of the whole command, in turn."""
    text, whole = [], []
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        folder = Path(name)
        write_inputs(folder, poses, memory=memory)
        for _ in range(rounds):
            text.append(run_job("text", folder))
            whole.append(run_job("compensate", folder))
    return text, whole
