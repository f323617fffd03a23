"""Paths that collide, or nearly: what is refused, what is told, what is left alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import trimesh

from compensator.errors import CellError, CompensatorError, PathError
from compensator.tasks.check import check_files
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator import small_job
from tests.compensator.scene import mesh_arm

STRAIGHT = {"xyz": [0.0, 0.0, 240.0], "rpy": [0.0, 0.0, 0.0], "com": [0.0, 0.0, 110.0]}
# across the way of the cut from (0, 0) to (100, 0): a wall that anyone sees
WALL = {"name": "clamp", "box": [[45.0, -20.0, -5.0], [55.0, 20.0, 30.0]], "frame": "workobject"}


def job(folder: Path, *scene: dict[str, Any], **cell: Any) -> small_job.Files:
    return small_job.files(folder, cell={"tool": STRAIGHT, "scene": list(scene), **cell})


def preview(files: small_job.Files) -> dict[str, Any]:
    return preview_file(files.toolpath, files.cell).report


def told(report: dict[str, Any], level: str) -> list[dict[str, Any]]:
    return [f for f in report["findings"] if f["kind"] == "collision" and f["level"] == level]


def test_a_wall_across_the_path_refuses_the_program_with_pose_line_and_bodies(tmp_path: Path) -> None:
    files = job(tmp_path, WALL)
    with pytest.raises(PathError, match=r"path\.csv:5 \(pose \d+\).*: tool and clamp touch"):
        compensate_file(files.toolpath, files.cell, files.out / "p.csv")
    assert files.left() == []


def test_preview_tells_where_it_touches(tmp_path: Path) -> None:
    report = preview(job(tmp_path, WALL))
    (contact,) = report["collisions"]["contacts"]
    assert contact["bodies"] == ["tool", "clamp"]
    assert contact["source_line"] == 5  # the cut along x
    (error,) = told(report, "error")
    assert error["source_line"] == 5


def test_check_lists_it(tmp_path: Path) -> None:
    files = job(tmp_path, WALL)
    report = check_files(files.cell, [files.toolpath]).report
    assert any("tool and clamp touch" in f["what"] for f in report["findings"] if f["level"] == "error")


def test_a_free_path_is_left_alone(tmp_path: Path) -> None:
    report = preview(job(tmp_path, {**WALL, "xyz": [0.0, 0.0, -60.0]}))
    assert report["collisions"]["contacts"] == []
    assert told(report, "error") + told(report, "warning") == []


def test_nearness_is_measured(tmp_path: Path) -> None:
    beside = {"name": "vise", "box": [[-50.0, -60.0, -50.0], [150.0, -20.0, 40.0]], "frame": "workobject"}
    (warning,) = told(preview(job(tmp_path, beside, collisions={"margin": 25.0})), "warning")
    assert warning["what"].startswith("tool comes within 18.0 mm of vise")  # 20 mm less the radius of the line


@pytest.mark.parametrize(("sacrificial", "refused"), [(True, 0), (False, 1)])
def test_a_feed_may_cut_what_is_sacrificial(tmp_path: Path, sacrificial: bool, refused: int) -> None:
    board = {"name": "board", "box": [[-50.0, -50.0, -30.0], [150.0, 150.0, -1.0]], "frame": "workobject"}
    report = preview(job(tmp_path, {**board, "sacrificial": sacrificial}))
    assert len(report["collisions"]["contacts"]) == refused


def test_a_rapid_through_what_is_sacrificial_is_a_collision(tmp_path: Path) -> None:
    board = {"name": "board", "box": [[60.0, 40.0, -30.0], [150.0, 150.0, 10.0]], "frame": "workobject"}
    rows = [*small_job.ROWS[:4], [100, 0, 5, 0, 0, 1, 0, "rapid"], [100, 90, 5, 0, 0, 1, 0, "rapid"]]
    files = small_job.files(tmp_path, cell={"tool": STRAIGHT, "scene": [{**board, "sacrificial": True}]}, rows=rows)
    (contact,) = preview(files)["collisions"]["contacts"]
    assert contact["source_line"] == 7


def test_declared_neighbours_may_touch(tmp_path: Path) -> None:
    report = preview(job(tmp_path, WALL, collisions={"neighbours": [["tool", "clamp"]]}))
    assert report["collisions"]["contacts"] == []
    with pytest.raises(CellError, match="'klamp' is no body; there are: base, clamp, link-1"):
        preview(job(tmp_path, WALL, collisions={"neighbours": [["tool", "klamp"]]}))


def test_no_check_where_none_is_wanted(tmp_path: Path) -> None:
    report = preview(job(tmp_path, WALL, collisions={"check": False}))
    assert report["collisions"]["checked"] is False
    assert any("not looked for" in f["what"] for f in told(report, "note"))


def test_a_mesh_in_metres_is_refused(tmp_path: Path) -> None:
    trimesh.creation.box([1.2, 0.8, 0.7]).export(tmp_path / "table.stl")
    table = {"name": "table", "mesh": "table.stl", "xyz": [1500.0, 0.0, -500.0]}
    with pytest.raises(CellError, match=r"table is 1\.2 mm large with units = 'mm'.*units = 'm' would make it 1200 mm"):
        preview(job(tmp_path, table))
    report = preview(job(tmp_path, {**table, "units": "m"}))
    assert report["collisions"]["contacts"] == []


def test_a_mesh_that_stands_in_the_way(tmp_path: Path) -> None:
    trimesh.creation.icosphere(radius=15.0).export(tmp_path / "ball.stl")
    ball = {"name": "ball", "mesh": "ball.stl", "xyz": [100.0, 30.0, 0.0], "frame": "workobject"}
    (contact,) = preview(job(tmp_path, ball))["collisions"]["contacts"]
    assert contact["source_line"] == 6  # the cut along y


def test_a_robot_without_shapes_says_what_is_not_checked(tmp_path: Path) -> None:
    urdf = mesh_arm.write(tmp_path)
    for mesh in (tmp_path / "lumps" / "meshes").iterdir():
        mesh.unlink()
    cell = {"robot": urdf.name, "tip": None, "workobject": {"xyz": [700.0, 100.0, 700.0]}}
    files = small_job.files(tmp_path, cell={"tool": STRAIGHT, **cell}, model={"robot": urdf.name})
    report = preview(files)
    (note,) = told(report, "note")
    assert "collisions of its links are not looked for" in note["what"]
    assert "7 of 7 meshes are not found (package://lumps/meshes/link0.stl)" in note["what"]
    assert report["collisions"]["not_checked"] != ""


def test_the_arm_and_its_spindle_keep_out_of_the_stock(tmp_path: Path) -> None:
    process = small_job.milling(tmp_path)
    spindle = {"name": "spindle", "cylinder": {"radius": 60.0, "z": [0.0, 239.0]}}  # down to 1 mm above the tip
    files = small_job.files(tmp_path, cell={"tool": {**STRAIGHT, "bodies": [spindle]}, "process": process})
    report = preview(files)
    assert ["spindle", "stock"] in [c["bodies"] for c in report["collisions"]["contacts"]]
    spindle["cylinder"] = {"radius": 60.0, "z": [0.0, 200.0]}
    files = small_job.files(tmp_path, cell={"tool": {**STRAIGHT, "bodies": [spindle]}, "process": process})
    assert preview(files)["collisions"]["contacts"] == []


def test_two_bodies_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CompensatorError, match="'clamp' stands twice"):
        preview(job(tmp_path, WALL, WALL))


def test_the_summary_is_json(tmp_path: Path) -> None:
    found = json.loads(json.dumps(preview(job(tmp_path, WALL))["collisions"]))
    assert found["n_pairs"] > 20 and found["n_looks"] > found["n_pairs"]
    assert all(set(n) == {"bodies", "distance_mm", "pose", "source_line", "within_margin"} for n in found["nearest"])
