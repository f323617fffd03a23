"""The turn about the tool axis that a file leaves open: continuous, kept or chosen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.cell.job import load_job
from compensator.errors import PathError
from compensator.path.free_turn import reference_rotation, varying_turn
from compensator.path.planned_path import PlannedPath
from stiffness.robot.load import load_robot
from tests.compensator.handmade_toolpaths import angle, toolpath, wandering_axes
from tests.compensator.posture_toolpaths import frame, job_at, poses_at
from tests.compensator.small_job import ABB, CELL, ROWS, Files, files
from toolpaths.files import read_toolpath


def check_reference(axis: np.ndarray) -> np.ndarray:
    """Orthonormal, z = -axis, and never turning faster than the axis does (but for a bounded factor)."""
    rotation = reference_rotation(toolpath(np.zeros((len(axis), 3)), axis=axis))
    assert np.allclose(np.swapaxes(rotation, 1, 2) @ rotation, np.eye(3), atol=1e-12)
    assert np.allclose(rotation[:, :, 2], -axis, atol=1e-12) and np.allclose(np.linalg.det(rotation), 1)
    turned = angle(rotation[:-1], rotation[1:])
    step = np.arccos(np.clip(np.sum(axis[:-1] * axis[1:], axis=1), -1, 1))
    assert np.all(turned <= 5.0 * step + 1e-7), (turned / np.maximum(step, 1e-12)).max()
    return rotation


@pytest.mark.parametrize("seed", range(8))
def test_the_reference_is_continuous(seed: int) -> None:
    """Random axis fields: near a pole, through poles, half and all the way round."""
    g = np.random.default_rng(seed)
    for spread in (0.1, 0.8, 1.6, 3.0):
        check_reference(wandering_axes(400, seed, g.normal(size=3), spread))
    check_reference(wandering_axes(400, seed, [0, 0, 1], 0.5))


@pytest.mark.parametrize("pole", [*np.eye(3), *-np.eye(3)])
def test_right_through_a_pole(pole: np.ndarray) -> None:
    """The axis passes exactly along x, y or z of the work object, from 40 deg before to 40 deg behind."""
    side = np.roll(pole, 1)
    t = np.radians(np.linspace(-40, 40, 321))
    axis = np.cos(t)[:, None] * pole + np.sin(t)[:, None] * side
    check_reference(axis)


def test_over_all_poles() -> None:
    """A path whose axis visits x, y and z: no fixed direction serves, x is carried along."""
    keys = Rotation.from_rotvec(np.pi / 2 * np.linspace(0, 1, 200)[:, None] * np.eye(3)[1])
    to_x = keys.apply([0, 0, 1.0])
    more = Rotation.from_rotvec(np.pi / 2 * np.linspace(0, 1, 200)[:, None] * np.eye(3)[2]).apply([1.0, 0, 0])
    axis = np.concatenate([to_x, more])
    assert np.allclose(np.abs(axis).max(axis=0), 1)
    check_reference(axis)


def planned(job: Files) -> tuple[PlannedPath, Any]:
    """The path as the planner follows it, without sampling."""
    loaded = load_job(job.cell)
    return loaded.planner.plan(read_toolpath(job.toolpath)), loaded.arm


def test_quaternions_of_a_file_are_kept(tmp_path: Path) -> None:
    """Free turn or not: what the file fixes is what the TCP does; no turn is added."""
    degrees = np.linspace([10, 15, 20, 30, 40, -20], [14, 18, 24, 35, 45, -10], 7)
    expected = np.array([frame(CELL["workobject"]) @ p for p in poses_at(ABB, np.radians(degrees))])
    for change in ({}, {"solve": {"free_tool_axis": True}}, {"solve": {"free_tool_axis": True}, "start": None}):
        path, _ = planned(job_at(tmp_path, ABB, degrees.tolist(), change))
        assert np.all(path.turn == 0)
        assert np.allclose(path.tcp.rotation, expected[:, :3, :3], atol=1e-9)
        assert np.allclose(path.tcp.origin, expected[:, :3, 3], atol=1e-9)
        if change.get("start", 1):
            assert np.allclose(np.degrees(path.q), degrees, atol=1e-6)


def test_a_fixed_turn_is_that_of_the_start(tmp_path: Path) -> None:
    """free_tool_axis = false, the file leaves the turn open: constant, as the tool stands at [start]."""
    start = [5.0, 10.0, 15.0, 25.0, 50.0, 0.0]
    job = files(tmp_path, {"start": {"joints": start}, "solve": {"free_tool_axis": False}})
    path, _ = planned(job)
    tool = load_robot(ABB).pose(np.radians(start))[:3, :3] @ frame(CELL["tool"])[:3, :3]
    assert np.all(path.turn == path.turn[0])

    # no other turn about z brings the TCP nearer to how it stands at [start]
    def away(turn: float) -> float:
        return float((Rotation.from_matrix(tool.T @ path.tcp.rotation[0]) * Rotation.from_euler("z", turn)).magnitude())

    assert away(0) <= min(away(t) for t in np.linspace(-3, 3, 61)) + 1e-9
    job = files(tmp_path, {"solve": {"free_tool_axis": False}})
    path, _ = planned(job)
    assert np.all(path.turn == 0)
    assert np.allclose(path.tcp.rotation, frame(CELL["workobject"])[:3, :3] @ np.diag([1, -1, -1]), atol=1e-12)


@pytest.mark.parametrize("turns", [(0, 0, 0), (0, 360, 0), (0, -360, 0), (0, 0, 360), (0, 0, -360)])
def test_start_picks_configuration_and_turns(tmp_path: Path, turns: tuple[float, float, float]) -> None:
    """Axes 4 and 6 have +-300 deg: [start] decides between 160 and -200."""
    q4, q6 = (150.0 + turns[1]) if turns[1] <= 0 else -150.0, -120.0
    q6 = {0: -120.0, 360: 240.0, -360: -120.0}[int(turns[2])]
    degrees = [[10.0, 15.0, 20.0, q4, 40.0, q6], [11.0, 16.0, 21.0, q4 + 3, 42.0, q6 + 2]]
    job = job_at(tmp_path, ABB, degrees)
    path, _ = planned(job)
    assert np.allclose(np.degrees(path.q), degrees, atol=1e-6)
    flipped = [10.0, 15.0, 20.0, q4 - 180 if q4 > 0 else q4 + 180, -40.0, q6 + 180 if q6 < 0 else q6 - 180]
    job = job_at(tmp_path, ABB, degrees, {"start": {"joints": flipped}})
    path, loaded = planned(job)
    assert np.allclose(np.degrees(path.q[0]), flipped, atol=1e-6)
    assert np.unique(path.branch) == int(loaded.inverse.configuration(np.radians([flipped]))[0])


@pytest.mark.parametrize("seed", [3, 7, 11])
def test_start_picks_the_configuration_of_an_arm_without_closed_form(tmp_path: Path, seed: int) -> None:
    """UR10: of up to eight postures of the first pose, the one that [start] is near, in its turn of +-360 deg."""
    g = np.random.default_rng(seed)
    first = g.uniform(-120, 120, 6)
    first[[2, 4]] = g.choice([-1, 1], 2) * g.uniform(40, 120, 2)
    first[0] += 200 * np.sign(first[0])  # beyond half a turn
    start = first + g.uniform(-12, 12, 6)
    cell = {"start": {"joints": start.tolist()}, "tool": {"mass": 1.0}}
    path, _ = planned(job_at(tmp_path, "ur10", [first.tolist(), (first + 1).tolist()], cell))
    assert np.allclose(np.degrees(path.q[0]), first, atol=1e-6)


def test_without_a_start_the_whole_path_is_inside_the_limits(tmp_path: Path) -> None:
    """And every pose stands where the file says, tool axis included."""
    path, loaded = planned(files(tmp_path))
    assert np.all((path.q > loaded.robot.lower) & (path.q < loaded.robot.upper))
    work, tool = frame(CELL["workobject"]), frame(CELL["tool"])
    for q, row in zip(path.q, ROWS, strict=True):
        pose = np.linalg.inv(work) @ loaded.robot.pose(q) @ tool
        assert np.allclose(pose[:3, 3] * 1e3, row[:3], atol=1e-6)
        assert np.allclose(pose[:3, 2], [0, 0, -1], atol=1e-9)


def test_a_turn_that_has_to_vary(tmp_path: Path) -> None:
    """A full circle with the tool in a ring around axis 1: with a constant turn axis 6 would run out of its limits."""
    t = np.radians(np.arange(-150, 151, 5))
    rows = [[1700 * np.cos(a), 1700 * np.sin(a), 0, 0, 0, 1, 600, "cut"] for a in t]
    robot = (Path(__file__).resolve().parents[3] / "stiffness" / "robot" / "data" / f"{ABB}.toml").read_text()
    narrow = robot.replace("limits = [-300.0, 300.0]", "limits = [-60.0, 60.0]").replace(ABB, "narrow")
    assert narrow.count("-60.0, 60.0") == 2
    (tmp_path / "narrow.toml").write_text(narrow)
    tight = {
        "robot": "narrow.toml",
        "workobject": {"xyz": [0.0, 0.0, 800.0], "rpy": [0.0, 0.0, 0.0]},
        "tool": {"rpy": [0.0, 0.0, 0.0]},
        "process": {"kind": "constant", "frame": "path", "wrench": [-100.0, 50.0, -40.0, 0.0, 0.0, 0.0]},
    }
    job = files(tmp_path, tight, {"robot": "narrow.toml"}, rows=rows)
    path, loaded = planned(job)
    assert np.ptp(path.turn) > np.radians(100)
    assert np.all((path.q >= loaded.robot.lower) & (path.q <= loaded.robot.upper))
    assert np.abs(np.diff(path.q, axis=0)).max() < np.radians(30)
    tool = frame({**CELL["tool"], "rpy": [0.0, 0.0, 0.0]})
    for q, row in zip(path.q, rows, strict=True):
        pose = loaded.robot.pose(q) @ tool
        assert np.allclose(pose[:3, 3] * 1e3, [row[0], row[1], 800], atol=1e-6) and pose[2, 2] < -1 + 1e-9
    fixed = files(tmp_path, {**tight, "solve": {"free_tool_axis": False}}, {"robot": "narrow.toml"}, rows=rows)
    with pytest.raises(PathError):
        planned(fixed)


def test_varying_turn_on_its_own() -> None:
    """A corridor of margins that wanders over 200 deg: the turn stays inside it; a closed gap has no turn."""
    path = toolpath(np.zeros((500, 3)))
    centre = np.radians(np.linspace(20, 220, 500))

    def margins(rows: np.ndarray, turns: np.ndarray) -> np.ndarray:
        off = np.angle(np.exp(1j * (turns[None] - centre[rows][:, None])))
        return np.where(np.abs(off) < np.radians(25), 1 - np.abs(off), -np.inf)

    turn = varying_turn(path, margins)
    assert turn is not None and len(turn) == 500
    off = np.angle(np.exp(1j * (turn - centre)))
    assert np.abs(off).max() < np.radians(26) and np.abs(np.diff(turn)).max() < np.radians(16)

    def closed(rows: np.ndarray, turns: np.ndarray) -> np.ndarray:
        return np.where((rows == 0)[:, None] | (np.abs(rows - 250) > 3)[:, None], margins(rows, turns), -np.inf)

    assert varying_turn(path, closed) is None
