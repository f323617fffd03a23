"""python -m tests.effects_report [--quick] [--arms ...] [--size ...] [--only TEXT] [--out FILE]"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests.effects_report.case import Row, Task, run
from tests.effects_report.judge import misses
from tests.effects_report.table import TARGET, markdown
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS

SIZES = (3.0, 1.5, 6.0)
QUICK = (  # one of every kind, for CI
    ("ur10", "clean"),
    ("ur10", "backlash joint-1"),
    ("kuka-kr210-r2700", "base-compliance"),
    ("ur10", "tracker-drift"),
    ("ur10", "preload-softening joint-3 + payload"),
    ("ur10", "unknown brake"),
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what was asked for and print or write the table."""
    asked = _parser().parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        tasks = _tasks(asked, Path(asked.keep or folder))
        rows = _run(tasks, asked.processes)
    text = markdown(rows)
    if asked.out:
        Path(asked.out).write_text(text, encoding="utf-8")
    else:
        print(text)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.effects_report", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a few cases at the size that has a target")
    parser.add_argument("--arms", nargs="+", choices=tuple(CELLS), default=tuple(CELLS))
    parser.add_argument("--size", nargs="+", type=float, default=SIZES, help="noise floors that an effect leaves")
    parser.add_argument("--only", default="", help="scenarios that contain this text")
    parser.add_argument("--clean", type=int, default=5, help="clean sessions per arm, at the size that has a target")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--keep", help="folder that keeps sessions and reads those that are there")
    parser.add_argument("--out", help="file to write; default: print")
    return parser


def _tasks(asked: argparse.Namespace, keep: Path) -> list[Task]:
    if asked.quick:
        return [Task(arm, name, asked.seed, TARGET, keep) for arm, name in QUICK if asked.only in name]
    out = []
    for size in asked.size:
        for arm in asked.arms:
            for name in (n for n in SCENARIOS if asked.only in n):
                seeds = [asked.seed]
                if name == "clean":
                    seeds = [asked.seed + k for k in range(asked.clean)] if size == TARGET else []
                out += [Task(arm, name, seed, size, keep) for seed in seeds]
    return out


def _run(tasks: list[Task], processes: int) -> list[Row]:
    """Rows in the order of tasks, whoever is ready first."""
    rows, begun = [], time.perf_counter()
    with multiprocessing.get_context("spawn").Pool(processes, maxtasksperchild=20) as pool:
        for k, row in enumerate(pool.imap(run, tasks), 1):
            rows.append(row)
            wrong = "; ".join(misses(row)) or "met"
            print(
                f"{k}/{len(tasks)} {row.arm} {row.scenario} {row.size:g}: {row.verdict}, {wrong} ({row.seconds:.0f} s)",
                file=sys.stderr, flush=True,
            )  # fmt: skip
    print(f"{time.perf_counter() - begun:.0f} s for {len(tasks)} cases", file=sys.stderr)
    return rows


if __name__ == "__main__":
    main()
