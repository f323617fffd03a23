"""python -m tests.effects_report [--quick] [--arms ...] [--size ...] [--only TEXT] [--out FILE]"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import pickle
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from tests.effects_report.case import Flow, Row, Task, run
from tests.effects_report.judge import misses
from tests.effects_report.table import TARGET, markdown
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS

SIZES = (3.0, 1.5, 6.0)
QUICK: tuple[tuple[str, str, Flow], ...] = (  # for CI; tests/stiffness/diagnosis/test_diagnose.py: flow a
    ("abb-irb6600-175-255", "payload", "a"),
    ("ur10", "clean", "b"),
    ("kuka-kr210-r2700", "base-compliance", "b"),
    ("ur10", "tracker-drift", "c"),
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what was asked for and print or write the table."""
    asked = _parser().parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        tasks = _tasks(asked, Path(asked.keep or folder))
        rows = _run(tasks, asked.processes, Path(asked.rows) if asked.rows else None)
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
    parser.add_argument("--flow", nargs="+", choices=("a", "b", "c"), default=("a", "b", "c"), help="of the model")
    parser.add_argument("--blind", action="store_true", help="sessions without approach columns")
    parser.add_argument("--only", default="", help="scenarios that contain this text")
    parser.add_argument("--clean", type=int, default=5, help="clean sessions per arm, at the size that has a target")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--keep", help="folder that keeps sessions and reads those that are there")
    parser.add_argument("--rows", help="file that rows are added to; those that are there are not run again")
    parser.add_argument("--out", help="file to write; default: print")
    return parser


def _tasks(asked: argparse.Namespace, keep: Path) -> list[Task]:
    if asked.quick:
        return [Task(arm, name, asked.seed, TARGET, keep, flow) for arm, name, flow in QUICK if asked.only in name]
    out = []
    for size, flow, arm in product(asked.size, asked.flow, asked.arms):
        for name in (n for n in SCENARIOS if asked.only in n):
            seeds = [asked.seed]
            if name == "clean":
                seeds = [asked.seed + k for k in range(asked.clean)] if size == TARGET else []
            out += [Task(arm, name, seed, size, keep, flow, not asked.blind) for seed in seeds]
    return out


def _run(tasks: list[Task], processes: int, kept: Path | None) -> list[Row]:
    """Rows in the order of tasks, whoever is ready first."""
    rows, begun = _kept(kept), time.perf_counter()
    missing = [t for t in tasks if _key(t) not in rows]
    with multiprocessing.get_context("spawn").Pool(processes, maxtasksperchild=20) as pool:
        for k, row in enumerate(pool.imap(run, missing), 1):
            rows[_key(row)] = row
            if kept:
                with kept.open("ab") as file:
                    pickle.dump(row, file)
            wrong = "; ".join(misses(row)) or "met"
            said = f"{row.arm} {row.scenario} {row.size:g} {row.flow}: {row.verdict}, {wrong} ({row.seconds:.0f} s)"
            print(f"{k}/{len(missing)} {said}", file=sys.stderr, flush=True)
    print(f"{time.perf_counter() - begun:.0f} s for {len(missing)} cases", file=sys.stderr)
    return [rows[_key(t)] for t in tasks]


def _key(of: Task | Row) -> tuple[str, str, int, float, str, bool]:
    return of.arm, of.scenario, of.seed, of.size, of.flow, of.approach


def _kept(file: Path | None) -> dict[tuple[str, str, int, float, str, bool], Row]:
    """Rows of an earlier run."""
    rows = list[Row]()
    if file and file.exists():
        with file.open("rb") as stream:
            while stream.peek(1):
                rows.append(pickle.load(stream))
    return {_key(r): r for r in rows}


if __name__ == "__main__":
    main()
