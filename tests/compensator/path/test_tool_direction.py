"""Which way the tool looks, and a part that is cut from below."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.tasks.compensate import preview_file
from tests.compensator.small_job import ROWS, files

UPSIDE_DOWN = {"workobject": {"xyz": [1300.0, -150.0, 1500.0], "rpy": [180.0, 0.0, 20.0]}, "start": None}
HANGING = {"mount": {"rpy": [180.0, 0.0, 0.0]}}


@pytest.mark.parametrize(
    ("cell", "along", "upward"),
    [
        ({}, (0.0, 0.0, -1.0), False),
        (UPSIDE_DOWN, (0.0, 0.0, 1.0), True),
        (HANGING, (0.0, 0.0, -1.0), True),  # the base hangs from a ceiling: its -z is up
        ({**UPSIDE_DOWN, **HANGING}, (0.0, 0.0, 1.0), False),
    ],
)
def test_the_spindle_below_the_work_is_asked_about(
    tmp_path: Path, cell: dict[str, Any], along: tuple[float, ...], upward: bool
) -> None:
    job = files(tmp_path, cell)
    done = preview_file(job.toolpath, job.cell)
    told = done.report["tool_direction"]
    np.testing.assert_allclose(told["mean_xyz"], along, atol=1e-9)
    assert told["spread_deg"] == pytest.approx(0.0, abs=1e-4)
    assert told["n_upward"] == (done.report["n_cut"] if upward else 0)
    asked = [f for f in done.findings if "below the work" in f.what]
    assert len(asked) == upward
    for finding in asked:
        assert (finding.level, finding.kind, finding.count) == ("warning", "path", told["n_upward"])
        assert finding.source_line == 4 and "by up to 90 deg" in finding.what  # the plunge, the first cut


def test_a_tilted_tool(tmp_path: Path) -> None:
    """Tool axes of 0 and 30 deg: the mean lies between, the spread on both sides; a level spindle is not below."""
    s, c = np.sin(np.radians(30.0)), np.cos(np.radians(30.0))
    rows = [[*r[:3], *((s, 0, c) if k > 2 else (0, 0, 1)), *r[6:]] for k, r in enumerate(ROWS)]
    job = files(tmp_path, {"workobject": {"rpy": [0.0, 0.0, 0.0]}}, rows=rows)
    told = preview_file(job.toolpath, job.cell).report["tool_direction"]
    assert told["mean_xyz"][2] < -0.86 and -0.5 < told["mean_xyz"][0] < 0.0 and told["n_upward"] == 0
    assert 15.0 < told["spread_deg"] < 30.0
