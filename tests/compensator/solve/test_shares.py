"""What a deflection is made of: every share against an independent statics, and their sum against the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.tasks.compensate import Done, compensate_file, preview_file
from stiffness.robot.load import load_robot
from tests.compensator.independent_statics import Arm
from tests.compensator.small_job import ABB, CELL, GAPS, STIFFNESS, columns, files

SPRINGS = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}
HEAVY: dict[str, Any] = {"gravity": "uncompensated"}
WORN = {"preload-softening": {"ratio": [0.75] + [1.0] * 5}, "backlash": GAPS}
OFFSETS = {"kinematic-offset": {"zero_rad": [1e-3, -5e-4, 0.0, 0.0, 2e-4, 0.0]}}
HEAT = {"thermal-drift": {"expansion_per_k": [0.0, 1e-5, 1e-5, 1e-5, 0.0, 0.0, 0.0]}}
NAMES = ("gravity", "process", "joint_state", "offsets", "temperature", "interaction")


def previewed(folder: Path, cell: dict[str, Any], effects: dict[str, Any]) -> tuple[Done, np.ndarray]:
    """The preview, and the joint angles (M, n) rad of its cutting poses."""
    job = files(folder, cell, {"effects": {**SPRINGS, **effects}})
    done = preview_file(job.toolpath, job.cell, csv=job.out / "p.csv")
    q = np.radians(columns(job.out / "p.csv", *(f"q{k}_deg" for k in range(1, 7))))
    return done, q[done.result.cutting]


def sum_of(done: Done) -> np.ndarray:
    """(3,) mm: the mean vectors of all shares, added up."""
    return np.sum([share["mean_xyz"] for share in done.report["deflection_mm"].values()], axis=0)


def test_weight_and_process_alone_are_those_of_an_independent_arm(tmp_path: Path) -> None:
    """Each as if the other were not there; together they make the deflection but for what K_c adds, to the last bit."""
    done, q = previewed(tmp_path, HEAVY, {})
    robot = load_robot(ABB)
    arm = Arm(robot, CELL["tool"], SPRINGS)
    weightless = Arm(robot, {**CELL["tool"], "mass": 0.0}, SPRINGS, calibrated_out=True)
    result, cut = done.result, done.result.cutting
    nominal, wrench = result.path.tcp.origin[cut], result.wrench[cut]
    sag = np.array([arm.tcp(a, np.zeros(6))[:3, 3] for a in q]) - nominal
    push = np.array([weightless.tcp(a, w)[:3, 3] for a, w in zip(q, wrench, strict=True)]) - nominal
    shares = done.judged.shares
    assert np.abs(sag).max() > 1e-3 and np.abs(push).max() > 3e-4
    np.testing.assert_allclose(shares["gravity"], sag, atol=1e-10)
    np.testing.assert_allclose(shares["process"], push, atol=2e-5)  # the arm there has the load at another posture
    assert 1e-7 < np.abs(shares["interaction"]).max() < 0.03 * np.abs(push).max()
    np.testing.assert_allclose(sum(shares.values()), result.error_before[cut], atol=1e-15)
    assert done.report["deflection_mm"]["gravity"]["max"] == pytest.approx(np.linalg.norm(sag, axis=1).max() * 1e3)
    np.testing.assert_allclose(sum_of(done), result.error_before[cut].mean(axis=0) * 1e3, atol=1e-12)


def test_each_cause_has_its_own_share(tmp_path: Path) -> None:
    """Joint states, offsets and heat: each is there when its cause is, of the size of its cause, and adds up."""
    cell = {**HEAVY, "temperature": 30.0}
    seen = {}
    for name, effects in {"none": {}, "joint_state": WORN, "offsets": OFFSETS, "temperature": HEAT}.items():
        folder = tmp_path / name
        folder.mkdir()
        done, q = previewed(folder, cell, effects)
        assert tuple(done.report["deflection_mm"]) == NAMES
        cut = done.result.cutting
        np.testing.assert_allclose(sum_of(done), done.result.error_before[cut].mean(axis=0) * 1e3, atol=1e-12)
        seen[name] = {k: v["max"] for k, v in done.report["deflection_mm"].items()}
        for other in ("joint_state", "offsets", "temperature"):
            assert (seen[name][other] > 0.02) == (other == name), (name, other)
        if name == "offsets":
            robot, tool = load_robot(ABB), np.eye(4)
            zero = np.array(OFFSETS["kinematic-offset"]["zero_rad"])
            tool[:3, 3] = np.array(CELL["tool"]["xyz"]) / 1e3
            moved = np.array([((robot.pose(a + zero) - robot.pose(a)) @ tool)[:3, 3] for a in q])
            np.testing.assert_allclose(done.judged.shares["offsets"], moved, atol=1e-10)
    for name in ("joint_state", "offsets", "temperature"):  # the weight alone does not know of them
        assert seen[name]["gravity"] == pytest.approx(seen["none"]["gravity"], rel=0.01)
    # three links of about a metre and a half, ten kelvin: a hundredth of a per cent
    assert 0.1 < seen["temperature"]["temperature"] < 0.4


def test_the_controller_that_knows_the_sag_leaves_no_weight(tmp_path: Path) -> None:
    done, _ = previewed(tmp_path, {}, {})
    assert done.report["deflection_mm"]["gravity"]["max"] < 1e-9
    assert done.report["deflection_mm"]["process"]["max"] > 0.3


def test_preview_and_compensate_tell_the_same_of_the_same_path(tmp_path: Path) -> None:
    """The uncompensated path has one set of figures, though the compensated one has more poses."""
    job = files(tmp_path, HEAVY, {"effects": {**SPRINGS, **WORN}})
    shown, made = preview_file(job.toolpath, job.cell), compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    assert made.report["n_poses"] > shown.report["n_poses"]
    assert made.report["predicted_error_mm"]["before"] == shown.report["predicted_error_mm"]["before"]
    for key in ("deflection_mm", "tool_direction"):
        assert made.report[key] == shown.report[key]
