"""Readings of the clamping method: a csv with motor torque against motor angle. Format: docs/clamped.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from stiffness.errors import StiffnessError
from stiffness.kinematics.jacobian import Conditioning
from stiffness.robot.robot import Robot
from stiffness.schema import meant
from stiffness.session.table import CsvTable, read_table
from stiffness.text_file import file_bytes

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

ANGLES = ("motor_angle_deg", "motor_angle_rad", "joint_angle_deg", "joint_angle_rad")
TORQUES = ("motor_torque_nm", "joint_torque_nm")
BRANCHES = ("loading", "unloading")
_FARTHEST = 0.05  # rad: a clamped joint winds up by a few mrad
_RIGID = 0.02  # smallest singular value; nearer to a singularity the clamp leaves links free to move


class ClampedError(StiffnessError):
    """Readings of the clamping method are refused. The message names file, row, column, value and remedy."""


@dataclass(frozen=True, repr=False, eq=False)
class ClampedReadings:
    """N readings, at the output side of the reducer.

    Attributes:
        source: the file.
        joint: (N,) counted from 0.
        angle: (N,) rad.
        torque: (N,) N*m.
        loading: (N,) whether the torque was growing.
        repeat: (N,) number of the load cycle.
        line: (N,) of the file.
    """

    source: str
    joint: Ints
    angle: Floats
    torque: Floats
    loading: Bools
    repeat: Ints
    line: Ints

    def __repr__(self) -> str:
        joints = ", ".join(str(k + 1) for k in np.unique(self.joint))
        return f"ClampedReadings({self.source!r}, {len(self.joint)} rows, joint {joints})"


def read_clamped(path: Path, robot: Robot) -> ClampedReadings:
    """Read a file of the clamping method.

    Raises:
        StiffnessError: names row and column.
    """
    table = read_table(str(path), file_bytes(str(path), path, ClampedError))
    angle_column, torque_column = _header(table, robot)
    joint = _joints(table, robot)
    angle, torque = table.numbers([angle_column])[:, 0], table.numbers([torque_column])[:, 0]
    if angle_column.endswith("_deg"):
        angle = np.radians(angle)
    ratio = _ratios(table, robot, joint, (angle_column, torque_column))
    if angle_column.startswith("motor_"):
        angle = angle / ratio
    if torque_column.startswith("motor_"):
        torque = torque * ratio
    table.refuse(
        np.abs(angle) > _FARTHEST, [angle_column],
        f"more than {np.degrees(_FARTHEST):.1f} deg at the joint: a clamped joint does not turn so far; count angles "
        "from where the motor stood without torque, and check deg or rad, motor or joint, and gear_ratio",
    )  # fmt: skip
    words = np.array(table.cells["branch"])
    table.refuse(~np.isin(words, BRANCHES), ["branch"], "expected loading or unloading")
    repeat = table.integers(["repeat"])[:, 0] if "repeat" in table.cells else np.ones(len(joint), dtype=np.int64)
    _postures(table, robot)
    arrays = (joint, angle, torque, words == "loading", repeat, table.line)
    for array in arrays:
        array.setflags(write=False)
    return ClampedReadings(str(path), *arrays)


def _header(table: CsvTable, robot: Robot) -> tuple[str, str]:
    """Names of the angle and of the torque column."""
    posture = _posture_columns(robot)
    known = ("joint", *ANGLES, *TORQUES, "gear_ratio", "branch", "repeat", *posture)
    for name in table.cells:
        if name not in known:
            _refuse_header(table, f"unknown column {name}{meant(name, known)}; known are {', '.join(known)}")
    for name in ("joint", "branch"):
        if name not in table.cells:
            _refuse_header(table, f"column {name} is missing")
    table.has(posture)
    chosen = []
    for family in (ANGLES, TORQUES):
        there = [name for name in family if name in table.cells]
        if len(there) != 1:
            found = f"there are {' and '.join(there)}" if there else "there is none"
            _refuse_header(table, f"expected one column of {', '.join(family)}; {found}")
        chosen.append(there[0])
    return chosen[0], chosen[1]


def _refuse_header(table: CsvTable, why: str) -> NoReturn:
    raise ClampedError(f"{table.label}: row 1: {why}")


def _posture_columns(robot: Robot) -> list[str]:
    return [f"q{k + 1}_deg" for k in range(robot.n)]


def _joints(table: CsvTable, robot: Robot) -> Ints:
    names = {**{str(k + 1): k for k in range(robot.n)}, **{name: k for k, name in enumerate(robot.joint_names)}}
    cells = table.cells["joint"]
    table.refuse(
        np.array([cell not in names for cell in cells]), ["joint"],
        f"no joint of {robot.name}: expected 1 ... {robot.n}, or one of {', '.join(robot.joint_names)}",
    )  # fmt: skip
    return np.array([names[cell] for cell in cells], dtype=np.int64)


def _ratios(table: CsvTable, robot: Robot, joint: Ints, columns: Sequence[str]) -> Floats:
    """(N,) turns of the motor per turn of the joint."""
    given = "gear_ratio" in table.cells
    if not any(name.startswith("motor_") for name in columns):
        if given:
            _refuse_header(table, "column gear_ratio, but angle and torque are at the joint: take it out")
        return np.ones(len(joint))
    if given:
        ratio = table.numbers(["gear_ratio"])[:, 0]
        wrong = (ratio < 1) | (ratio > 10_000)
        table.refuse(wrong, ["gear_ratio"], "expected turns of the motor per turn of the joint, 1 ... 10000")
        first = np.array([ratio[joint == k][0] for k in joint])
        table.refuse(ratio != first, ["gear_ratio"], "another ratio than in rows of this joint above: a joint has one")
        return ratio
    reducers = robot.reducers or (None,) * robot.n
    known = np.array([np.nan if r is None or r.gear_ratio is None else r.gear_ratio for r in reducers])
    table.refuse(
        np.isnan(known[joint]), ["joint"],
        f"{' and '.join(c for c in columns if c.startswith('motor_'))} need a column gear_ratio, or gear_ratio in "
        f"[joints.reducer] of the robot file of {robot.name}",
    )  # fmt: skip
    return np.asarray(known[joint])


def _postures(table: CsvTable, robot: Robot) -> None:
    """Refuse postures in which the clamp does not hold the links, where the file has joint angles."""
    names = _posture_columns(robot)
    if names[0] not in table.cells:
        return
    q = np.radians(table.numbers(names))
    table.refuse((q < robot.lower - 1e-9) | (q > robot.upper + 1e-9), names, f"beyond the limits of {robot.name}")
    smallest = Conditioning(robot)(q)
    table.refuse(
        smallest < _RIGID, names[:1],
        "the arm stands near a singularity: there the clamp leaves links free to move, and a joint looks too soft",
    )  # fmt: skip
