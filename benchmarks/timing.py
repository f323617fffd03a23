"""Times that can be compared on a shared machine: rounds of everything in turn, and medians."""

from __future__ import annotations

import hashlib
import os
import resource
import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

Task = Callable[[], object]


def interleaved(tasks: Mapping[str, Task], rounds: int) -> dict[str, list[float]]:
    """Seconds of every task, one list entry per round; in every round each task runs once."""
    for task in tasks.values():
        task()  # build kernels, fill caches
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(rounds):
        for name, task in tasks.items():
            start = time.perf_counter()
            task()
            seconds[name].append(time.perf_counter() - start)
    return seconds


def ratio(slow: list[float], fast: list[float]) -> float:
    """Median over the rounds of slow / fast, both taken from the same round."""
    return statistics.median(a / b for a, b in zip(slow, fast, strict=True))


@contextmanager
def cores(count: int) -> Iterator[int]:
    """Run on so many cores, where the system lets a process choose; gives the number that it got."""
    if not hasattr(os, "sched_setaffinity"):
        yield os.cpu_count() or 1
        return
    before = os.sched_getaffinity(0)
    some = set(sorted(before)[:count])
    os.sched_setaffinity(0, some)
    try:
        yield len(some)
    finally:
        os.sched_setaffinity(0, before)


def on_cores(count: int, task: Task) -> Task:
    """The task, run on so many cores."""

    def run() -> object:
        with cores(count):
            return task()

    return run


def hashing(threads: int, megabytes: int = 40) -> None:
    """Work that two free cores do in half the time of one: what the machine has to give at the moment."""
    each = bytes(megabytes * 1_000_000 // threads)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda data: hashlib.sha256(data).digest(), [each] * threads))


def peak_mb() -> float:
    """The most memory of this process. Not getrusage on Linux: a child begins with the peak of its parent there."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(x for x in status.read_text().splitlines() if x.startswith("VmHWM"))
        return float(line.split()[1]) / 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6  # bytes on a Mac


def family_mb(process: int) -> float:
    """Memory of a process and its children, what they share counted once; 0 where the system does not tell."""
    total = 0.0
    for one in (process, *_children(process)):
        try:
            lines = Path(f"/proc/{one}/smaps_rollup").read_text().splitlines()
        except OSError:  # over by now, or not Linux
            continue
        total += sum(float(x.split()[1]) for x in lines if x.startswith(("Pss:", "SwapPss:")))
    return total / 1e3


def _children(process: int) -> list[int]:
    try:
        return [int(word) for word in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    except OSError:
        return []
