"""A work object that was touched off with the tool: against an independent arm that touches a part."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.errors import CellError, CompensatorError
from compensator.solve.touching_off import rigid_motion
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.robot.load import load_robot
from tests.compensator.independent_statics import Arm
from tests.compensator.small_job import ABB, CELL, STIFFNESS, columns, files

SPRINGS = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}
POINTS = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 60.0, 0.0], [100.0, 60.0, 5.0]]
ARM = Arm(load_robot(ABB), CELL["tool"], SPRINGS)
QUIET = {"process": {"kind": "constant", "frame": "base", "wrench": [0.0] * 6}}


def cell(touched: Any, **more: Any) -> dict[str, Any]:
    return {"gravity": "uncompensated", "workobject": {"touched_off": touched}, **more}


def angles(path: Path) -> np.ndarray:
    return np.radians(columns(path, *(f"q{k}_deg" for k in range(1, 7))))


def postures_at(folder: Path, points: list[list[float]]) -> np.ndarray:
    """(N, n) rad in which the arm cuts at points, as a preview finds them: its turn and configuration."""
    rows = [[*p, 0, 0, 1, 1000, "cut"] for p in points]
    job = files(folder, {"sampling": {"spacing": 1000.0}}, {"effects": SPRINGS}, rows=rows)
    preview_file(job.toolpath, job.cell, csv=job.out / "p.csv")
    return angles(job.out / "p.csv")


@pytest.mark.parametrize("count", [1, 2, 4])
def test_the_cut_lies_on_the_part_that_was_touched(tmp_path: Path, count: int) -> None:
    """Without a process the compensated TCP follows the part that stands where the sagged tool touched it.

    The part is placed by hand: the arm is commanded to every point, sags, and touches; a body through these points is
    fitted by scipy. One or two touches shift it, more also turn it.
    """
    job = files(tmp_path, cell(POINTS[:count], **QUIET), {"effects": SPRINGS})
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    plain = done.result.uncompensated
    work = done.result.job.placement.workobject
    nominal = work.at(np.array(POINTS[:count]) / 1e3)
    turned = plain.path.tcp.rotation[2]
    touched = []
    for p in nominal:  # the inverse kinematics of the product decides the posture, what happens there is the oracle's
        flange = np.eye(4)
        tool = done.result.job.arm.tools.first
        flange[:3, :3] = turned @ tool.rotation.T
        flange[:3, 3] = p - flange[:3, :3] @ tool.position
        every = done.result.job.planner.inverse.inverse.all(flange)
        options = [q for b, q in every if b == np.ravel(plain.path.branch)[0]]
        q = min(options, key=lambda o: float(np.abs(o - plain.path.q[2]).max()))
        touched.append(ARM.tcp(q, np.zeros(6))[:3, 3])
    shift = np.mean(np.array(touched) - nominal, axis=0)
    turn = np.eye(3)
    if count > 2:
        ours = np.array(touched) - np.mean(touched, axis=0)
        turn = Rotation.align_vectors(ours, nominal - nominal.mean(axis=0))[0].as_matrix()
    assert np.linalg.norm(shift) > 1e-3
    cut, centre = done.result.cutting, nominal.mean(axis=0)
    wanted = (done.result.path.tcp.origin[cut] - centre) @ turn.T + centre + shift
    real = np.array([ARM.tcp(q, np.zeros(6))[:3, 3] for q in angles(job.out / "a.csv")[cut]])
    np.testing.assert_allclose(real, wanted, atol=2e-8)
    # what is left to correct is how the sag varies over the part, not the sag
    most = {1: 0.6, 2: 0.3, 4: 0.04}[count]  # mm
    assert np.linalg.norm(done.result.correction[cut], axis=1).max() * 1e3 < most
    sizes = {name: share["max"] for name, share in done.report["deflection_mm"].items()}
    assert sizes["gravity"] > 1.0 and sizes["touched_off"] > 1.0
    assert done.report["predicted_error_mm"]["before"]["max"] < most
    total = np.sum([share["mean_xyz"] for share in done.report["deflection_mm"].values()], axis=0)
    np.testing.assert_allclose(total, plain.error_before[plain.cutting].mean(axis=0) * 1e3, atol=1e-12)


def test_a_posture_says_the_same_as_its_point(tmp_path: Path) -> None:
    (tmp_path / "q").mkdir()
    q = np.degrees(postures_at(tmp_path / "q", [POINTS[0], POINTS[1]])[0])
    reports = []
    for name, touched in (("point", [POINTS[0]]), ("posture", [[float(a) for a in q]])):
        (tmp_path / name).mkdir()
        job = files(tmp_path / name, cell(touched), {"effects": SPRINGS})
        reports.append(preview_file(job.toolpath, job.cell).report["deflection_mm"]["touched_off"])
    assert reports[0]["max"] == pytest.approx(reports[1]["max"], rel=1e-3)


def test_it_is_asked_for_where_weight_matters_and_nothing_is_said(tmp_path: Path) -> None:
    """Not where the controller knows the sag, and not where the cell answers, be it with nothing."""
    said = {}
    for name, more in {
        "silent": {"gravity": "uncompensated"},
        "known": {},
        "touched": cell([POINTS[0]]),
        "measured": cell([]),
    }.items():
        (tmp_path / name).mkdir()
        job = files(tmp_path / name, more, {"effects": SPRINGS})
        done = preview_file(job.toolpath, job.cell)
        said[name] = [f for f in done.findings if "touched off" in f.what]
        if name == "measured":
            assert "touched_off" not in done.report["deflection_mm"]
    assert {name: len(found) for name, found in said.items()} == {"silent": 1, "known": 0, "touched": 0, "measured": 0}
    (asked,) = said["silent"]
    assert asked.level == "warning" and "touched_off = [[x, y, z]" in asked.remedy


@pytest.mark.parametrize(
    ("touched", "words"),
    [
        ([[1.0, 2.0]], r"touched_off\[1\] has 2 numbers: expected the 3 of a point .* or the 6 of a posture"),
        ([[0.0] * 3, [0.0, 0.5 * np.pi, 0.0, 0.0, 1.0, 0.0]], r"touched_off\[2\] holds 1\.57\d*: expected deg"),
        ([["a", 0.0, 0.0]], r"workobject\.touched_off"),
    ],
)
def test_what_is_no_touch_is_refused(tmp_path: Path, touched: Any, words: str) -> None:
    job = files(tmp_path, cell(touched))
    with pytest.raises(CellError, match=words):
        preview_file(job.toolpath, job.cell)


@pytest.mark.parametrize(
    ("touched", "words"),
    [
        ([[0.0, 0.0, 0.0], [9000.0, 0.0, 0.0]], r"touched_off\[2\]: .* cannot touch \(9000\.00, 0\.00, 0\.00\) mm"),
        ([[0.0, 0.0, 0.0, 0.0, 150.0, 0.0]], r"touched_off\[1\]: joint 5 at 150 deg is outside -120 \.\.\. 120 deg"),
    ],
)
def test_where_the_arm_cannot_touch_is_refused(tmp_path: Path, touched: Any, words: str) -> None:
    job = files(tmp_path, cell(touched))
    with pytest.raises(CompensatorError, match=words):
        preview_file(job.toolpath, job.cell)


def test_rigid_motion_of_points() -> None:
    """A small motion is found again; points on a line leave the turn about it open: none is taken."""
    rng = np.random.default_rng(3)
    points, turn, shift = rng.normal(size=(6, 3)), np.array([1e-3, -2e-3, 5e-4]), np.array([1e-3, 2e-3, -3e-3])
    moved = Rotation.from_rotvec(turn).apply(points) + shift
    np.testing.assert_allclose(rigid_motion(points, moved).at(points), moved, atol=1e-14)
    line = np.outer([0.0, 1.0, 2.0], [1.0, 0.0, 0.0])
    found = rigid_motion(line, Rotation.from_rotvec([5e-3, 0.0, 1e-3]).apply(line))
    np.testing.assert_allclose(Rotation.from_matrix(found.rotation).as_rotvec(), [0.0, 0.0, 1e-3], atol=3e-6)
