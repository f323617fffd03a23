"""How long the shell waits: bare Python, click, --help, and preview of a short path."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.job import write_inputs
from benchmarks.table import Row
from benchmarks.timing import interleaved, ratio

POSES = 1000
_CLI = "from compensator.cli import main; main()"


def run(rounds: int = 9, poses: int = POSES) -> Iterator[Row]:
    """Medians over rounds of all in turn."""
    group = "from the shell, start of Python included"
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        folder = Path(name)
        write_inputs(folder, poses)
        preview = ["preview", str(folder / "path.csv"), "--cell", str(folder / "cell.toml")]
        tasks = {
            "python -c pass": lambda: shell("pass"),
            "import click": lambda: shell("import click"),
            "compensator --help": lambda: shell(_CLI, ["--help"]),
            f"preview of {poses:,} poses": lambda: shell(_CLI, preview),
        }
        seconds = interleaved(tasks, rounds)
    for what, times in seconds.items():
        goal = "under 3 s" if what.startswith("preview") else ""
        yield Row(group, what, statistics.median(times), "s", goal)
    bare = seconds["python -c pass"]
    yield Row(group, "--help against python -c pass", ratio(seconds["compensator --help"], bare), "x", "4")
    yield Row(group, "click alone against python -c pass", ratio(seconds["import click"], bare), "x")


def shell(code: str, arguments: Sequence[str] = ()) -> float:
    """Seconds of one Python process; its output is thrown away, its failure is not."""
    began = time.perf_counter()
    command = [sys.executable, "-c", code, *arguments]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True, cwd=Path(__file__).parents[1])
    return time.perf_counter() - began
