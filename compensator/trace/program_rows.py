"""Rows of the program that a trace belongs to: PROGRAM as csv, as compensate and preview write it, in the base."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.errors import TraceError
from compensator.process.path_axes import path_axes
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.session.path_trace import CommandedRows
from stiffness.session.table import CsvTable, read_table
from stiffness.statics.tool import Tool
from stiffness.text_file import file_bytes
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import CUT, RAPID

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

POSITION = ("x_mm", "y_mm", "z_mm")
QUATERNION = ("qw", "qx", "qy", "qz")
WRENCH = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
NEEDED = ("index", "kind", *POSITION, *QUATERNION)
ASIDE = 1e-4  # m: pose and joints of a row are one command, written with six digits
OUTSIDE = 1e-3  # rad beyond a limit that rounding explains


@dataclass(frozen=True)
class RunsWith:
    """What a program ran with: robot, tool, base -> frame of the program, and where it came from (signs, (n,))."""

    robot: Robot
    tool: Tool
    workobject: Frame
    start: Floats | None
    approach: tuple[int, ...] | None
    dry: bool


def read_program(label: str, path: Path, given: RunsWith) -> tuple[CommandedRows, str]:
    """The rows of a program, and the sha256 of its file.

    Args:
        label: what messages call the file.

    Raises:
        TraceError, SessionError: names file, row, column, value and what to do.
    """
    raw = file_bytes(label, path, TraceError)
    table = read_table(label, raw)
    joints = [f"q{k + 1}_deg" for k in range(given.robot.n)]
    _check_columns(table, joints)
    wrong = table.integers(["index"])[:, 0] != np.arange(len(table.line))
    table.refuse(wrong, ["index"], "rows are counted from 0 without a gap: give the program as it was written")
    cut = _cuts(table)
    q = np.radians(table.numbers(joints))
    low, high = given.robot.lower - OUTSIDE, given.robot.upper + OUTSIDE
    table.refuse((q < low) | (q > high), joints, f"outside the limits of {given.robot.name}; is it the robot that ran?")
    commanded = _poses(table, "", given.workobject)
    _check_pose(table, given, q, commanded)
    nominal = _poses(table, "nominal_", given.workobject) if "nominal_x_mm" in table.cells else commanded
    rows = CommandedRows(
        q=q,
        position=commanded.origin,
        nominal=nominal.origin,
        wrench=_wrench(table, cut, given.dry),
        path_axes=path_axes(nominal.origin, nominal.rotation, np.where(cut, CUT, RAPID).astype(np.uint8)),
        cut=cut,
        feed=_feed(table),
        first=_first(given, q[0]),
    )
    return rows, hashlib.sha256(raw).hexdigest()


def _check_columns(table: CsvTable, joints: list[str]) -> None:
    missing = [name for name in (*NEEDED, *joints) if name not in table.cells]
    if missing:
        raise TraceError(
            f"{table.label}: column {', '.join(missing)} missing: expected the program as csv, as `compensate -o "
            "PROGRAM.csv --format csv` or `preview --csv` writes it"
        )


def _cuts(table: CsvTable) -> npt.NDArray[np.bool_]:
    kind = np.array(table.cells["kind"])
    table.refuse(~np.isin(kind, ("rapid", "cut")), ["kind"], "expected rapid or cut")
    return np.asarray(kind == "cut")


def _poses(table: CsvTable, prefix: str, workobject: Frame) -> Frame:
    """(R) of the TCP in the base."""
    position = table.numbers([f"{prefix}{name}" for name in POSITION]) / 1e3
    names = [f"{prefix}{name}" for name in QUATERNION]
    quaternion = table.numbers(names)
    off = np.abs(np.linalg.norm(quaternion, axis=1) - 1) > 1e-3
    table.refuse(off, [names[0]], "qw, qx, qy, qz have to be of length 1")
    return workobject.then(Frame(matrix_from_quaternion(quaternion), position))


def _check_pose(table: CsvTable, given: RunsWith, q: Floats, commanded: Frame) -> None:
    """Refuse a program of another robot, tool or work object: its joints do not lead to its poses."""
    angle = ca.SX.sym("q", given.robot.n)
    rotation, origin = given.robot.flange_symbolic(angle)
    tcp = origin + ca.mtimes(rotation, ca.SX(ca.DM(given.tool.position)))
    (reached,) = Kernel(ca.Function("tcp", [angle], [ca.densify(tcp)])).run(q)
    off = np.linalg.norm(reached - commanded.origin, axis=1)
    worst = float(off.max()) * 1e3
    why = (
        f"its joints lead to a TCP {worst:.4g} mm away: robot, tool and work object of the cell are not those that the "
        "program was made with; correct the cell"
    )
    table.refuse(off > ASIDE, ["x_mm"], why)


def _wrench(table: CsvTable, cut: npt.NDArray[np.bool_], dry: bool) -> Floats:
    """(R, 6); of a rapid, or where all ran in the air, zero."""
    out = np.zeros((len(cut), 6))
    if dry:
        return out
    if not table.has(WRENCH):
        missing = ", ".join(WRENCH)
        raise TraceError(f"{table.label}: column {missing} missing: add what the process assumed, or set dry = true")
    if all(not any(table.cells[name]) for name in WRENCH):
        raise TraceError(f"{table.label}: columns {', '.join(WRENCH)} are empty: fill them, or set dry = true")
    out[cut] = table.numbers(WRENCH)[cut]
    return out


def _feed(table: CsvTable) -> Floats:
    """(R,) m/s; NaN where a cell is empty."""
    if "feed_mm_min" not in table.cells:
        return np.full(len(table.line), np.nan)
    filled = tuple(cell or "0" for cell in table.cells["feed_mm_min"])
    feed = CsvTable(table.label, {"feed_mm_min": filled}, table.line).numbers(["feed_mm_min"])[:, 0]
    table.refuse(feed < 0, ["feed_mm_min"], "a feed is not negative")
    return np.where(feed > 0, feed, np.nan) / 6e4


def _first(given: RunsWith, q: Floats) -> Ints:
    """(n,) sign of the last rotation before row 0; 0 where it is not known."""
    if given.approach is not None:
        return np.array(given.approach, dtype=np.int64)
    if given.start is None:
        return np.zeros(len(q), dtype=np.int64)
    move = q - given.start
    return np.where(np.abs(move) > MOVED, np.sign(move), 0).astype(np.int64)


MOVED = 1e-6  # rad: less is the rounding of a file
