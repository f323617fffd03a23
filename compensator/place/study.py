"""Study: what a worker needs to judge placements, made once and sent once."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
import numpy.typing as npt

from compensator.cell.arm import Arm
from compensator.cell.external_axes import moved_workobject
from compensator.cell.job import Job
from compensator.cell.placement import Placement
from compensator.errors import CellError
from compensator.path.free_turn import reference_rotation
from compensator.place.candidates import Candidates
from compensator.process.process import ToolMotion, WrenchAxes
from compensator.scene.bodies import bodies_of
from compensator.scene.body import Body
from compensator.turn.turn_choice import refuse_fixed
from compensator.version import version
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

POSTURES = 120_000  # of inverse kinematics in one task: a second of work or two, so that handing it out costs nothing
MOST_TASKS = 20_000  # each is a message to a scheduler and a file
WINDOW = 10  # poses in a row: reversals and speeds are those of the path, not of a thinned one


@dataclass(frozen=True, repr=False, eq=False)
class Study:
    """A study, as it is sent to every worker.

    Attributes:
        arm, placement: of the cell; the placement as it is there.
        path: some poses of the toolpath, WINDOW of them in a row. begins: (P,) the first pose of every row.
        tcp: (P) of them in the work object.
        wrench: (P, 6) of the process, in ``axes`` of the pose. axes: in which it stays the same wherever the part is.
        bodies: what may collide.
        candidates: placements. turns: (T,) rad about the tool axis.
        key: hash of all that decides the result.
    """

    arm: Arm
    placement: Placement
    path: Toolpath
    begins: npt.NDArray[np.bool_]
    tcp: Frame
    wrench: Floats
    axes: WrenchAxes
    bodies: tuple[Body, ...]
    candidates: Candidates
    turns: Floats
    key: str

    def __repr__(self) -> str:
        return f"Study({self.candidates!r}, {len(self.path)} poses, {len(self.turns)} turns, {self.key})"

    @property
    def batches(self) -> tuple[range, ...]:
        """Candidates of each task."""
        each = len(self.path) * len(self.turns) * self.arm.inverse.branches
        count = len(self.candidates.poses)
        size = max(ceil(POSTURES / each), ceil(count / MOST_TASKS))
        return tuple(range(begin, min(begin + size, count)) for begin in range(0, count, size))


def study_of(
    arm: Arm, job: Job, toolpath: Toolpath, candidates: Candidates, *, turns: int, poses: int, inputs: object
) -> Study:
    """A study of a job.

    Args:
        toolpath: sampled. turns: about the tool axis, where it is free. poses: of the path, at most.
        inputs: hashes of all files.

    Raises:
        CellError, PathError: rail or table move the part; a turn or lean along the path is asked for that is not open.
    """
    if job.placement.solve.along_path:
        refuse_fixed(job, toolpath)
    if names := [name for name, axis in job.placement.external.items() if axis.free]:
        what = f"{job.placement.source}: external.{names[0]}.free = true"
        raise CellError(f"{what}: place ranks placements of one base and one table: take free and its range away")
    if moved_workobject(job.placement, toolpath) is not None:
        raise CellError(f"{toolpath.source}: rail or table move the part along the path: its placement is not studied")
    tcp = Frame(reference_rotation(toolpath), toolpath.position)
    process, work = job.placement.process, job.placement.workobject
    load = process.load(ToolMotion(toolpath, work, work.then(tcp)))
    rows = windows(len(toolpath), poses)
    some = toolpath.take(rows)
    free = toolpath.quaternion is None and job.placement.solve.free_tool_axis
    angles = 2 * np.pi * np.arange(turns) / turns if free else np.zeros(1)
    told = {
        "version": version(), "inputs": inputs, "turns": len(angles), "poses": len(rows), "task": POSTURES,
        "candidates": hashlib.sha256(candidates.poses.tobytes()).hexdigest(),
    }  # fmt: skip
    key = hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()[:16]
    wrench = _carried(load.wrench[rows], process.axes, work, tcp.take(rows))
    bare = replace(some, setting=None)
    return Study(
        arm=arm, placement=job.placement, path=bare, begins=np.diff(rows, prepend=-9) > 1, tcp=tcp.take(rows),
        wrench=wrench, axes=process.axes, bodies=bodies_of(job).all, candidates=candidates, turns=angles, key=key,
    )  # fmt: skip


def windows(count: int, poses: int) -> npt.NDArray[np.intp]:
    """Rows of a path of ``count`` poses: about ``poses`` of them, in runs of WINDOW evenly over the path."""
    if count <= poses:
        return np.arange(count)
    first = np.linspace(0, max(count - WINDOW, 0), max(poses // WINDOW, 2)).astype(np.intp)
    return np.unique(np.minimum(first[:, None] + np.arange(WINDOW), count - 1))


def _carried(wrench: Floats, axes: WrenchAxes, work: Frame, tcp: Frame) -> Floats:
    """(P, 6) base axes -> those in which it does not change when the part is moved: of base, TCP or work object."""
    if axes == "base":
        return wrench
    rotation = work.rotation @ tcp.rotation if axes == "tool" else work.rotation[None]
    return in_axes(wrench, np.swapaxes(rotation, -1, -2))


def in_axes(wrench: Floats, rotation: Floats) -> Floats:
    """(..., 6) wrenches with force and moment turned by ``rotation`` (..., 3, 3)."""
    force = np.einsum("...ij,...j->...i", rotation, wrench[..., :3])
    return np.concatenate([force, np.einsum("...ij,...j->...i", rotation, wrench[..., 3:])], axis=-1)
