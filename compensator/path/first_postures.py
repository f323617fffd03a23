"""How an arm may begin a path: turns about the tool axis and arm configurations, the best first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.free_turn import about_tool_axis
from compensator.path.motion_bounds import MotionBounds
from compensator.path.tcp_inverse import TcpInverse
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

TURNS = 24  # constant turns that are tried, 15 deg apart
FOLLOWED = 24  # first postures that an arm without a closed form is followed from
PROBES = 150  # poses of the path that a candidate is scored on first
BEST = 6  # candidates that are worth following


@dataclass(frozen=True)
class PathStart:
    """A constant ``turn`` (rad), a branch, joint angles ``seed`` (n,) rad of the first pose; the best score first."""

    turn: float
    branch: int
    seed: Floats
    score: float


@dataclass(frozen=True, eq=False)
class FirstPostures:
    """What a path may begin with.

    Attributes:
        start: (n,) rad where the arm comes from, within its limits; it picks the arm configuration. None: not known.
        turn_is_open: the turn about the tool axis may be chosen.
    """

    inverse: TcpInverse
    bounds: MotionBounds
    start: Floats | None
    turn_is_open: bool

    def for_path(self, toolpath: Toolpath, reference: Frame) -> list[PathStart]:
        """Turns and configurations for the whole path, the best first.

        Args:
            reference: (N) TCP in the base, before it is turned about the tool axis.
        """
        probe = np.unique(np.linspace(0, len(toolpath) - 1, PROBES).astype(int))
        some, at = toolpath.take(probe), reference.take(probe)
        found = []
        for turn, branch, q in self._of_first_pose(some, at):
            batch = self.inverse.along(some, about_tool_axis(at, turn), branch, q)
            if batch.ok.all():
                found.append(PathStart(turn, branch, q, self._score(q, self.turns_in_limits(batch.q, batch.ok))))
        return sorted(found, key=lambda c: -c.score)[:BEST]

    def _score(self, first: Floats, q: Floats) -> float:
        if self.start is not None and not self.inverse.labelled:
            return -_apart(first, self.start)
        return float(self.bounds.margin(q).min())

    def _of_first_pose(self, some: Toolpath, reference: Frame) -> list[tuple[float, int, Floats]]:
        """(turn, branch, joint angles) at the first pose; of arms that are followed pose by pose the roomiest only."""
        out: list[tuple[float, int, Floats]] = []
        pose, at = some.take([0]), reference.take(slice(1))
        for turn in self.turns(some, reference):
            seen: dict[int, Floats] = {}
            for branch, q in self._allowed(pose, about_tool_axis(at, turn)):
                seen.setdefault(branch, q)
            out += [(float(turn), branch, q) for branch, q in seen.items()]
        if self.inverse.labelled or self.start is not None or len(out) <= FOLLOWED:
            return out
        room = self.bounds.margin(np.array([q for _, _, q in out]))
        return [out[k] for k in np.argsort(-room, kind="stable")[:FOLLOWED]]

    def _allowed(self, pose: Toolpath, tcp: Frame) -> list[tuple[int, Floats]]:
        """Postures of the first pose, the nearest first; ``start`` picks the arm configuration."""
        start = self.start
        near = np.zeros(self.inverse.robot.n) if start is None else start
        found = sorted(self.inverse.postures(pose, tcp, limits=False), key=lambda s: _apart(s[1], near))
        if start is None:
            return found
        if not self.inverse.labelled:
            return found[:1]
        wanted = int(self.inverse.inverse.configuration(start[None])[0])
        return [s for s in found if s[0] == wanted]

    def turns(self, toolpath: Toolpath, reference: Frame) -> Floats:
        """Constant turns about the tool axis to try, rad."""
        if self.turn_is_open:
            return np.linspace(0, 2 * np.pi, TURNS, endpoint=False)
        if toolpath.quaternion is not None or self.start is None:
            return np.zeros(1)
        # fixed, but left open by the file: the turn that is nearest to how the tool stands at ``start``
        flange = self.inverse.robot.pose(self.start)[:3, :3]
        tool = self.inverse.tools.tool(int(toolpath.tool[0]))
        relative = reference.rotation[0].T @ flange @ tool.rotation
        return np.array([np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])])

    def turns_in_limits(self, q: Floats, ok: npt.NDArray[np.bool_]) -> Floats:
        """Shift whole joints by 2 pi so that the path lies within the limits, as near to ``start`` as can be.

        Args:
            q: (N, n) rad. ok: (N,) poses that count.
        """
        if not ok.any():
            return q
        robot, start = self.inverse.robot, self.start
        low, high = q[ok].min(axis=0), q[ok].max(axis=0)
        shifted = q.copy()
        for j in range(q.shape[1]):
            options = 2 * np.pi * np.arange(-3, 4)
            fits = (low[j] + options >= robot.lower[j]) & (high[j] + options <= robot.upper[j])
            if not fits.any():
                continue
            middle = np.abs(0.5 * (low[j] + high[j]) + options - (0.0 if start is None else start[j]))
            shifted[:, j] += options[np.argmin(np.where(fits, middle, np.inf))]
        return shifted


def _apart(q: Floats, start: Floats) -> float:
    """Sum of the angles between two postures, rad; whole turns do not count."""
    return float(np.abs((q - start + np.pi) % (2 * np.pi) - np.pi).sum())
