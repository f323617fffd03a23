"""Where commands of the best way do not agree with the joint states that they cause, the next best is taken."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from compensator.errors import SolveError
from compensator.solve import compensate as solving
from compensator.solve.compensation import Compensation
from compensator.tasks.compensate import compensate_file
from tests.compensator.axes.test_free_axes_files import job


def test_the_next_best_is_taken_and_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solved, costs = solving._compensated, list[float]()

    def first_refused(one: Any, path: Any, **more: Any) -> Compensation:
        costs.append(path.axes.chosen.cost)
        if len(costs) == 1:
            raise SolveError("joint state and correction do not agree")
        return solved(one, path, **more)

    monkeypatch.setattr(solving, "_compensated", first_refused)
    made = job(tmp_path)
    done = compensate_file(made.toolpath, made.cell, made.out / "c.mod")
    assert len(costs) == 2 and costs[0] < costs[1] < 1.5 * costs[0]
    told = done.report["external"]
    assert told["chosen"]["cost_um2"]["sum"] == pytest.approx(costs[1] * 1e12)
    assert any("no commands that agree with the joint states" in str(f) for f in done.findings)
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006
