"""Bodies of tools: a cutter is looked at and drawn by whatever number the cell has it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.job import load_job
from compensator.report.scene.tool_bodies import tool_bodies as drawn_tools
from compensator.scene.tool_bodies import tool_bodies
from tests.compensator import small_job

CUTTER = {"shape": "flat", "diameter": 12.0, "flutes": 3, "length": 20.0}
WITH_HOLDER = {**CUTTER, "holder": [{"diameter": 50.0, "length": 60.0}]}


def cell(folder: Path, **cutters: Any) -> Path:
    process = small_job.merged(small_job.milling(folder), {"cutter": None, **cutters})
    return small_job.files(folder, {"process": process}).cell


NAMED: list[dict[str, Any]] = [{"cutter": WITH_HOLDER}, {"cutters": {"2": WITH_HOLDER}}]


@pytest.mark.parametrize("named", NAMED, ids=["cutter", "cutters.2"])
def test_one_tool_has_the_one_cutter_of_the_cell(tmp_path: Path, named: dict[str, Any]) -> None:
    placement = load_job(cell(tmp_path, **named)).placement
    assert [(b.role, b.tool) for b in tool_bodies(placement)] == [("cutter", None), ("holder", None)]
    drawn = [b for b in drawn_tools(placement, (), 6) if b.kind == "cutter"]
    wide = [2e3 * float(np.abs(b.mesh.vertices[:, 0]).max()) for b in drawn]
    assert wide == pytest.approx([12.0, 50.0]) and {b.tool for b in drawn} == {None}


def test_of_two_cutters_none_is_guessed(tmp_path: Path) -> None:
    placement = load_job(cell(tmp_path, cutters={"1": CUTTER, "2": WITH_HOLDER})).placement
    assert [b.role for b in tool_bodies(placement)] == ["cutter"] and tool_bodies(placement)[0].approximate
