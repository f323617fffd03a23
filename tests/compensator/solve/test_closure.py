"""The solve against the same physics written once more: every deflected TCP stands where the file wants it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.tasks.compensate import Done, compensate_file, preview_file
from stiffness.robot.load import load_robot
from tests.compensator.independent_statics import Arm, compliance
from tests.compensator.posture_toolpaths import frame
from tests.compensator.small_job import CELL, MODEL, STIFFNESS, Files, columns, files, merged
from toolpaths.rotation import matrix_from_rpy

TILTED = [
    [0, 0, 80, 0, 0, 1, 0, "rapid"],
    [0, 0, 5, 0, 0, 1, 0, "rapid"],
    [0, 0, -2, 0, 0.1, 0.995, 300, "cut"],
    [100, 0, -2, 0.25, 0.1, 0.963, 1200, "cut"],
    [100, 60, 8, -0.1, -0.2, 0.9747, 1200, "cut"],
    [100, 60, 80, 0, 0, 1, 0, "rapid"],
]
HARD = {"windup_rad": [2e-4, 1e-4, 2e-4, 3e-4, 4e-4, 5e-4], "knee_nm": [300.0, 500.0, 200.0, 50.0, 40.0, 20.0]}
SPRING = {
    "linear_m_per_n": [2e-7, 3e-7, 1e-7],
    "angular_rad_per_nm": [5e-6, 4e-6, 8e-6],
    "coupling": [2e-8, -1e-8, 3e-8, 3e-7, -2e-7, 1e-7, 2e-7, 1e-7, -1e-7, 5e-7, -1e-7, 2e-7, 1e-7, 6e-7, -4e-7],
}
JOINTS = {"k_nm_per_rad": STIFFNESS}
SAGGING = {"gravity": "uncompensated", "solve": {"max_correction": 50.0}, "mount": {"rpy": [15.0, -25.0, 40.0]}}
UR10 = {
    "robot": "ur10",
    "workobject": {"xyz": [600.0, -250.0, 200.0], "rpy": [0.0, 0.0, 20.0]},
    "tool": {"xyz": [10.0, -5.0, 120.0], "mass": 3.0, "com": [0.0, 5.0, 50.0]},
    "process": {"kind": "constant", "frame": "path", "wrench": [-30.0, 20.0, 15.0, 0.5, -0.4, 0.3]},
    "start": {"joints": [0.0, 160.0, 97.0, 20.0, -66.0, -22.0]},
    "solve": {"free_tool_axis": False},  # the turns of an arm without a closed form take seconds to choose from
}
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "joints": ({}, {"joint-stiffness": JOINTS}),
    "joints that sag, tilted mount": (SAGGING, {"joint-stiffness": JOINTS}),
    "hardening joints": ({}, {"joint-stiffness": JOINTS, "joint-hardening": HARD}),
    "hardening joints that sag": (SAGGING, {"joint-stiffness": JOINTS, "joint-hardening": HARD}),
    "tool spring": ({}, {"joint-stiffness": JOINTS, "tool-compliance": SPRING}),
    "all that sags": (SAGGING, {"joint-stiffness": JOINTS, "joint-hardening": HARD, "tool-compliance": SPRING}),
    "ur10": (UR10, {"joint-stiffness": {"k_nm_per_rad": [3e4, 3e4, 2e4, 6e3, 5e3, 5e3]}}),
}


def written(folder: Path, cell: dict[str, Any], effects: dict[str, Any]) -> tuple[Files, Arm]:
    """The job, and the arm that its files describe."""
    whole = merged({**CELL, "process": None}, cell)
    robot = whole["robot"]
    job = files(folder, cell, {"robot": robot, "effects": effects}, TILTED)
    spring = compliance(effects["tool-compliance"]) if "tool-compliance" in effects else np.zeros((6, 6))
    mount = tuple(whole.get("mount", {}).get("rpy", (0.0, 0.0, 0.0)))
    return job, Arm(load_robot(robot), whole["tool"], effects, mount, whole["gravity"] == "calibrated-out", spring)


def off(arm: Arm, q: np.ndarray, wrench: np.ndarray, rotation: np.ndarray, position: np.ndarray) -> tuple[float, float]:
    """Largest distance (m) and angle (rad) of the deflected TCP from wanted poses."""
    poses = np.array([arm.tcp(a, w) for a, w in zip(q, wrench, strict=True)])
    turn = Rotation.from_matrix(np.swapaxes(poses[:, :3, :3], 1, 2) @ rotation).magnitude()
    return float(np.linalg.norm(poses[:, :3, 3] - position, axis=1).max()), float(turn.max())


@pytest.mark.parametrize("name", CASES)
def test_the_deflected_tcp_stands_on_the_nominal_path(tmp_path: Path, name: str) -> None:
    """To 1e-9 m and rad, before printing; and where the target is, is where the file says."""
    job, arm = written(tmp_path, *CASES[name])
    result = compensate_file(job.toolpath, job.cell, job.out / "a.csv").result
    some = np.unique([*range(0, len(result), 4), *np.flatnonzero(np.diff(result.cutting)), len(result) - 1])
    distance, angle = off(
        arm, result.command.q[some], result.wrench[some], result.target.rotation[some], result.target.origin[some]
    )
    assert distance < 1e-9 and angle < 1e-9
    assert np.linalg.norm(result.wrench[result.cutting], axis=1).min() > 30
    work = frame(merged(CELL, CASES[name][0])["workobject"])
    cut = result.cutting
    toolpath = result.path.toolpath
    wanted = toolpath.position[cut] @ work[:3, :3].T + work[:3, 3]
    assert np.abs(result.target.origin[cut] - wanted).max() < 1e-12
    assert np.abs(result.target.rotation[cut][:, :, 2] + toolpath.axis[cut] @ work[:3, :3].T).max() < 1e-12
    assert result.command.position.shape == (len(result), 3)
    # the printed command is the rigid forward kinematics of the commanded angles
    rigid = np.array([arm.robot.pose(q) @ frame(arm.tool) for q in result.command.q])
    assert np.abs(rigid[:, :3, 3] - result.command.position).max() < 1e-11
    assert np.linalg.norm(result.correction[cut], axis=1).min() > 1e-4


@pytest.mark.parametrize("name", ["joints that sag, tilted mount", "all that sags", "hardening joints", "ur10"])
def test_the_error_before(tmp_path: Path, name: str) -> None:
    """What a preview says of the nominal path, and its table in the csv."""
    job, arm = written(tmp_path, *CASES[name])
    done = preview_file(job.toolpath, job.cell, csv=job.out / "p.csv")
    result = done.result
    poses = np.array([arm.tcp(q, w) for q, w in zip(result.path.q, result.wrench, strict=True)])
    error = poses[:, :3, 3] - result.path.tcp.origin
    assert np.abs(error - result.error_before).max() < 1e-9
    assert np.abs(columns(job.out / "p.csv", "dx_mm", "dy_mm", "dz_mm") - error * 1e3).max() < 1e-6
    size = np.linalg.norm(error[result.cutting], axis=1) * 1e3
    before = done.report["predicted_error_mm"]["before"]
    assert before["mean"] == pytest.approx(size.mean(), abs=1e-6)
    assert before["max"] == pytest.approx(size.max(), abs=1e-6)
    assert before["p95"] == pytest.approx(np.percentile(size, 95), abs=1e-6)
    assert size.min() > 0.1


def test_the_csv_says_what_the_solve_found(tmp_path: Path) -> None:
    """Deflection at the command (own statics), wrench, and the residual error that the JSON gives."""
    job, arm = written(tmp_path, *CASES["all that sags"])
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    out = job.out / "a.csv"
    q = np.radians(columns(out, *(f"q{k}_deg" for k in range(1, 7))))
    wrench = columns(out, "fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
    deflected = np.array([arm.tcp(a, w) for a, w in zip(q, wrench, strict=True)])
    rigid = np.array([arm.robot.pose(a) @ frame(arm.tool) for a in q])
    assert np.abs((deflected - rigid)[:, :3, 3] * 1e3 - columns(out, "dx_mm", "dy_mm", "dz_mm")).max() < 2e-6
    after = done.report["predicted_error_mm"]["after"]
    assert 0 < after["max"] < 2e-6


def test_rpy() -> None:
    """R = Rz(yaw) Ry(pitch) Rx(roll): SciPy's fixed axes x, y, z."""
    g = np.random.default_rng(0)
    for degrees in g.uniform(-360, 360, (50, 3)):
        expected = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()
        assert np.allclose(matrix_from_rpy(np.radians(degrees)), expected, atol=1e-12)


def run(folder: Path, cell: dict[str, Any], rows: list[list[Any]] = TILTED) -> Done:
    """The small job, solved."""
    job = files(folder, cell, rows=rows)
    return compensate_file(job.toolpath, job.cell, job.out / "a.csv")


FADING = [
    [0, 0, 150, 0, 0, 1, 0, "rapid"],
    [0, 0, 2, 0, 0, 1, 0, "rapid"],
    [0, 0, -1, 0, 0, 1, 300, "cut"],
    [60, 0, -1, 0, 0, 1, 1200, "cut"],
    [60, 0, 60, 0, 0, 1, 0, "rapid"],
    [60, 80, 60, 0, 0, 1, 0, "rapid"],
    [60, 80, 2, 0, 0, 1, 0, "rapid"],
    [60, 80, -1, 0, 0, 1, 300, "cut"],
    [0, 80, -1, 0, 0, 1, 1200, "cut"],
    [-25, 80, -1, 0, 0, 1, 0, "rapid"],
    [-25, 80, 90, 0, 0, 1, 0, "rapid"],
]


@pytest.mark.parametrize("fz", [400.0, -400.0])
def test_rapids_keep_their_clearance(tmp_path: Path, fz: float) -> None:
    """Beyond the fade a rapid is nominal; within it, it moves sideways by a smooth step, and never into the part."""
    wrench = {"process": {"kind": "constant", "frame": "workobject", "wrench": [-300.0, 200.0, fz, 0.0, 0.0, 0.0]}}
    done = run(tmp_path, {**wrench, "sampling": {"spacing": 1.0}, "solve": {"fade": 20.0}}, FADING)
    result = done.result
    cut, position = result.cutting, result.path.tcp.origin
    size = np.linalg.norm(result.correction, axis=1)
    into = np.sum(result.correction * result.path.tcp.rotation[:, :, 2], axis=1)
    assert (into[cut].max() > 1e-4) if fz > 0 else (into[cut].min() < -1e-4)
    assert into[~cut].max() < 1e-9
    edges = np.flatnonzero(cut[1:] != cut[:-1])
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))])
    away = np.abs(along[:, None] - along[edges]).min(axis=1)
    far = ~cut & (away > 0.0201)
    assert far.sum() > 150 and size[far].max() < 1e-9
    near = ~cut & (away < 0.004)
    assert near.sum() >= 8 and size[near].min() > 1e-4
    # the step is smooth: 1.5 times its mean slope at most, at any sampled pose of a rapid
    step = np.linalg.norm(np.diff(result.correction, axis=0), axis=1)
    length = np.linalg.norm(np.diff(position, axis=0), axis=1)
    air = ~cut[1:] & ~cut[:-1]
    assert np.all(step[air] <= 1.6 * size.max() * length[air] / 0.02 + 1e-7)
    # sideways, a cut is entered and left without a jump
    side = result.correction - into[:, None] * result.path.tcp.rotation[:, :, 2]
    for e in edges:
        assert np.linalg.norm(side[e + 1] - side[e]) < 1.6 * size.max() * length[e] / 0.02 + 2e-5
    # the rapid between the two cuts stays at its height
    z = result.command.position[:, 2] - position[:, 2]
    assert z[~cut].min() > -1e-9


def test_the_fade_has_the_length_asked_for(tmp_path: Path) -> None:
    """A fade of 5 mm reaches 5 mm along the rapid, one of 50 mm 50."""
    for fade in (5.0, 50.0):
        done = run(tmp_path, {"sampling": {"spacing": 0.5}, "solve": {"fade": fade}}, FADING)
        result = done.result
        moved = np.linalg.norm(result.correction, axis=1) > 1e-6
        first = int(np.argmax(result.cutting)) - 1
        reach = result.path.tcp.origin[moved & (np.arange(len(moved)) <= first), 2] - result.path.tcp.origin[first, 2]
        assert reach.max() * 1e3 == pytest.approx(fade, abs=1.6 if fade > 10 else 0.6)


def test_without_complementary_stiffness(tmp_path: Path) -> None:
    """The switch leaves K_c out: on a soft arm the command changes by more than rounding, and less than a tenth."""
    soft = {"effects": {"joint-stiffness": {"k_nm_per_rad": [k / 10 for k in STIFFNESS]}}}
    wide = {"max_correction": 50.0}
    commands = []
    for k_c in (True, False):
        job = files(tmp_path, {"solve": {**wide, "complementary_stiffness": k_c}}, soft, TILTED)
        commands.append(compensate_file(job.toolpath, job.cell, job.out / "a.csv").result)
    a, b = (r.correction[r.cutting] for r in commands)
    change = np.linalg.norm(a - b, axis=1)
    assert change.min() > 1e-6 and change.max() < 0.1 * np.linalg.norm(a, axis=1).max()
    assert MODEL["effects"]["joint-stiffness"]["k_nm_per_rad"] == STIFFNESS
