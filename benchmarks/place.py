"""Collisions and placements: looks and postures per second, and what a placement costs, as slopes over its poses."""

from __future__ import annotations

import os
import pickle
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
UR10_MODEL = """
schema = "model/1"
robot = "ur10"
[effects.joint-stiffness]
k_nm_per_rad = [6e4, 6e4, 4e4, 1.2e4, 1.2e4, 1e4]
sd_nm_per_rad = [3e3, 3e3, 2e3, 6e2, 6e2, 5e2]
"""
UR10 = """
schema = "cell/1"
robot = "ur10"
model = "ur10-model.toml"
gravity = "calibrated-out"

[tool]
xyz = [0.0, 30.0, 150.0]
rpy = [0.0, 0.0, 0.0]
mass = 2.0
com = [0.0, 0.0, 80.0]

[workobject]
xyz = [500.0, 0.0, 100.0]
rpy = [0.0, 0.0, 0.0]

[process]
kind = "constant"
frame = "path"
wrench = [-30.0, 20.0, -15.0, 0.0, 0.0, 0.0]
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
        yield from _without_closed_form(Path(folder), study)


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


def _cost(study: Study) -> tuple[float, float]:
    """s of processor time: a placement, and its inverse kinematics and limits; means over eight of them."""
    judge, other, rows = _at_worker(study), _at_worker(study), range(4, 12)
    planner = other.job.planner
    begin = time.process_time()
    for k in rows:
        judge.row(k)
    between = time.process_time()
    for k in rows:
        placed_postures(study, planner.inverse, planner.bounds, study.candidates.frame(k))
    return (between - begin) / len(rows), (time.process_time() - between) / len(rows)


def _at_worker(study: Study) -> Judge:
    """As a worker begins: what inverse kinematics remembers of other studies is not there."""
    judge = Judge(pickle.loads(packed(study)))
    judge.row(0)
    return judge


def _placements(study) -> Iterator[Row]:  # type: ignore[no-untyped-def]
    group, costs = "place: one placement, 12 turns x 8 configurations", {}
    for poses in (100, 200, 400, 800):
        costs[poses], looked = _cost(study(poses))
        yield Row(group, f"{poses} poses: whole", costs[poses] * 1e3, "ms")
        yield Row(group, f"{poses} poses: inverse kinematics and limits", looked * 1e3, "ms")
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


def _without_closed_form(folder: Path, study) -> Iterator[Row]:  # type: ignore[no-untyped-def]
    """The same path under a UR10, whose wrist axes do not meet in a point."""
    group = "place: one placement of an arm without a spherical wrist, 12 turns"
    given = read_input(files_of([EXAMPLES / "wave.nc"], None), _ur10(folder))
    arm, path = load_arm(load_cell(folder / "ur10.toml")), sampled(given.job.placement, given.path)

    def placed(poses: int, words: str) -> Study:
        candidates = box(words, load_cell(folder / "ur10.toml").workobject)
        return study_of(arm, given.job, path, candidates, turns=12, poses=poses, inputs={})

    costs = {}
    for poses in (100, 200, 400, 800):
        made = placed(poses, "x=450:650:5,y=-300:300:4,z=200")
        costs[poses], looked = _cost(made)
        yield Row(group, f"{poses} poses: whole", costs[poses] * 1e3, "ms")
        yield Row(group, f"{poses} poses: inverse kinematics and limits", looked * 1e3, "ms")
    yield Row(group, "per pose, from 200 to 800", (costs[800] - costs[200]) / 600 * 1e6, "us")
    judge = Judge(placed(100, "x=450:650:5,y=-300:300:4,z=200"))
    good = sum(judge.row(k).status == "good" for k in range(4, 12)) / 8
    yield Row(group, "share of these that is good", good, "", "at least 0.9")
    beyond = {"at the edge of the reach": "x=1200:1300:5,y=-300:300:4", "far beyond it": "x=3000:3200:5,y=-300:300:4"}
    for where, words in beyond.items():
        yield Row(group, f"200 poses, out of reach, {where}", _cost(placed(200, words))[0] * 1e3, "ms")
    spherical = _cost(study(200))[0]
    yield Row(group, "200 poses over the same with a spherical wrist", costs[200] / spherical, "x", "at most 50")


def _ur10(folder: Path) -> Path:
    """A cell, with a model of plausible joint springs."""
    (folder / "ur10-model.toml").write_text(UR10_MODEL, encoding="utf-8")
    path = folder / "ur10.toml"
    path.write_text(UR10 + FIXTURE, encoding="utf-8")
    return path
