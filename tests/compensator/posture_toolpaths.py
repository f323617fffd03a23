"""Toolpaths that go where the arm has certain joint angles: singularities and limits included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from stiffness.robot.load import load_robot
from tests.compensator.small_job import CELL, Files, files

QUATERNION = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "feed_mm_min", "kind")
FIXED = {"solve": {"free_tool_axis": False}}


def frame(table: Mapping[str, Any]) -> np.ndarray:
    """(4, 4) of a table with xyz (mm) and rpy (deg), by SciPy."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", table.get("rpy", (0, 0, 0)), degrees=True).as_matrix()
    pose[:3, 3] = np.array(table["xyz"]) / 1e3
    return pose


def poses_at(robot: str, q: np.ndarray, cell: Mapping[str, Any] = CELL) -> np.ndarray:
    """(N, 4, 4) TCP in the work object at joint angles (N, 6) rad: Pinocchio."""
    arm, tool, work = load_robot(robot), frame(cell["tool"]), frame(cell["workobject"])
    return np.array([np.linalg.inv(work) @ arm.pose(one) @ tool for one in q])


def rows_at(robot: str, degrees: Sequence[Sequence[float]], cell: Mapping[str, Any] = CELL) -> list[list[Any]]:
    """Rows of a csv with quaternions, all cutting, at joint angles in deg."""
    out = []
    for pose in poses_at(robot, np.radians(degrees), cell):
        x, y, z, w = Rotation.from_matrix(pose[:3, :3]).as_quat()
        out.append([*(float(v) for v in pose[:3, 3] * 1e3), *(float(v) for v in (w, x, y, z)), 600, "cut"])
    return out


def between(a: Sequence[float], b: Sequence[float], count: int) -> list[list[float]]:
    """Joint angles from a to b, evenly."""
    return np.linspace(a, b, count).tolist()


def job_at(
    folder: Path,
    robot: str,
    degrees: Sequence[Sequence[float]],
    cell: Mapping[str, Any] | None = None,
    model: Mapping[str, Any] | None = None,
) -> Files:
    """A job whose path goes through these joint angles, orientation fixed, starting in their configuration."""
    start = {"robot": robot, "start": {"joints": [float(v) for v in degrees[0]]}, **FIXED}
    change = {**start, **(cell or {})}
    return files(folder, change, {"robot": robot, **(model or {})}, rows_at(robot, degrees), QUATERNION)
