"""A work object that was touched off with the tool: the deflection of that moment is in it, and is taken off.

The controller shows where the TCP was commanded to; the part is where the deflected TCP touched it. The rigid motion
from one to the other is a translation for one or two touches, and for more the one that leaves the least squares. It is
applied to what the arm is asked for, and taken off what the arm is predicted to do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import moved_workobject
from compensator.cell.job import Job
from compensator.errors import PathError
from compensator.path.planned_path import PlannedPath
from compensator.path.pose_text import mm
from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_ur
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

TURNS_FROM = 3  # touches that a turn of the part can be told from
ROUNDS = 3  # of a linear fit; a turn of 0.01 rad is exact to rounding then


def touched_off(job: Job, path: PlannedPath) -> Job:
    """The job with its predictions as seen from the part that its work object was touched off on.

    Raises:
        PathError: the robot cannot stand where the cell has it touch; names the entry.
        SolveError: the arm has no equilibrium there.
    """
    touches = job.placement.touches
    if not touches or job.arm.taken_off is not None:
        return job
    ways = path.toolpath.ways
    if ways is not None and len(touches) >= TURNS_FROM and np.ptp(ways.drift, axis=0).any():
        raise PathError(
            f"{job.placement.source}: workobject.touched_off has {len(touches)} touches, and the rail moves along the "
            f"path: a turn of the part is told from one place of the base; give {TURNS_FROM - 1} at most"
        )
    rows, q = zip(*(_posture(job, path, k, touch) for k, touch in enumerate(touches)), strict=True)
    at, angles = path.toolpath.take(np.array(rows)), np.array(q)
    state = np.tile(job.arm.unknown_state.middle, (len(q), 1))
    actual = job.arm.forward(at, angles, np.zeros((len(q), 6)), state)
    motion = rigid_motion(job.arm.nominal(at, angles), actual.position)
    return replace(job, arm=replace(job.arm, taken_off=motion))


def _posture(job: Job, path: PlannedPath, k: int, touch: Floats) -> tuple[int, Floats]:
    """A pose of the path with the tool of a touch, and the joint angles (n,) rad of the touch.

    A point is touched as the nearest cut is made: with its tool, turn and arm configuration, rail and table there.
    """
    robot, where = job.arm.robot, f"{job.placement.source}: workobject.touched_off[{k + 1}]"
    cut = np.flatnonzero(path.toolpath.kind == CUT)
    if len(touch) != 3:
        outside = (touch < robot.lower) | (touch > robot.upper)
        if outside.any():
            j = int(np.argmax(outside))
            low, angle, high = (f"{a:g}" for a in np.degrees([robot.lower[j], touch[j], robot.upper[j]]))
            raise PathError(f"{where}: joint {j + 1} at {angle} deg is outside {low} ... {high} deg of {robot.name}")
        return int(cut[0]), touch
    moved, position = moved_workobject(job.placement, path.toolpath), path.toolpath.position
    position = position if moved is None else moved.inward(position)
    row = int(cut[np.argmin(np.linalg.norm(position[cut] - touch, axis=1))])
    there = touch if moved is None else moved.take(row).at(touch)
    tcp = Frame(path.tcp.take(np.array([row])).rotation, job.placement.workobject.at(there)[None])
    branch = np.broadcast_to(path.branch, len(path.toolpath))[[row]]
    found = job.planner.inverse.along(path.toolpath.take([row]), tcp, branch, path.q[row])
    if not found.ok.all():
        raise PathError(f"{where}: {robot.name} cannot touch {mm(touch)} mm as it cuts beside it: {found.why(0)}")
    return row, found.q[0]


def rigid_motion(nominal: Floats, actual: Floats) -> Frame:
    """The motion of a body by which its points (N, 3) m go from ``nominal`` to ``actual``, as nearly as can be.

    Turns are small; of those that the points leave open (all on a line) the motion has none.
    """
    moved, centre = (actual - nominal).mean(axis=0), nominal.mean(axis=0)
    if len(nominal) < TURNS_FROM:
        return Frame(np.eye(3), moved)
    rotation = np.eye(3)
    for _ in range(ROUNDS):
        arm = (nominal - centre) @ rotation.T
        x, y, z = arm.T
        none = np.zeros_like(x)
        rows = np.stack([none, z, -y, -z, none, x, y, -x, none], axis=1).reshape(-1, 3)  # turn x arm, linear in turn
        turn = np.linalg.lstsq(rows, (actual - centre - moved - arm).ravel(), rcond=1e-9)[0]
        rotation = matrix_from_ur(turn) @ rotation
    return Frame(rotation, centre + moved - rotation @ centre)
