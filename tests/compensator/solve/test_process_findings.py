"""What a process finds out beside the wrench: an error refuses the path, a warning goes with the result."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from compensator.cell.job import Job, load_job
from compensator.errors import SolveError
from compensator.process.process import Process, ProcessLoad, ToolMotion
from compensator.solve.compensate import compensate, uncompensated
from compensator.solve.planned import planned
from tests.compensator.small_job import files
from toolpaths.files import read_toolpath
from toolpaths.finding import ERROR, WARNING, Finding
from toolpaths.toolpath import CUT


@dataclass(frozen=True)
class Deep(Process):
    """100 N down at every cut, and something to tell of each."""

    level: str
    axes = "base"

    def load(self, motion: ToolMotion) -> ProcessLoad:
        path = motion.toolpath
        cut = path.kind == CUT
        found = (Finding(self.level, f"{path.source}:{path.line[k]}", "too deep") for k in np.flatnonzero(cut))
        return ProcessLoad(np.where(cut[:, None], [0.0, 0, -100, 0, 0, 0], 0.0), tuple(found), {"depth_mm": 2.0 * cut})

    def description(self) -> str:
        return "deep"


def job_with(folder: Path, level: str) -> Job:
    job = load_job(files(folder).cell)
    return replace(job, placement=replace(job.placement, process=Deep(level)))


def test_a_warning_goes_with_the_result(tmp_path: Path) -> None:
    """Once, with all its lines; columns stay beside the wrench, pose by pose."""
    job = job_with(tmp_path, WARNING)
    path = planned(job, read_toolpath(tmp_path / "path.csv"))
    for result in (compensate(job, path), uncompensated(job, path)):
        (one,) = result.load.findings
        assert (one.level, one.what, one.lines) == (WARNING, "too deep", (4, 5, 6))
        assert one.count == int(result.cutting.sum())
        assert np.array_equal(result.load.columns["depth_mm"], np.where(result.cutting, 2.0, 0.0))
        assert np.array_equal(result.wrench[result.cutting][:, 2], np.full(int(result.cutting.sum()), -100.0))


def test_an_error_refuses(tmp_path: Path) -> None:
    """Before anything is solved, with the place; a preview only shows it."""
    job = job_with(tmp_path, ERROR)
    path = planned(job, read_toolpath(tmp_path / "path.csv"))
    with pytest.raises(SolveError, match=r"csv: the process is refused:\n  error: .*path\.csv:4 \(and .* more"):
        compensate(job, path)
    (shown,) = uncompensated(job, path).load.findings
    assert (shown.level, shown.lines) == (ERROR, (4, 5, 6))
