"""Turns about the tool axis: the map of a path, and the turn chosen along it, against following it with one turn."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks import job
from benchmarks.table import Row
from benchmarks.timing import interleaved, ratio
from compensator.path.planned_path import PlannedPath
from compensator.solve.compensate import compensate
from compensator.solve.load_along import load_along
from compensator.solve.planned import planned
from compensator.tasks.compensate import RunInput, files_of, read_input
from compensator.turn.axis_map import axis_map
from compensator.turn.turn_grid import TURNS, turn_grid

ROUNDS = 3
MAPPED, TURNED = 10_000, 2_000  # poses
BRACKET = "xyz = [180.0, 0.0, 200.0]\nrpy = [0.0, 45.0, 0.0]"  # in line with axis 6 a turn moves that joint alone


def run(mapped: int = MAPPED, turned: int = TURNED) -> Iterator[Row]:
    """The rows; of so many poses each."""
    with tempfile.TemporaryDirectory() as folder:
        yield from _mapped(_given(Path(folder), mapped, "constant"))
        yield from _turned(*(_given(Path(folder), turned, turn) for turn in ("constant", "path")))


def _given(folder: Path, poses: int, turn: str) -> RunInput:
    job.write_inputs(folder, poses, memory=True)
    cell = folder / "cell.toml"
    text = cell.read_text().replace("xyz = [20.0, -10.0, 250.0]", BRACKET)
    cell.write_text(text.replace("[solve]", f'[solve]\nturn = "{turn}"'))
    return read_input(files_of([folder / "path.csv"], None), cell)


def _mapped(given: RunInput) -> Iterator[Row]:
    path = planned(given.job, given.path)
    wrench, planner = load_along(given.job, path).wrench, given.job.planner
    rows = axis_map(given.job, path, wrench, poses=len(path)).grid.rows
    seconds = interleaved(
        {
            "follow": lambda: planner.turned(path, path.turn),
            "grid": lambda: turn_grid(planner.inverse, planner.bounds, path, rows),
            "map": lambda: axis_map(given.job, path, wrench, poses=len(path)),
        },
        ROUNDS,
    )
    group, cells = f"axis map, {len(path):,} poses x {TURNS} turns", len(path) * TURNS
    yield Row(group, "the whole map", min(seconds["map"]), "s", "seconds")
    yield Row(group, "postures per second, closed form, limits and singularities", cells / min(seconds["grid"]), "1/s")
    yield Row(group, "the whole map over its postures alone", ratio(seconds["map"], seconds["grid"]), "x")
    what = "a turn of the grid over following the path with one turn"
    yield Row(group, what, ratio(seconds["grid"], seconds["follow"]) / TURNS, "x")


def _turned(constant: RunInput, path: RunInput) -> Iterator[Row]:
    plans: dict[str, PlannedPath] = {}

    def plan(name: str, given: RunInput) -> None:
        plans[name] = planned(given.job, given.path)

    seconds = interleaved(
        {
            "constant": lambda: plan("constant", constant),
            "path": lambda: plan("path", path),
            "command": lambda: compensate(constant.job, plans["constant"]),
        },
        ROUNDS,
    )
    group = f"the turn along the path, {len(plans['path']):,} poses"
    yield Row(group, "choosing it", min(seconds["path"]), "s")
    yield Row(group, "choosing it over one turn for the whole path", ratio(seconds["path"], seconds["constant"]), "x")
    yield Row(group, "choosing it over solving for the commands", ratio(seconds["path"], seconds["command"]), "x")
    chosen = plans["path"].chosen
    if chosen is not None and chosen.constant is not None:
        yield Row(group, "cost, chosen over constant", chosen.chosen.cost / chosen.constant.cost, "x", "below 1")
