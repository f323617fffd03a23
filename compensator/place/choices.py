"""Choices: the turns about the tool axis and arm configurations that one placement is looked at with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from compensator.path.tcp_inverse import TcpInverse
from stiffness.kinematics.iterative import IterativeInverse
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


class Choices(NamedTuple):
    """C turns and configurations along P poses.

    Attributes:
        q: (C, P, n) rad, at any whole turn; without meaning where not ``ok``. ok: (C, P).
        turn: (C,) which of the turns. branch: (C,) label, of arms without a closed form at the first pose only.
        reachable: False if the reach alone forbids all of them.
    """

    q: Floats
    ok: Bools
    turn: Ints
    branch: Ints
    reachable: bool


def choices(path: Toolpath, inverse: TcpInverse, tcp: Sequence[Frame]) -> Choices:
    """All choices for the poses of a path; ``tcp``: (P) in the base, of each turn."""
    if isinstance(inverse.inverse, IterativeInverse):
        return _followed(path, inverse, inverse.inverse, [inverse.tools.flange(path, one) for one in tcp])
    return _named(path, inverse, tcp)


def _named(path: Toolpath, inverse: TcpInverse, tcp: Sequence[Frame]) -> Choices:
    """In closed form: a branch is the same configuration at every pose."""
    poses, branches, turns, n = len(path), inverse.inverse.branches, len(tcp), inverse.robot.n
    count = branches * turns
    label, rows = np.repeat(np.arange(branches), turns), np.tile(np.arange(poses), count)
    all_ = Frame(
        np.tile(np.concatenate([one.rotation for one in tcp]), (branches, 1, 1)),
        np.tile(np.concatenate([one.origin for one in tcp]), (branches, 1)),
    )
    near = np.broadcast_to(np.zeros(n), (len(rows), n))
    found = inverse.along(path.take(rows), all_, np.repeat(label, poses), near)
    ok = found.ok.reshape(count, poses)
    turn = np.tile(np.arange(turns), branches)
    q, reachable = found.q.reshape(count, poses, n), bool(ok.all(axis=1).any())
    return Choices(q=q, ok=ok, turn=turn, branch=label, reachable=reachable)


def _followed(path: Toolpath, inverse: TcpInverse, arm: IterativeInverse, flange: Sequence[Frame]) -> Choices:
    """Without a closed form: every posture of the first pose, followed from there; ``flange`` (P) of each turn.

    A joint move leads to another tool: to the posture there that is nearest.
    """
    first = [arm.all(one.take(0).matrix, limits=False) for one in flange]
    turn = np.repeat(np.arange(len(flange)), [len(found) for found in first])
    branch = np.array([label for found in first for label, _ in found], dtype=np.int64)
    q = np.zeros((len(turn), len(path), arm.robot.n))
    ok = np.zeros(q.shape[:2], dtype=np.bool_)
    start = np.array([posture for found in first for _, posture in found]).reshape(-1, arm.robot.n)
    going, changes = np.arange(len(turn)), inverse.tools.changes(path)
    for begin, end in zip([0, *changes], [*changes, len(path)], strict=True):
        if begin:
            start, going = _nearest(arm, flange, begin, turn=turn[going], before=q[going, begin - 1], going=going)
        if len(going):
            part = slice(begin, end)
            q[going, part], ok[going, part] = arm.followed([one.take(part) for one in flange], turn[going], start)
            going = going[ok[going, end - 1]]
    return Choices(q=q, ok=ok, turn=turn, branch=branch, reachable=_reachable(arm, flange, turn, ok))


def _nearest(
    arm: IterativeInverse, flange: Sequence[Frame], pose: int, *, turn: Ints, before: Floats, going: Ints
) -> tuple[Floats, Ints]:
    """Postures (K, n) of a pose, of those (K,) of ``going`` that have one: the nearest to ``before``."""
    start, kept = [], []
    for t, q, choice in zip(turn.tolist(), before, going.tolist(), strict=True):
        found = [posture for _, posture in arm.all(flange[t].take(pose).matrix, limits=False)]
        if found:
            apart = [float(np.abs((p - q + np.pi) % (2 * np.pi) - np.pi).sum()) for p in found]
            start.append(found[int(np.argmin(apart))])
            kept.append(choice)
    return np.array(start).reshape(-1, arm.robot.n), np.array(kept, dtype=np.int64)


def _reachable(arm: IterativeInverse, flange: Sequence[Frame], turn: Ints, ok: Bools) -> bool:
    """Whether at some turn the arm comes through, or ends at a pose that it could take up: a joint limit or a
    singularity ends it, not the reach. Of each turn the choice that comes farthest is asked."""
    if ok.all(axis=1).any():
        return True
    ends = [(t, int(ok[turn == t].sum(axis=1).max())) for t in np.unique(turn).tolist()]
    return any(arm.all(flange[t].take(end).matrix, limits=False) for t, end in ends)
