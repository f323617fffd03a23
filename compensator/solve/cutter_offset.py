"""Cutter offset: where a cutter goes whose size is not what it was taken to be, so that the wall is where it has to be.

The cutter is moved towards the wall that it cuts by what its radius lacks, in corners to where both walls are met.
Where it cuts no wall, or one on each side as in a slot, it stays.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.cell.job import Job
from compensator.path.planned_path import PlannedPath
from compensator.process.process import ProcessLoad
from toolpaths.finding import NOTE, Finding, merged
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]

SHARPEST = 0.25  # 1 + cosine of the angle between two walls: a mitre in a sharper corner is cut short
SMALLEST = 1e-9  # m: a radius that is right


def missing_radius(arm: EquippedArm) -> float:
    """m by which effects of the model that act make the cutter too small."""
    return sum(e.missing_radius(arm.values[e.name]) for e in arm.effects if e.missing_radius)


def moves_cutter(arm: EquippedArm) -> bool:
    """Whether the cutter is moved to its walls."""
    return abs(missing_radius(arm)) >= SMALLEST


def at_the_wall(arm: EquippedArm, path: PlannedPath, wall: Floats | None) -> Frame:
    """(N) TCP targets, base: where a cutter of the size that it has cuts what the one that was programmed cuts.

    Args:
        wall: (N, 3) of a process, see ``ProcessLoad``.
    """
    if wall is None or not moves_cutter(arm):
        return path.tcp
    shift = np.where((path.toolpath.kind == CUT)[:, None], missing_radius(arm) * _mitred(wall), 0.0)
    return path.tcp.at_origins(path.tcp.origin + shift)


def with_offset_findings(job: Job, toolpath: Toolpath, load: ProcessLoad) -> ProcessLoad:
    """The load with a note on how far the cutter was moved, and where it was not."""
    missing, cut = missing_radius(job.arm), toolpath.kind == CUT
    if load.wall is None or not moves_cutter(job.arm):
        return load
    stays = cut & load.wrench.any(axis=1) & ~load.wall.any(axis=1)
    moved = int(np.sum(cut & load.wall.any(axis=1)))
    what = (
        f"the cutter is {abs(missing) * 1e6:.3g} um too {'small' if missing > 0 else 'large'}: moved by that "
        f"{'towards' if missing > 0 else 'away from'} the wall at {moved:,} poses"
    )
    if stays.any():
        what += f"; at {int(stays.sum()):,} it cuts no wall, or one on each side, and stays"
    note = Finding(NOTE, job.arm.model.source, what)
    return replace(load, findings=merged((*load.findings, note)))


def _mitred(wall: Floats) -> Floats:
    """(N, 3) what stands one radius from the walls of the moves to and from every pose."""
    after = np.vstack([wall[1:], wall[-1:]])
    here, there = wall.any(axis=1, keepdims=True), after.any(axis=1, keepdims=True)
    one, other = np.where(here, wall, after), np.where(there, after, wall)
    both = one + other
    return np.asarray(both / np.maximum(1 + np.sum(one * other, axis=1, keepdims=True), SHARPEST))
