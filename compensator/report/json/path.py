"""The JSON report of ``compensate`` and ``preview``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.turnarounds import reversals, sign_changes
from compensator.report.json.text import MM, Report
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import spread_of_unknown
from compensator.solve.unlearned_angles import OpenAngles

Floats = npt.NDArray[np.float64]


def path_report(
    c: Compensation, after: Floats, found: OpenAngles, *, seconds: float, corrected: bool = True
) -> Report:
    """The numbers of a run.

    Args:
        after: (N,) m, error with the commands as written.
        found: angles that the model did not learn.
        seconds: how long the run took.
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
        "max_correction_mm": float(np.linalg.norm(c.correction, axis=1).max() * MM) if corrected else 0.0,
        "reversals": [t.as_dict() for t in reversals(c, q)],
        "torque_sign_changes": [t.as_dict() for t in sign_changes(c)],
        "solve": {"iterations_max": c.iterations, "unconverged": int(np.sum(~c.command.converged))},
        "inserted_poses": c.inserted,
        "unknown_state": {"n_cut": int(np.sum(spread > 0)), "max_spread_mm": float(spread.max(initial=0.0) * MM)},
        "not_learned": [part.as_dict() for part in found.not_learned],
        "left_open_mm": statistics(found.sd),
        "not_applied": list(c.job.arm.not_applied),
        "notes": [str(note) for note in (*c.job.notes, *found.findings)],
        "seconds": round(seconds, 3),
    }


def statistics(error: Floats) -> dict[str, float]:
    """mean, p95 and max of distances (N,) m, in mm."""
    if not len(error):
        return {"mean": 0.0, "p95": 0.0, "max": 0.0}
    mm = error * MM
    return {"mean": float(mm.mean()), "p95": float(np.percentile(mm, 95)), "max": float(mm.max())}
