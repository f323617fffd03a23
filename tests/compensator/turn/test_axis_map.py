"""The axis map against one posture at a time: Pinocchio's pose and Jacobian, and springs by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.job import Job, load_job
from compensator.errors import CompensatorError, PathError
from compensator.path.planned_path import PlannedPath
from compensator.solve.planned import planned
from compensator.tasks.axis_map import axis_map_file
from compensator.turn.axis_map import AxisMap, axis_map
from compensator.turn.turn_grid import BEYOND_LIMIT, COLLIDING, FREE, SINGULAR
from stiffness.robot.load import load_robot
from tests.compensator.small_job import ABB, GAPS, STIFFNESS, Files, files
from toolpaths.files import read_toolpath

SD = [2.0e4, 3.0e4, 1.0e4, 4.0e3, 2.0e3, 1.0e3]
GAP = {**GAPS, "breakaway_nm": [900.0, 40.0, 30.0, 10.0, 8.0, 4.0]}  # the cut does not hold joint 1
MODEL = {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS, "sd_nm_per_rad": SD}, "backlash": GAP}}
WAY = [[x, y, 0, 0, 0, 1, 1200, "cut"] for y, xs in ((0, (0, 60, 120)), (5, (120, 60, 0))) for x in xs]


def mapped(folder: Path, change: dict[str, Any] | None = None, **more: Any) -> tuple[Job, PlannedPath, AxisMap]:
    made = files(folder, change, MODEL, WAY)
    job = load_job(made.cell)
    path = planned(job, read_toolpath(made.toolpath))
    wrench = np.tile([-300.0, 200.0, 250.0, 5.0, -4.0, 3.0], (len(path), 1))
    return job, path, axis_map(job, path, wrench, poses=7, turns=24, **more)


def test_a_cell_is_one_posture(tmp_path: Path) -> None:
    """Pose by Pinocchio; deflection and standard deviation of springs by J and K; the flanks by the gap's lever."""
    job, path, m = mapped(tmp_path)
    arm, tool = load_robot(ABB), job.arm.tools.first
    free = np.argwhere(m.grid.free)
    for i, k in free[:: max(len(free) // 12, 1)]:
        q, row = m.grid.q[i, k], m.grid.rows[i]
        flange = arm.pose(q)
        tip = flange[:3, :3] @ tool.position + flange[:3, 3]
        np.testing.assert_allclose(tip, path.tcp.origin[row], atol=1e-9)
        turned = flange[:3, :3] @ tool.rotation
        x = path.tcp.rotation[row] @ np.array([np.cos(a := m.grid.turns[k] - path.turn[row]), np.sin(a), 0])
        np.testing.assert_allclose(turned[:, 0], x, atol=1e-9)
        jacobian = arm.jacobian(q)
        at_tip = jacobian[:3] - np.cross(flange[:3, :3] @ tool.position, jacobian[3:], axisb=0, axisc=0)
        process = at_tip.T @ [-300.0, 200.0, 250.0] + jacobian[3:].T @ [5.0, -4.0, 3.0]
        stiff = np.array(STIFFNESS)
        assert m.reliance.deflection[i, k] == pytest.approx(np.linalg.norm(at_tip @ (process / stiff)), rel=0.03)
        lever = np.linalg.norm(at_tip, axis=0)
        edge = np.hypot(lever, 0.01) * GAPS["gap_rad"]
        open_ = m.reliance.crossing[i, k] > 0
        np.testing.assert_allclose(m.reliance.crossing[i, k][open_], edge[open_], rtol=1e-9)
        springs = lever * np.abs(process) * (1 / stiff - 1 / (stiff + SD))
        expected = np.sqrt(np.sum(springs**2) + np.sum((0.25 * lever * GAPS["gap_rad"])[open_] ** 2))
        assert m.reliance.sd[i, k] == pytest.approx(expected, rel=1e-6)
    crossing = m.reliance.crossing[m.grid.free]
    assert (crossing[:, 0] > 3e-5).any()  # no weight holds its flank
    assert not crossing[:, 1].any()  # the weight of the arm holds joint 2


def test_what_forbids_a_turn(tmp_path: Path) -> None:
    change = {"solve": {"min_wrist_angle": 50.0}, "start": {"joints": [0.0, 10.0, 20.0, 0.0, 60.0, 0.0]}}
    _, _, m = mapped(tmp_path, change)
    assert (m.grid.status == SINGULAR).any() and (m.grid.status == FREE).any()
    wrist = np.abs(np.sin(m.grid.q[:, :, 4]))
    singular = (wrist < np.sin(np.radians(50.0))) & (m.grid.status != BEYOND_LIMIT)
    np.testing.assert_array_equal(m.grid.status == SINGULAR, singular)
    at = np.round(m.chosen / m.grid.step).astype(int) % 24
    assert m.grid.free[np.arange(len(at)), at].all()


def test_a_clearance_forbids_cells(tmp_path: Path) -> None:
    """The slot of collisions: asked once for every posture."""
    asked = []

    def clear(rows: np.ndarray, q: np.ndarray) -> np.ndarray:
        asked.append(q.shape)
        return q[:, :, 0] > np.radians(-2.0)

    _, _, m = mapped(tmp_path, clear=clear)
    hit = m.grid.q[:, :, 0] <= np.radians(-2.0)
    assert asked == [(len(m.grid.rows), 24, 6)] and 0 < hit.sum() < hit.size
    np.testing.assert_array_equal(m.grid.status == COLLIDING, hit & (m.grid.margin >= 0))
    assert np.isnan(m.reliance.sd[m.grid.status == COLLIDING]).all()


def test_reversals_of_a_zigzag(tmp_path: Path) -> None:
    """Out and back: by hand, the joints whose moves change their sign at a constant turn."""
    _, _, m = mapped(tmp_path)
    q = m.grid.q[:, 3]
    sign = np.sign(np.diff(q, axis=0))
    by_hand = (sign[1:] * sign[:-1] < 0).sum()
    assert m.reversing[:, 3].sum() == by_hand > 3


def test_files(tmp_path: Path) -> None:
    made: Files = files(tmp_path, None, MODEL, WAY)
    csv, js, page = (made.out / name for name in ("m.csv", "m.json", "m.html"))
    done = axis_map_file(made.toolpath, made.cell, poses=5, turns=12, csv=csv, json=js, report=page)
    lines = csv.read_text().splitlines()
    assert len(lines) == 1 + 5 * 12 and lines[0].startswith("pose,source_line,kind,position_mm,turn_deg,status")
    rows = [line.split(",") for line in lines[1:]]
    assert sum(int(row[-1]) for row in rows) == 5
    report = json.loads(js.read_text())
    free = [row for row in rows if row[5] == "free"]
    assert report["share"]["free"] == pytest.approx(len(free) / len(rows))
    chosen = [float(row[8]) for row in rows if row[-1] == "1"]
    assert report["deflection_sd_mm"]["chosen"] == pytest.approx(np.mean(chosen) / 1e3, rel=1e-3)
    assert "turns about the tool axis, in the arm configuration" in page.read_text().replace("\n", " ")
    assert done.files == (csv, page, js)


def test_refusals(tmp_path: Path) -> None:
    made = files(tmp_path, None, MODEL, WAY)
    with pytest.raises(CompensatorError, match=r"--turns 3: expected 8 to 720"):
        axis_map_file(made.toolpath, made.cell, turns=3)
    ur = {"robot": "ur10", "tip": None, "workobject": {"xyz": [500.0, -150.0, 200.0]}}
    small = files(tmp_path, ur, {"robot": "ur10"}, WAY)
    with pytest.raises(PathError, match=r"ur10: turns along a path are looked at in closed form"):
        axis_map_file(small.toolpath, small.cell)
