"""One arm at many placements: loaded once, and no CasADi function is built twice."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.cell.job import job_of, load_job
from compensator.cell.placement import placement_of
from compensator.errors import CellError
from compensator.path.tool_set import ToolSet
from compensator.solve.compensate import compensate
from compensator.solve.compensation import Compensation
from compensator.solve.planned import planned
from tests.compensator.small_job import WORN, files
from toolpaths.files import read_toolpath
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

MOVED = {"workobject": {"xyz": [1450.0, 100.0, 850.0], "rpy": [0.0, 5.0, -30.0]}}


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the CasADi functions that are built from here on; not their forms for another number of poses."""
    names: list[str] = []
    function = ca.Function

    def noted(name: str, *given: Any) -> Any:
        if not name.endswith("_columns"):
            names.append(name)
        return function(name, *given)

    monkeypatch.setattr(ca, "Function", noted)
    return names


def solved(job: Any, path: Toolpath) -> Compensation:
    return compensate(job, planned(job, path))


def test_a_second_placement_of_the_same_tool_builds_nothing(tmp_path: Path, built: list[str]) -> None:
    """And its commands are those of the same placement loaded from files."""
    here = files(tmp_path, None, WORN)
    path, cell = read_toolpath(here.toolpath), load_cell(here.cell)
    arm, placement = load_arm(cell), placement_of(cell)
    first = solved(job_of(arm, placement), path)
    assert built
    built.clear()
    there = placement_of(load_cell(files(tmp_path, MOVED, WORN).cell))
    second = solved(job_of(arm, there), path)
    assert built == []
    assert np.abs(first.command.q - second.command.q[: len(first)]).max() > 0.01
    fresh = solved(load_job(tmp_path / "cell.toml"), path)
    assert built and np.array_equal(fresh.command.q, second.command.q)


def test_one_predictor_per_tool_and_conditions(tmp_path: Path) -> None:
    """The same tool from another file is the same; another mass, point or gravity is another predictor."""
    cell = load_cell(files(tmp_path).cell)
    arm, placement = load_arm(cell), placement_of(cell)
    tool, conditions = placement.tools.first, placement.conditions
    one = arm.predictor(tool, conditions)
    assert arm.predictor(replace(tool, position=tool.position.copy()), replace(conditions)) is one
    heavier, longer = replace(tool, mass=tool.mass + 1.0), replace(tool, position=tool.position + 0.01)
    others = [arm.predictor(t, conditions) for t in (heavier, longer)]
    others.append(arm.predictor(tool, replace(conditions, gravity=(0.0, 9.8, 0.0))))
    others.append(arm.predictor(tool, replace(conditions, complementary=False)))
    assert len({id(p) for p in (one, *others)}) == 5


def test_placements_made_without_a_file(tmp_path: Path) -> None:
    """A study moves the work object and changes the tool of a placement; what does not fit the arm is refused."""
    cell = load_cell(files(tmp_path).cell)
    arm, placement = load_arm(cell), placement_of(cell)
    path = read_toolpath(tmp_path / "path.csv")
    moved = Frame(placement.workobject.rotation, placement.workobject.origin + np.array([0.0, 0.1, 0.0]))
    here, there = (solved(job_of(arm, p), path) for p in (placement, replace(placement, workobject=moved)))
    assert np.allclose(there.path.tcp.origin - here.path.tcp.origin, [0.0, 0.1, 0.0], atol=1e-12)
    off = placement.tools.first.position + np.array([0.0, 0.0, 0.05])
    longer = replace(placement, tools=ToolSet.of_one(replace(placement.tools.first, position=off)))
    q = solved(job_of(arm, longer), path).path.q
    assert np.abs(q - here.path.q).max() > 1e-3
    unknown = replace(arm, robot=replace(arm.robot, mass=None, com=None, mass_problem="nobody weighed it"))
    heavy = replace(placement, conditions=replace(placement.conditions, sag="uncompensated"))
    with pytest.raises(CellError, match=r"needs the link masses of .*: nobody weighed it"):
        job_of(unknown, heavy)
