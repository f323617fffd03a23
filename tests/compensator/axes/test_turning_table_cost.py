"""What the choice of a table that turns takes a way for, against the path that has that way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.axes.axis_cost import AxisCost
from compensator.axes.axis_search import axis_search
from compensator.path.planned_path import PlannedPath
from compensator.solve.load_along import load_along
from compensator.tasks.compensate import Done, compensate_file
from compensator.turn.reliance import tool_reliances
from tests.compensator.axes.test_turning_table_files import SHORT, job, path_on_table, planned_on
from tests.compensator.small_job import Files


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Files, Done]:
    """A quarter of a ring with its table."""
    made = job(tmp_path_factory.mktemp("cost"))
    return made, compensate_file(made.toolpath, made.cell, made.out / "c.csv")


def test_the_cost_of_another_way_is_that_of_its_path(written: tuple[Files, Done]) -> None:
    """Angles, loads and derivatives of the refinement, against the path that is planned anew with the other way."""
    one, path, free, _ = path_on_table(written[0], 0.0)
    done = written[1].result.path
    at = done.toolpath.ways.at(done.toolpath.row)["E2"][:, None]
    tools, wrench = tool_reliances(one.arm), load_along(one, done).wrench
    cost = AxisCost.of(one, free, done, wrench=wrench, tools=tools)
    other = at + 3.0 * np.sin(np.linspace(0.0, 4.0, len(at)))[:, None]
    moved = free.on(path, other)
    begun = PlannedPath(moved, one.planner.reference(moved), done.q, done.turn, done.branch)
    again = one.planner.turned(begun, done.turn)
    q = cost.angles(np.round(other, 4))[0]
    assert np.abs(again.q - done.q).max() > 0.02
    np.testing.assert_allclose(np.sin(q - again.q), 0.0, atol=1e-9)
    loaded = cost.table.load(wrench, np.round(other, 4), slice(None))
    np.testing.assert_allclose(loaded, load_along(one, again).wrench, atol=1e-6)
    slope = cost.slopes(at)[1][:, :, 0]
    step = (cost.postures(at + 0.01).commands - cost.postures(at - 0.01).commands) / 0.02
    np.testing.assert_allclose(slope, step, atol=2e-3 * np.abs(step).max())
    assert np.abs(step).max() > 1e-3


def test_a_lattice_is_looked_at_as_the_path_is_run(tmp_path: Path) -> None:
    """Loads along a way are those of the path that has it; turns of the lattice, whose references are those of tables
    that stand, are the same orientations when they are counted from the path's."""
    made = job(tmp_path, [[*r[:3], 0.6, 0.0, 0.8, *r[6:]] for r in SHORT])
    one, path, free, _ = path_on_table(made, 0.0)
    stages = axis_search(one, free, path, lambda begun: load_along(one, begun).wrench).stages
    whole = load_along(one, planned_on(one, free.on(path, np.full((len(path), 1), 0.0)))).wrench
    places = np.round(np.interp(np.arange(len(path)), stages.rows, 30.0 * np.arange(len(stages.rows))), 4)[:, None]
    moved = free.on(path, places)
    middle = stages.wrench_at(np.zeros(1), whole)  # the range is about 0: the part as it is
    np.testing.assert_allclose(middle, whole, atol=1e-9)
    turning = load_along(one, planned_on(one, moved)).wrench
    np.testing.assert_allclose(stages.wrench_along(places, whole), turning, atol=1e-9)
    way = places[stages.rows]
    off = stages.held_on(moved, way)
    lattice = np.stack([stages.references(way[k : k + 1])[0].rotation[k] for k in range(len(way))])
    there = one.planner.reference(moved).take(stages.rows).rotation
    turn = np.linspace(0.0, 2.0, len(way))
    by = [Rotation.from_euler("z", angle).as_matrix() for angle in (turn[:, None], (turn - off)[:, None])]
    assert np.abs(off).max() > 0.2
    np.testing.assert_allclose(lattice @ by[0], there @ by[1], atol=1e-6)
