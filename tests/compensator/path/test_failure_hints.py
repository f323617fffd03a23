"""A path that cannot be followed: what is behind it, besides the joint that ends at its limit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from compensator.errors import PathError
from compensator.tasks.compensate import preview_file
from tests.compensator.small_job import files

ANOTHER = "[start] joints ask for an arm configuration that does not reach the path; another one does"
UPWARDS = "The tool looks upwards, the part is cut from below: is [workobject] rpy upside down?"
BEHIND = [129.0, -60.0, -5.0, -195.0, 87.0, 25.0]  # the wrist centre is behind axis 1
FRONT = [0.0, 0.0, 20.0, 0.0, 60.0, 0.0]


def refusal(folder: Path, cell: dict[str, Any]) -> str:
    job = files(folder, cell)
    with pytest.raises(PathError) as caught:
        preview_file(job.toolpath, job.cell)
    return str(caught.value)


def test_the_other_configuration_of_start(tmp_path: Path) -> None:
    """It is named, and with the joints that are proposed the run is done."""
    text = refusal(tmp_path, {"start": {"joints": BEHIND}, "solve": {"free_tool_axis": False}})
    assert ANOTHER in text and UPWARDS not in text
    joints = [float(a) for a in text.split("such as joints = [")[1].split("]")[0].split(",")]
    job = files(tmp_path, {"start": {"joints": joints}})
    assert preview_file(job.toolpath, job.cell).report["n_cut"] > 0


def test_a_part_upside_down(tmp_path: Path) -> None:
    turned = {"workobject": {"rpy": [180.0, 0.0, 0.0], "xyz": [1500.0, -150.0, 100.0]}}
    assert refusal(tmp_path, turned).endswith(UPWARDS)


def test_under_a_robot_that_hangs_it_is_not(tmp_path: Path) -> None:
    """Up is against gravity."""
    over = {"mount": {"rpy": [180.0, 0.0, 0.0]}, "workobject": {"rpy": [180.0, 0.0, 0.0], "xyz": [9000.0, 0.0, 0.0]}}
    assert UPWARDS not in refusal(tmp_path, over)


def test_out_of_reach_is_nothing_else(tmp_path: Path) -> None:
    """With a start that asks for nothing odd."""
    text = refusal(tmp_path, {"workobject": {"xyz": [9000.0, 0.0, 0.0]}, "start": {"joints": FRONT}})
    assert ANOTHER not in text and UPWARDS not in text and "out of reach" in text
