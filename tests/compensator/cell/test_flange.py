"""The flange of the built-in IRB 6600: the maker's; what was measured from the former one is refused or asked about."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CellError
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.errors import StiffnessError
from stiffness.robot.load import load_robot
from stiffness.robot.tips import FormerFlangeError
from tests.compensator.small_job import ABB, CELL, MODEL, columns, files

OLD_TOOL = {"xyz": [0.0, 0.0, 70.0], "rpy": [0.0, 0.0, 0.0], "mass": 35.0, "com": [0.0, 0.0, -60.0]}
NEW = r"xyz = \[0, 0, 250\], com = \[0, 0, 120\]"


def test_the_flange_is_the_makers_and_the_papers_frame_a_tip(shared: Path) -> None:
    """As ROS-Industrial has it for the sister with the same wrist, link by link; 180 mm further out for the paper."""
    sister = load_robot(str(shared / "data/robots/abb_irb6600_225_255.urdf"), tip="tool0")
    robot, paper = load_robot(ABB), load_robot(ABB, tip="paper")
    rng = np.random.default_rng(1)
    shift = np.eye(4)
    shift[2, 3] = 0.180
    for q in rng.uniform(-1, 1, (20, 6)):
        np.testing.assert_allclose(robot.pose(q), sister.pose(q), atol=1e-10)
        np.testing.assert_allclose(paper.pose(q), robot.pose(q) @ shift, atol=1e-12)
        np.testing.assert_allclose(paper.gravity_torque(q), robot.gravity_torque(q), atol=1e-9)
    assert (robot.tip, paper.tip) == ("tool0", "paper") and not robot.tip_why and "380 mm" in paper.tip_why
    assert load_robot(ABB, tip="tool0").same_kinematics(robot) and not paper.same_kinematics(robot)


@pytest.mark.parametrize(
    ("cell", "model", "words"),
    [
        # an old cell said so, an old model said so: its flange had another name
        ({"tip": "flange", "tool": OLD_TOOL}, {}, rf"tip = 'flange'.*200 mm.*380 mm.*{NEW}; and tip = \"tool0\""),
        ({"tool": OLD_TOOL}, {"tip": "flange"}, rf"model\.toml was made for an earlier version.*{NEW}"),
        # nothing is said, and the tool was shortened as the note of the old robot asked for
        ({"tip": None, "tool": OLD_TOOL}, {}, rf"tool may have been shortened.*{NEW}.*set tip = \"tool0\" only"),
        ({"tip": None, "tool": {**OLD_TOOL, "xyz": [0.0, 0.0, 320.0]}}, {}, r"shortened.*xyz = \[0, 0, 500\]"),
        ({"tip": None, "tool": {**OLD_TOOL, "mass": None, "com": None}}, {}, r"shortened.*xyz = \[0, 0, 250\]; and"),
        (
            {"tip": None, "tool": None, "tools": {"1": CELL["tool"], "2": OLD_TOOL}}, {},
            r"tools\.2 may have been .*tools\.1: xyz = \[30, -20, 420\].*; tools\.2: xyz = \[0, 0, 250\]",
        ),
    ],
)  # fmt: skip
def test_an_old_cell_is_refused_with_the_new_numbers(
    tmp_path: Path, cell: dict[str, Any], model: dict[str, Any], words: str
) -> None:
    job = files(tmp_path, {**cell, "tool": {**CELL["tool"], **cell["tool"]} if cell["tool"] else None}, model)
    with pytest.raises(CellError, match=words) as caught:
        compensate_file(job.toolpath, job.cell, job.out / "a.mod")
    assert "\n" not in str(caught.value)
    with pytest.raises(CellError, match=words):
        preview_file(job.toolpath, job.cell)
    assert job.left() == []


def test_a_cell_that_does_not_tell_is_warned_of(tmp_path: Path) -> None:
    """With both sets of numbers; one line of the cell settles it, and changes nothing else."""
    rows = {}
    for name, tip in (("silent", None), ("told", "tool0")):
        (tmp_path / name).mkdir()
        job = files(tmp_path / name, {"tip": tip})
        done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
        found = [f for f in done.findings if "380 mm" in f.what]
        assert len(found) == (tip is None)
        for f in found:
            assert f.level == "warning" and "ABB's tool0, 200 mm" in f.what and "xyz = [30, -20, 420]" in f.remedy
        rows[name] = columns(job.out / "a.csv", "x_mm", "q1_deg", "q6_deg")
    np.testing.assert_array_equal(rows["silent"], rows["told"])


@pytest.mark.parametrize("name", ["a.mod", "a.src", "a.csv"])
def test_no_program_is_exported_from_the_papers_frame(tmp_path: Path, name: str) -> None:
    """It can be previewed; the deflection is that of the same tool measured from the flange."""
    paper = {"tip": "paper", "tool": {"xyz": [30.0, -20.0, 60.0], "com": [10.0, 0.0, -70.0]}}
    (tmp_path / "p").mkdir()
    job = files(tmp_path / "p", paper, {"tip": "paper"})
    with pytest.raises(CellError, match=r"tip = 'paper'.*No program is made for it.*tip = \"tool0\""):
        compensate_file(job.toolpath, job.cell, job.out / name)
    assert job.left() == []
    (tmp_path / "m").mkdir()
    same = files(tmp_path / "m")
    one, other = (preview_file(j.toolpath, j.cell).report["predicted_error_mm"]["before"] for j in (job, same))
    assert one["max"] == pytest.approx(other["max"], rel=1e-6)


def test_the_model_of_another_frame_is_refused(tmp_path: Path) -> None:
    job = files(tmp_path, {"tip": "paper"})
    with pytest.raises(CellError, match=r"tip 'paper' of the cell are not the frames of the model"):
        preview_file(job.toolpath, job.cell)


def test_other_readers_of_the_old_frame_get_the_shift(tmp_path: Path) -> None:
    """Sessions and maps have no tool in a cell: they are told by how much."""
    with pytest.raises(FormerFlangeError, match=r"Add \[0, 0, 180\] mm to every position .*reflectors on the flange"):
        load_robot(ABB, tip="flange")
    assert issubclass(FormerFlangeError, StiffnessError)
    with pytest.raises(StiffnessError, match=r"no tip 'gripper'; it has tool0, paper"):
        load_robot(ABB, tip="gripper")
    assert load_robot("ur10", tip="flange").tip == "flange" and MODEL["robot"] == ABB
