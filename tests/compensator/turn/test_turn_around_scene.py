"""A tool with an arm that sticks out, and a post where the constant turn puts it: the chosen turn goes around it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.job import load_job
from compensator.errors import PathError
from compensator.solve.planned import planned
from compensator.tasks.axis_map import axis_map_file
from compensator.tasks.compensate import compensate_file
from compensator.turn.turn_grid import COLLIDING
from tests.compensator import small_job
from toolpaths.files import read_toolpath

ARM = {"name": "hose", "box": [[0.0, -20.0, 110.0], [330.0, 20.0, 150.0]]}  # 90 to 130 mm above the TCP
TOOL = {"xyz": [0.0, 0.0, 240.0], "rpy": [0.0, 0.0, 0.0], "com": [0.0, 0.0, 110.0], "bodies": [ARM]}
CUTS = [[10.0 * k, 0, 0, 0, 0, 1, 1200, "cut"] for k in range(9)]
ROWS: list[list[Any]] = [[0, 0, 60, 0, 0, 1, 0, "rapid"], *CUTS]


def job(folder: Path, turn: str, *scene: dict[str, Any]) -> small_job.Files:
    folder.mkdir()
    return small_job.files(folder, {"tool": TOOL, "scene": list(scene), "solve": {"turn": turn}}, rows=ROWS)


def test_around_a_post(tmp_path: Path) -> None:
    alone = job(tmp_path / "alone", "constant")
    plan = planned(load_job(alone.cell), read_toolpath(alone.toolpath))
    work = load_job(alone.cell).placement.workobject
    side = work.rotation.T @ plan.tcp.rotation[0][:, 0]  # where the arm of the tool points, in the work object
    x, y = 40.0 + 300.0 * side[0], 300.0 * side[1]
    post = {"name": "post", "box": [[x - 15, y - 15, 0.0], [x + 15, y + 15, 200.0]], "frame": "workobject"}
    held = job(tmp_path / "held", "constant", post)
    with pytest.raises(PathError, match="hose and post touch"):
        compensate_file(held.toolpath, held.cell, held.out / "p.mod")
    turned = job(tmp_path / "turned", "path", post)
    done = compensate_file(turned.toolpath, turned.cell, turned.out / "p.mod")
    assert done.report["collisions"]["contacts"] == []
    new = work.rotation.T @ done.result.path.tcp.rotation[5][:, 0]
    assert np.degrees(np.arccos(new @ side)) > 4.0  # 30 mm at 300 mm
    found = axis_map_file(held.toolpath, turned.cell).result.grid
    hit = found.status == COLLIDING
    assert hit.any(axis=0).sum() in range(2, 20) and not hit.all(axis=1).any()
