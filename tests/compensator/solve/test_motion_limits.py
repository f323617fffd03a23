"""Joints that are too fast at the programmed feed: told with pose and line, or the feed is lowered there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CellError
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.robot.load import builtin_robots, load_robot
from tests.compensator.posture_toolpaths import QUATERNION, between, rows_at
from tests.compensator.small_job import ABB, Files, columns, files

FEED = 20000.0  # mm/min
#: Slowly up to the place where axes 4 and 6 are nearly in line, there joint 4 turns over 70 deg, and on.
WAY = [
    *between([0, 10, 20, -40, 4, 60], [0, 10, 20, -35, 4, 55], 6),
    *between([0, 10, 20, -35, 4, 55], [0, 10, 20, 35, 4, -15], 60)[1:],
]


def fast(folder: Path, **solve: Any) -> Files:
    rows = [[*row[:7], FEED, "cut"] for row in rows_at(ABB, WAY)]
    cell = {"start": {"joints": [float(v) for v in WAY[0]]}, "solve": {"free_tool_axis": False, **solve}}
    cell["sampling"] = {"spacing": 1000.0, "angle": 10.0}
    return files(folder, cell, None, rows, QUATERNION)


def test_a_joint_that_is_too_fast_is_told(tmp_path: Path) -> None:
    job = fast(tmp_path)
    done = compensate_file(job.toolpath, job.cell, tmp_path / "out" / "a.csv")
    q = np.radians(columns(tmp_path / "out" / "a.csv", *(f"q{k}_deg" for k in range(1, 7))))
    xyz = columns(tmp_path / "out" / "a.csv", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm")
    seconds = np.linalg.norm(np.diff(xyz, axis=0), axis=1) / (FEED / 60)
    by_hand = np.degrees(np.abs(np.diff(q, axis=0)[:, 3]) / seconds).max()
    assert by_hand > 400.0
    motion = done.report["motion"]
    assert motion["speed_deg_per_s"]["limit"][3] == pytest.approx(150.0)
    assert motion["speed_deg_per_s"]["max"][3] == pytest.approx(by_hand, rel=0.05)  # a mean over 24 ms
    told = [f for f in done.findings if "joint 4 would have to turn" in f.what]
    assert len(told) == 1 and told[0].kind == "path" and told[0].count > 20
    assert f"pose {int(told[0].source_line) - 2}" in told[0].place  # a header, and rows counted from 0
    assert "has 150" in told[0].what


def test_the_feed_is_lowered_there_and_only_there(tmp_path: Path) -> None:
    job = fast(tmp_path, feed="limit")
    done = compensate_file(job.toolpath, job.cell, tmp_path / "out" / "a.csv", json=tmp_path / "out" / "a.json")
    report = json.loads((tmp_path / "out" / "a.json").read_text())
    for name in ("speed_deg_per_s", "acceleration_deg_per_s2"):
        values = report["motion"][name]
        assert np.all(np.array(values["max"]) <= 1.002 * np.array(values["limit"])), name
    assert max(report["motion"]["speed_deg_per_s"]["max"][3], 0) > 100.0  # no slower than it has to be
    feed = columns(tmp_path / "out" / "a.csv", "feed_mm_min")[:, 0]
    lowered = report["motion"]["lowered"]
    listed = np.zeros(len(feed), dtype=bool)
    for part in lowered:
        first, last = part["poses"]
        listed[first : last + 1] = True
        assert part["programmed_mm_per_min"] == pytest.approx(FEED)
        assert part["lowest_mm_per_min"] == pytest.approx(feed[first : last + 1].min(), rel=1e-5)
    np.testing.assert_array_equal(listed, feed < FEED * (1 - 1e-9))
    assert listed[20:50].all() and feed.min() < FEED / 2.5
    assert not [f for f in done.findings if "would have to" in f.what]
    assert [f.count for f in done.findings if "the feed is lowered" in f.what] == [1]


def test_preview_lowers_it_as_well(tmp_path: Path) -> None:
    job = fast(tmp_path, feed="limit")
    report = preview_file(job.toolpath, job.cell).report
    assert report["motion"]["lowered"] and report["motion"]["speed_deg_per_s"]["max"][3] <= 150.2


def test_a_robot_without_accelerations_says_so(tmp_path: Path) -> None:
    arm = (Path(__file__).parents[3] / "stiffness" / "robot" / "data" / f"{ABB}.toml").read_text()
    bare = "\n".join(line for line in arm.splitlines() if not line.startswith("acceleration"))
    (tmp_path / "arm.toml").write_text(bare.replace(f'name = "{ABB}"', 'name = "arm"'))
    job = files(tmp_path, {"robot": "arm.toml"}, {"robot": "arm.toml"})
    done = preview_file(job.toolpath, job.cell)
    assert done.report["motion"]["acceleration_deg_per_s2"]["limit"] == [None] * 6
    assert [f.level for f in done.findings if f.what.startswith("acceleration of the joints not checked")] == ["note"]


def test_feeds_of_a_program_in_place_stay(tmp_path: Path) -> None:
    job = files(tmp_path, {"solve": {"feed": "limit"}})
    (tmp_path / "a.nc").write_text("G90 G21\nG0 X0 Y0 Z50\nG1 Z-2 F300\nX80\n")
    with pytest.raises(CellError, match=r'solve.feed = "limit": a program that is filtered in place keeps its feeds'):
        compensate_file(tmp_path / "a.nc", job.cell, tmp_path / "b.nc", language="gcode")


@pytest.mark.parametrize("name", builtin_robots())
def test_built_in_robots_have_both(name: str) -> None:
    robot = load_robot(name)
    assert np.all(robot.velocity > np.radians(60)) and np.all(robot.velocity < np.radians(250))
    assert robot.acceleration is not None
    assert np.all(robot.acceleration > 0.3) and np.all(robot.acceleration < 8.0)
