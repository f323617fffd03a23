"""Collisions and placements: looks and postures per second, and what a placement costs, as slopes over its poses."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.table import Row
from benchmarks.timing import hashing, interleaved, ratio
from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.place.candidates import box
from compensator.place.judge import Judge
from compensator.place.postures import placed_postures
from compensator.place.study import Study, study_of
from compensator.place.workers import here, on_processes, packed
from compensator.scene.path_collisions import collider_of, collisions_along
from compensator.solve.planned import planned, sampled
from compensator.tasks.compensate import files_of, read_input

EXAMPLES = Path(__file__).parents[1] / "examples"
ROUNDS = 5
FIXTURE = """
[[scene]]
name = "fixture"
box = [[-40.0, -40.0, -200.0], [250.0, 200.0, -40.0]]
frame = "workobject"
"""


def run() -> Iterator[Row]:
    """The rows."""
    with tempfile.TemporaryDirectory() as folder:
        cell = _cell(Path(folder))
        given = read_input(files_of([EXAMPLES / "wave.nc"], None), cell)
        yield from _collisions(given)
        arm, path = load_arm(load_cell(cell)), sampled(given.job.placement, given.path)

        def study(poses: int, words: str = "x=1300:1700:5,y=-300:300:4") -> Study:
            candidates = box(words, load_cell(cell).workobject)
            return study_of(arm, given.job, path, candidates, turns=12, poses=poses, inputs={})

        yield from _placements(study)


def _cell(folder: Path) -> Path:
    text = (EXAMPLES / "cell.toml").read_text(encoding="utf-8")
    begin, end = text.index("[process]"), text.index("[program]")
    process = '[process]\nkind = "constant"\nframe = "path"\nwrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]\n\n'
    text = text[:begin] + process + text[end:] + FIXTURE
    text = text.replace('"stiffness.toml"', f'"{EXAMPLES / "stiffness.toml"}"')
    path = folder / "cell.toml"
    path.write_text(text, encoding="utf-8")
    return path


def _collisions(given) -> Iterator[Row]:  # type: ignore[no-untyped-def]
    job, group = given.job, "collisions"
    plan = planned(job, given.path)
    found = collisions_along(job, plan.toolpath, plan.q)
    collider = collider_of(job)
    work = job.placement.workobject
    some = plan.q[:: max(len(plan.q) // 500, 1)]
    seconds = interleaved(
        {
            "plan": lambda: planned(job, given.path),
            "walk": lambda: collisions_along(job, plan.toolpath, plan.q),
            "all": lambda: collider.collides(some, workobject=work),
            "each": lambda: [collider.collides(q[None], workobject=work) for q in some[::10]],
        },
        ROUNDS,
    )
    looks = sum(a.looks for a in found.approaches)
    yield Row(group, f"looks per pose and pair, {len(plan.q):,} poses", looks / len(found.approaches) / len(plan.q), "")
    yield Row(group, "collisions along the path over following it", ratio(seconds["walk"], seconds["plan"]), "x")
    rate = len(some) / np.median(seconds["all"])
    yield Row(group, "postures per second, all pairs", rate, "1/s")
    each = [10 * e for e in seconds["each"]]
    yield Row(group, "postures one by one over all at once", ratio(each, seconds["all"]), "x")


def _placements(study) -> Iterator[Row]:  # type: ignore[no-untyped-def]
    group, costs = "place: one placement, 12 turns x 8 configurations", {}
    for poses in (100, 200, 400, 800):
        judge = Judge(study(poses))
        judge.row(0)
        work = judge.study.candidates.frame(7)
        planner = judge.job.planner
        begin = time.process_time()
        for k in range(4, 12):
            judge.row(k)
        costs[poses] = (time.process_time() - begin) / 8
        begin = time.process_time()
        for _ in range(4):
            placed_postures(judge.study, planner.inverse, planner.bounds, work)
        yield Row(group, f"{poses} poses: whole", costs[poses] * 1e3, "ms")
        yield Row(group, f"{poses} poses: inverse kinematics and limits", (time.process_time() - begin) / 4 * 1e3, "ms")
    slope = (costs[800] - costs[200]) / 600
    yield Row(group, "per pose, from 200 to 800", slope * 1e6, "us")
    yield Row(group, "twice the poses, 400 to 800, cost", costs[800] / costs[400], "x", "at most 2.1")
    made = study(100, "x=1300:1700:16,y=-300:300:12")
    yield Row(group, "sent to a worker, once", len(packed(made)) / 1e6, "MB")
    cores = os.cpu_count() or 1
    seconds = interleaved(
        {
            "one": lambda: list(here(made, made.batches)),
            "cores": lambda: list(on_processes(made, made.batches, cores)),
            "hash": lambda: hashing(1),
            "hashes": lambda: hashing(cores),
        },
        1,
    )
    what = f"{len(made.candidates.poses)} placements in one process over {cores}, their start included"
    yield Row(group, what, ratio(seconds["one"], seconds["cores"]), "x")
    yield Row(group, f"plain hashing on {cores} cores", ratio(seconds["hash"], seconds["hashes"]), "x")
