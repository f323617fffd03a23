"""The numbers of a run: as JSON for scripts, and what the terminal shows."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import spread_of_unknown
from compensator.solve.unlearned_angles import OpenAngles
from stiffness.effects import preload_softening
from stiffness.memory.preload import unknown, walk

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Turnaround:
    """A joint that reverses, or whose torque changes sign.

    Attributes:
        joint: counted from 1.
        pose: index of the first pose after it.
        line: of the source file.
    """

    joint: int
    pose: int
    line: int

    def as_dict(self) -> dict[str, Any]:
        """As in the JSON report."""
        return {"where": f"joint-{self.joint}", "source_line": self.line, "pose": self.pose}


def statistics(error: Floats) -> dict[str, float]:
    """mean, p95 and max of distances (N,) m, in mm."""
    if not len(error):
        return {"mean": 0.0, "p95": 0.0, "max": 0.0}
    mm = error * 1e3
    return {"mean": float(mm.mean()), "p95": float(np.percentile(mm, 95)), "max": float(mm.max())}


def reversals(c: Compensation, q: Floats) -> list[Turnaround]:
    """Where a joint turns around along a commanded path, rapids included."""
    found: list[Turnaround] = []
    directions = _directions(q)
    for j in range(q.shape[1]):
        found += _turnarounds(c, j, directions[:, j])
    return sorted(found, key=lambda t: (t.pose, t.joint))


def sign_changes(c: Compensation) -> list[Turnaround]:
    """Where the torque of gravity and process on a joint changes sign; 1e-6 N*m count as none."""
    found: list[Turnaround] = []
    for j in range(c.command.torque.shape[1]):
        tau = c.command.torque[:, j]
        found += _turnarounds(c, j, np.where(np.abs(tau) > 1e-6, np.sign(tau), 0.0))
    return sorted(found, key=lambda t: (t.pose, t.joint))


def _directions(q: Floats) -> Floats:
    """(N, n) sign of the last real travel (more than REVERSAL); 0 before the first."""
    ratio = {preload_softening.EFFECT.name: {"ratio": np.ones(q.shape[1])}}
    effects = (preload_softening.EFFECT,)
    moves = np.diff(q, axis=0, prepend=q[:1])
    state = walk(effects, ratio, moves, np.zeros_like(q), unknown(effects, ratio))
    return np.where(state.known & (np.abs(state.middle) == 1.0), np.sign(state.middle), 0.0)


def _turnarounds(c: Compensation, joint: int, sign: Floats) -> list[Turnaround]:
    known = np.flatnonzero(sign != 0)
    turned = known[1:][sign[known[1:]] != sign[known[:-1]]]
    return [Turnaround(joint + 1, int(k), int(c.path.toolpath.line[k])) for k in turned]


def summary(
    c: Compensation, after: Floats, found: OpenAngles, *, seconds: float, corrected: bool = True
) -> dict[str, Any]:
    """The JSON report of ``compensate`` and ``preview``.

    Args:
        after: (N,) m, error with the commands as written.
        found: angles that the model did not learn.
        corrected: False where the nominal path is commanded.
    """
    cut = c.cutting
    spread = spread_of_unknown(c.job.arm, c.path.toolpath, q=c.command.q, wrench=c.wrench, state=c.state)[cut]
    q = c.command.q if corrected else c.path.q
    return {
        "n_poses": len(c),
        "n_cut": int(cut.sum()),
        "predicted_error_mm": {
            "before": statistics(np.linalg.norm(c.error_before[cut], axis=1)),
            "after": statistics(after[cut]),
        },
        "max_correction_mm": float(np.linalg.norm(c.correction, axis=1).max() * 1e3) if corrected else 0.0,
        "reversals": [t.as_dict() for t in reversals(c, q)],
        "torque_sign_changes": [t.as_dict() for t in sign_changes(c)],
        "solve": {"iterations_max": c.iterations, "unconverged": int(np.sum(~c.command.converged))},
        "inserted_poses": c.inserted,
        "unknown_state": {"n_cut": int(np.sum(spread > 0)), "max_spread_mm": float(spread.max(initial=0.0) * 1e3)},
        "not_learned": [part.as_dict() for part in found.not_learned],
        "left_open_mm": statistics(found.sd),
        "not_applied": list(c.job.arm.not_applied),
        "notes": [str(note) for note in (*c.job.notes, *found.findings)],
        "seconds": round(seconds, 3),
    }


def as_json(report: dict[str, Any]) -> str:
    """JSON text; a number that is not finite would not be JSON."""
    return json.dumps(report, indent=2, allow_nan=False) + "\n"
