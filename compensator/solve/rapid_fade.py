"""Rapids next to a cut: the correction fades in and out off the part, and clearance is kept.

A rapid carries no process load, so its exact command is the nominal pose (with the sag, where that is
compensated). StartValues a cut the target moves sideways towards the correction of the cut, never into the part: the
component along the tool, towards the work, is left to the first segment of the feed.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.path.planned_path import PlannedPath
from stiffness.memory.preload import PreloadState
from stiffness.statics.prediction import Command
from toolpaths.frame import Frame
from toolpaths.made_frames import with_others
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


def faded_targets(
    arm: EquippedArm, path: PlannedPath, command: Command, state: PreloadState, *, target: Frame, fade: float
) -> Frame:
    """(N) TCP targets, base: ``target`` but for rapids next to a cut, nearer than ``fade`` (m)."""
    cut = path.toolpath.kind == CUT
    edges = np.flatnonzero(cut[1:] != cut[:-1])  # between pose e and e + 1
    if not len(edges):
        return target
    cutting = np.where(cut[edges], edges, edges + 1)
    shift = command.printed.take(cutting).origin - _unloaded(arm, path, state, cutting).position
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path.toolpath.on_part, axis=0), axis=1))])
    # an edge lies at the pose before it: the end of a rapid, or of a cut that a rapid leaves
    edge_at = along[edges]
    rows = np.flatnonzero(~cut)
    weight, offset = np.zeros(len(rows)), np.zeros((len(rows), 3))
    for side in (-1, 1):
        near = np.searchsorted(edges, rows, side="left") + (0 if side > 0 else -1)
        valid = (near >= 0) & (near < len(edges))
        near = np.clip(near, 0, len(edges) - 1)
        distance = np.abs(along[rows] - edge_at[near]) / fade
        t = np.clip(1 - distance, 0, 1)
        w = np.where(valid, t * t * (3 - 2 * t), 0.0)
        weight, offset = weight + w, offset + w[:, None] * shift[near]
    offset /= np.maximum(weight, 1.0)[:, None]
    into = path.tcp.take(rows).z
    offset -= into * np.maximum(np.sum(offset * into, axis=1, keepdims=True), 0.0)
    return with_others(target, rows, origin=target.take(rows).origin + offset)


def held_targets(
    arm: EquippedArm, path: PlannedPath, wrench: Floats, state: PreloadState, *, target: Frame, rows: Rows
) -> Frame:
    """(N) TCP targets, base: ``target``, at ``rows`` where the command of the nominal path leads."""
    goes = arm.forward(path.toolpath.take(rows), path.q[rows], wrench[rows], state.take(rows).middle)
    return with_others(target, rows, rotation=goes.rotation, origin=goes.position)


def _unloaded(arm: EquippedArm, path: PlannedPath, state: PreloadState, rows: Rows) -> Command:
    """The commands at ``rows`` without a process: what they differ by from the solve is what the process causes."""
    part, no_load = path.toolpath.take(rows), np.zeros((len(rows), 6))
    return arm.command(part, path.tcp.take(rows), wrench=no_load, state=state.take(rows).middle, seed=path.q[rows])
