"""A robot program as toolpath: the placement that it brings, and moves that are given in joint angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Arm, load_arm
from compensator.cell.cell_file import Cell
from compensator.cell.external_axes import as_programmed, external_notes, seen_from_base
from compensator.cell.job import Job, job_of
from compensator.cell.placement import Placement, placement_of
from compensator.errors import CellError
from compensator.path.plausible_path import path_doubts
from compensator.path.rapid_checks import rapid_findings
from compensator.path.tcp_inverse import TcpInverse
from compensator.program.program_frames import with_program_frames
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame
from toolpaths.interpreting.arcs import with_arcs
from toolpaths.rotation import matrix_from_unit_quaternion, quaternion_from_matrix
from toolpaths.toolpath import CUT, Setting, Toolpath, tool_axis

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

JOINT_STEP = np.radians(10.0)  # poses along a joint move are at most so far apart


def job_for(
    cell: Cell, toolpath: Toolpath, *, with_rapids: bool = False, arm: Arm | None = None
) -> tuple[Job, Toolpath]:
    """The job with the program's tool and work object, and its path with the poses that cutting needs.

    Args:
        with_rapids: for a program that is written anew: all moves between the first cut and the last are followed,
            and the retract behind it. Else, of the rapids, only those that a cut starts from, reached by a joint move:
            where the others lead (home, often singular) does not matter to the cut.
        arm: of this cell, where it is loaded.

    Raises:
        CellError: cell and program contradict each other, or neither has what is needed.
    """
    setting = toolpath.setting
    if setting is None:
        placement = placement_of(cell)
        found = (*rapid_findings(toolpath), *path_doubts(toolpath))
        return job_of(arm or load_arm(cell), placement, found), toolpath
    _refuse_free_axes(cell, toolpath)
    placement = placement_of(with_program_frames(cell, toolpath, setting))
    arm = arm or load_arm(cell)
    path = _followed(arm, placement, toolpath, setting, with_rapids=with_rapids)
    if placement.start is None and len(path):
        placement = replace(placement, start=_start(arm, placement, path, setting))
    path = _with_joint_moves(arm, placement, path, setting)
    whole = path if with_rapids else _with_all_rapids(arm, placement, toolpath, setting)
    found = (*(rapid_findings(whole) if whole else ()), *path_doubts(path))
    return job_of(arm, placement, (*external_notes(placement.external, toolpath), *found)), path


def _refuse_free_axes(cell: Cell, toolpath: Toolpath) -> None:
    for name, axis in cell.external.items():
        if axis.free:
            raise CellError(
                f"{cell.source}: external.{name}.free = true: {toolpath.source} is a robot program, whose axes stand "
                "where it has them; free is for CAM files: take it and its range away"
            )


def _followed(arm: Arm, placement: Placement, toolpath: Toolpath, setting: Setting, *, with_rapids: bool) -> Toolpath:
    """The poses that ``job_for`` follows, in the work object; none along joint moves yet."""
    toolpath = _under_tools_of_cuts(placement, toolpath, setting, with_rapids=with_rapids)
    path = seen_from_base(placement, with_joint_poses(placement, arm.robot, toolpath))
    return path.take(np.flatnonzero(_needed(path, setting, with_rapids=with_rapids)))


def _with_all_rapids(arm: Arm, placement: Placement, toolpath: Toolpath, setting: Setting) -> Toolpath | None:
    """The path with its rapids, for what is to be seen in them; None: one goes under a tool that nobody knows."""
    try:
        path = _followed(arm, placement, toolpath, setting, with_rapids=True)
    except CellError:
        return None
    return _with_joint_moves(arm, placement, path, setting)


def with_joint_poses(placement: Placement, robot: Robot, toolpath: Toolpath) -> Toolpath:
    """The poses that the robot gives of moves in joint angles, and the points of arcs that start there."""
    if toolpath.setting is None:
        return toolpath
    return with_arcs(as_programmed(placement, _with_positions(placement, robot, toolpath, toolpath.setting)))


def _with_positions(placement: Placement, robot: Robot, toolpath: Toolpath, setting: Setting) -> Toolpath:
    """Positions and orientations of moves that are given in joint angles, by forward kinematics."""
    if toolpath.quaternion is None or not setting.joints:
        return toolpath
    position, quaternion, axis = toolpath.position.copy(), toolpath.quaternion.copy(), toolpath.axis.copy()
    there = np.searchsorted(toolpath.row, np.array(list(setting.joints), dtype=np.float64))
    for k, q in zip(there.tolist(), setting.joints.values(), strict=True):
        if len(q) != robot.n:
            raise CellError(f"{toolpath.where(k)}: {len(q)} joint angles, {robot.name} has {robot.n}")
        position[k], quaternion[k] = _tcp(placement, robot, q, int(toolpath.tool[k]))
    axis[there] = tool_axis(quaternion[there])
    return replace(toolpath, position=position, quaternion=quaternion, axis=axis)


def _tcp(placement: Placement, robot: Robot, q: Floats, number: int) -> tuple[Floats, Floats]:
    """TCP in the work object: (3,) m and quaternion (4,)."""
    tool = placement.tools.tool(number)
    in_base = Frame.of(robot.pose(q)).then(Frame(tool.rotation, tool.position))
    tcp = in_base.relative_to(placement.workobject)
    return tcp.origin, quaternion_from_matrix(tcp.rotation)


def _needed(path: Toolpath, setting: Setting, *, with_rapids: bool) -> Bools:
    """(N,) the cuts, and the rapids that ``job_for`` follows."""
    cut = path.kind == CUT
    needed: Bools = cut | np.concatenate([cut[1:], [False]])
    if with_rapids and cut.any():
        first, last = int(np.argmax(needed)), int(np.flatnonzero(cut)[-1])
        needed[first:last] = True
        behind = last + 1  # the retract; joint angles there are a home position
        needed[behind : behind + 1] = behind < len(path) and round(float(path.row[behind])) not in setting.joints
    return needed


def _under_tools_of_cuts(placement: Placement, path: Toolpath, setting: Setting, *, with_rapids: bool) -> Toolpath:
    """The flange stays where it is at every rapid that is needed, its pose is that of the tool of the next cut.

    Raises:
        CellError: the frame of a tool that only rapids use is nowhere.
    """
    cuts = np.flatnonzero(path.kind == CUT)
    if not len(cuts) or path.quaternion is None:
        return path
    cut = cuts[np.minimum(np.searchsorted(cuts, np.arange(len(path))), len(cuts) - 1)]
    tool = path.tool[cut]
    moved = (tool != path.tool) & _needed(path, setting, with_rapids=with_rapids)
    posed = moved & np.isfinite(path.quaternion[:, 0])
    if not posed.any():
        return replace(path, tool=tool)
    position, quaternion = path.position.copy(), path.quaternion.copy()
    for old, new in {*zip(path.tool[posed].tolist(), tool[posed].tolist(), strict=True)}:
        rows = np.flatnonzero(posed & (path.tool == old) & (tool == new))
        if old not in setting.tools:
            raise CellError(
                f"{path.where(rows[0])}: a move under tool {old}, whose frame is not in the program: put "
                f"it there, or move under that of the cuts (tool {new})"
            )
        mounted = placement.tools.tool(new)
        flange = Frame(matrix_from_unit_quaternion(quaternion[rows]), position[rows])
        flange = flange.then(setting.tools[old].frame.inverse())
        pose = flange.then(Frame(mounted.rotation, mounted.position))
        position[rows], quaternion[rows] = pose.origin, quaternion_from_matrix(pose.rotation)
    return replace(path, tool=tool, position=position, quaternion=quaternion, axis=tool_axis(quaternion))


def _start(arm: Arm, placement: Placement, path: Toolpath, setting: Setting) -> Floats | None:
    """(n,) rad where the program starts: the posture picks the arm configuration; None: the program leaves it open.

    Raises:
        CellError: the arm cannot stand there.
    """
    robot = arm.robot
    joints = setting.joints.get(round(float(path.row[0])))
    if joints is None:
        wanted = -1
        if setting.configuration is not None and isinstance(arm.inverse, SphericalInverse):
            wanted = int(setting.configuration[round(float(path.row[0]))])
        postures = [q for branch, q in _postures(arm, placement, path.take([0])) if branch == wanted]
        if not postures:
            return None
        joints = min(postures, key=lambda q: float(np.abs(q).sum()))
    outside = np.flatnonzero((joints < robot.lower) | (joints > robot.upper))
    if len(outside):
        i = int(outside[0])
        low, angle, high = np.degrees([robot.lower[i], joints[i], robot.upper[i]])
        raise CellError(
            f"{path.where(0)}: joint {i + 1} at {angle:.3f} deg is outside the limits {low:.3f} ... "
            f"{high:.3f} deg of {robot.name}: is this program for another robot than that of {placement.source}?"
        )
    return joints


def _postures(arm: Arm, placement: Placement, pose: Toolpath) -> list[tuple[int, Floats]]:
    """Every posture (branch, q) of a path of one pose."""
    if pose.quaternion is None:
        return []
    tcp = placement.workobject.then(Frame(matrix_from_unit_quaternion(pose.quaternion), pose.position))
    return TcpInverse(arm.inverse, placement.tools).postures(pose, tcp, limits=True)


def _with_joint_moves(arm: Arm, placement: Placement, path: Toolpath, setting: Setting) -> Toolpath:
    """Poses along the joint moves between two poses."""
    if path.quaternion is None:
        return path
    # where rapids are left out between, the way to the next is that of a joint move
    whole = np.concatenate([[False], np.diff(path.row) <= 1.0 + 1e-9])
    straight = np.zeros(len(path), dtype=np.bool_)
    if setting.straight is not None:
        straight = whole & setting.straight[np.ceil(path.row - 1e-9).astype(np.intp)]
    rapid = [k for k in np.flatnonzero((path.kind != CUT) & ~straight).tolist() if k > 0]
    end, row, position, orientation = [], [], [], []
    for k in rapid:
        angles = _joint_move(arm, placement, path, k, joints=setting.joints.get(round(float(path.row[k]))))
        for part, q in enumerate(angles, start=1):
            where, turned = _tcp(placement, arm.robot, q, int(path.tool[k]))
            end.append(k)
            row.append(path.row[k] - 1 + part / (len(angles) + 1))
            position.append(where)
            orientation.append(turned)
    if not end:
        return path
    return path.with_points(np.array(end), np.array(row), np.array(position), np.array(orientation))


def _joint_move(arm: Arm, placement: Placement, path: Toolpath, k: int, *, joints: Floats | None) -> Floats:
    """(M, n) rad inside the shortest joint move to pose ``k``; ``joints``: what the program has there, if it has."""
    ends = [q for _, q in _postures(arm, placement, path.take([k]))] if joints is None else [joints]
    begins = [q for _, q in _postures(arm, placement, path.take([k - 1]))]
    pairs = [(a, b) for a in begins for b in ends]
    if not pairs:
        return np.empty((0, arm.robot.n))
    a, b = min(pairs, key=lambda ab: float(np.abs(ab[1] - ab[0]).max()))
    parts = int(np.ceil(np.abs(b - a).max() / JOINT_STEP))
    return np.asarray(a + np.arange(1, parts)[:, None] / max(parts, 1) * (b - a))
