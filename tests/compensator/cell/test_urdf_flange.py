"""The frame of a URDF that tools are measured from: in a new cell, in its program, and in cells that do not name it."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from click.testing import CliRunner

from compensator.cell.arm import load_arm
from compensator.cell.cell_file import load_cell
from compensator.cli import main
from compensator.errors import CellError, CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.init import init_files
from stiffness.robot.load import load_robot
from stiffness.robot.robot import placement
from tests.compensator.small_job import MODEL, columns, files

KR210 = "kuka_kr210_r2700_2"
# the maker's frame, as the files name it; m and deg from the last moving link; where the part lies, mm
FRAMES = {
    KR210: ("tool0", 0.215, 180.0, "1500 -150 800"),
    "motoman_mh50": ("tool0", 0.175, 180.0, "1200 -150 200"),
    "fanuc_official_m710ic_50": ("fanuc_flange", 0.175, 180.0, "1200 -150 500"),
    "ur10_robot": ("tool0", 0.0922, 90.0, "-700 -150 0"),
}


def urdf(shared: Path, folder: Path, name: str) -> str:
    return os.path.relpath(shared / "data" / "robots" / f"{name}.urdf", folder)


@pytest.fixture(params=FRAMES)
def new_cell(request: pytest.FixtureRequest, shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Written by `init`, for the robot in its parameter."""
    job = files(tmp_path)
    job.cell.unlink()
    monkeypatch.chdir(tmp_path)
    name = request.param
    answers = ("--robot", urdf(shared, tmp_path, name), "--tool", "30 -20 240 5", "--part", FRAMES[name][3])
    more = ("--cam", job.toolpath.name, "--stiffness", "unknown", "--controller", "krl")
    done = CliRunner().invoke(main, ["init", *answers, *more])
    assert done.exit_code == 0, done.output
    assert f'tip = "{FRAMES[name][0]}": tools are taken as measured from this frame' in done.stderr
    return tmp_path / "cell.toml"


def test_the_tool_in_the_program_hangs_on_the_makers_frame(new_cell: Path) -> None:
    """Pinocchio's own reading of the URDF: its frame times the written $TOOL is the TCP that is modelled."""
    cell = tomllib.loads(new_cell.read_text())
    robot = new_cell.parent / cell["robot"]
    frame = FRAMES[robot.stem][0]
    assert cell["tip"] == frame == tomllib.loads((new_cell.parent / "stiffness.toml").read_text())["tip"]
    arm = load_arm(load_cell(new_cell)).robot
    (new_cell.parent / "out").mkdir(exist_ok=True)
    done = compensate_file(new_cell.parent / "path.csv", new_cell, new_cell.parent / "out" / "a.src")
    assert not [f for f in done.findings if "measured from" in f.what]
    text = (new_cell.parent / "out" / "a.src").read_text(encoding="latin-1")
    found = re.search(r"\$TOOL=\{FRAME: " + ",".join(f"{k} ([-0-9.]+)" for k in "XYZABC"), text)
    x, y, z, a, b, c = map(float, found.groups())
    tool = placement(pin.rpy.rpyToMatrix(*np.radians([c, b, a])), np.array([x, y, z]) * 1e-3)
    np.testing.assert_allclose(tool[:3, 3], [0.03, -0.02, 0.24], atol=1e-9)
    model = pin.buildModelFromUrdf(str(robot))
    data = model.createData()
    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (50, 6)):
        full = pin.neutral(model)
        for joint, angle in zip(arm.joint_names, q, strict=True):
            full[model.joints[model.getJointId(joint)].idx_q] = angle
        pin.framesForwardKinematics(model, data, full)
        base, flange = (data.oMf[model.getFrameId(name)] for name in (arm.base, frame))
        theirs = (base.inverse() * flange).homogeneous @ tool
        modelled = arm.pose(q) @ placement(np.eye(3), [0.03, -0.02, 0.24])
        assert np.abs(theirs - modelled).max() < 1e-9 and np.linalg.norm(modelled[:3, 3]) > 0.05


@pytest.mark.parametrize("name", FRAMES)
def test_a_cell_that_does_not_tell_is_warned_of(name: str, tmp_path: Path, shared: Path) -> None:
    """With distance, angle and what to write; nothing where the cell tells."""
    frame, distance, angle, _ = FRAMES[name]
    robot = urdf(shared, tmp_path, name)
    base, last = (getattr(load_robot(str(tmp_path / robot)), key) for key in ("base", "tip"))
    job = files(tmp_path, {"robot": robot, "base": base, "tip": None}, {"robot": robot})
    (found,) = load_arm(load_cell(job.cell)).findings
    assert found.level == "warning" and f"from {last!r}" in found.what
    assert f"{frame!r} stands {distance * 1e3:g} mm away, turned by {angle:g} deg" in found.what
    assert f'tip = "{frame}" in cell and model' in found.remedy and f'tip = "{last}" in the cell' in found.remedy
    for tip, model in ((last, None), (frame, frame)):
        job = files(tmp_path, {"robot": robot, "base": base, "tip": tip}, {"robot": robot, "tip": model})
        assert load_arm(load_cell(job.cell)).findings == ()


def test_the_warning_changes_no_number(tmp_path: Path, shared: Path) -> None:
    """A cell without tip is what it was: the last moving link, in all that is written."""
    rows = []
    for k, tip in enumerate((None, "link_6")):
        (tmp_path / str(k)).mkdir()
        robot = urdf(shared, tmp_path / str(k), KR210)
        job = files(tmp_path / str(k), {"robot": robot, "tip": tip}, {"robot": robot})
        done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
        assert len([f for f in done.findings if "215 mm away" in f.what]) == (tip is None)
        rows.append(columns(job.out / "a.csv", "x_mm", "q1_deg", "q6_deg"))
    np.testing.assert_array_equal(*rows)


OFFSET = {"kinematic-offset": {"x_m": [0.0] * 5 + [1e-3]}}


@pytest.mark.parametrize(
    ("cell", "model", "more", "words"),
    [
        ("tool0", None, {}, r'those of joints and hold for any tip of the arm: set tip = "tool0" in the model'),
        (None, "tool0", {}, r'from tool0, as controllers do, write tip = "tool0" here; if they are from link_6'),
        ("tool0", "flange", OFFSET, r"its kinematic-offset is in the axes of"),
    ],
)
def test_the_model_of_another_tip(
    cell: str | None, model: str | None, more: dict, words: str, tmp_path: Path, shared: Path
) -> None:
    """The refusal tells what holds and what to write; where it is followed, the cell runs."""
    robot = urdf(shared, tmp_path, KR210)
    made = {"robot": robot, "tip": model, "effects": {**MODEL["effects"], **more}}
    job = files(tmp_path, {"robot": robot, "tip": cell}, made)
    with pytest.raises(CellError, match=words):
        preview_file(job.toolpath, job.cell)
    if not more:
        job = files(tmp_path, {"robot": robot, "tip": "tool0"}, {"robot": robot, "tip": "tool0"})
        assert preview_file(job.toolpath, job.cell).report


def test_a_known_model_of_another_tip_is_refused_by_init(tmp_path: Path, shared: Path) -> None:
    robot = urdf(shared, tmp_path, KR210)
    job = files(tmp_path, {}, {"robot": robot})
    asked = {"robot": str(tmp_path / robot), "tool": "0 0 240 30", "part": "1500 0 800", "cam": str(job.toolpath)}
    asked |= {"stiffness": str(tmp_path / "model.toml"), "controller": "krl"}
    with pytest.raises(CompensatorError, match=r"tip 'link_6', the cell has 'tool0'.*set tip = \"tool0\" in the"):
        init_files(asked, output=tmp_path / "n.toml")
    assert not (tmp_path / "n.toml").exists()


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", ("tool0", True, True)),
        ('"tool0"', '"arm_tool0"', ("arm_tool0", True, True)),
        ('"tool0"', '"hand"', ("flange", False, True)),  # x of REP 199 points out of it
        ('"tool0"', '"makers_flange"', ("makers_flange", True, True)),
        ('"(tool0|flange)"', '"no\\1"', None),
    ],
)
def test_which_frame_is_taken(old: str, new: str, expected: tuple | None, tmp_path: Path, shared: Path) -> None:
    text = (shared / "data" / "robots" / f"{KR210}.urdf").read_text()
    (tmp_path / "r.urdf").write_text(re.sub(old, new, text) if old else text)
    frame = load_robot(str(tmp_path / "r.urdf")).flange_frame
    assert expected == (None if frame is None else (frame.name, frame.on_axis, frame.away))


def test_a_urdf_without_such_a_frame_is_asked_about(tmp_path: Path, shared: Path) -> None:
    """Init names no tip then, and says which link it takes."""
    text = (shared / "data" / "robots" / f"{KR210}.urdf").read_text()
    (tmp_path / "r.urdf").write_text(re.sub('"(tool0|flange)"', r'"no\1"', text))
    job = files(tmp_path)
    asked = {"robot": str(tmp_path / "r.urdf"), "tool": "0 0 240 30", "part": "1500 0 800", "cam": str(job.toolpath)}
    done = init_files({**asked, "stiffness": "unknown", "controller": "krl"}, output=tmp_path / "n.toml")
    assert "neither tool0 nor a flange: tools are taken as measured from 'link_6'" in str(done.report["findings"])
    assert "tip" not in tomllib.loads((tmp_path / "n.toml").read_text())
