"""The JSON report of ``compensate`` and ``preview``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import MillingLoad
from compensator.report.json.axes import axes_report
from compensator.report.json.collisions import collisions_report
from compensator.report.json.findings import findings_report
from compensator.report.json.motion import motion_report
from compensator.report.json.text import MM, Report
from compensator.report.json.turn import turn_report
from compensator.solve.assessment import Assessment
from compensator.solve.compensation import Compensation, ShareSizes
from compensator.solve.uncertainty import ErrorBand

Floats = npt.NDArray[np.float64]

SCHEMA = "path-summary/1"
FIRST = 3  # of what should be measured first
SHARES = ("gravity", "process", "joint_state", "offsets", "temperature", "touched_off", "interaction")


def path_report(a: Assessment, after: Floats, *, seconds: float, corrected: bool = True) -> Report:
    """The numbers of a run.

    Args:
        after: (N,) m, error with the commands as written.
        seconds: how long the run took.
        corrected: False where the nominal path is commanded.
    """
    c = a.result
    cut, plain = c.cutting, c.uncompensated
    before = statistics(np.linalg.norm(plain.error_before[plain.cutting], axis=1))
    milled = {"cut": c.load.summary()} if isinstance(c.load, MillingLoad) else {}
    return {
        "schema": SCHEMA,
        "n_poses": len(c),
        "n_cut": int(cut.sum()),
        "predicted_error_mm": {
            "before": {**before, **_band(a.band, before)},
            "after": statistics(after[cut]),
            **_uncoupled(c),
        },
        "deflection_mm": {name: _share(a.share_sizes, name) for name in SHARES if name in a.share_sizes.size},
        "tool_direction": {
            "mean_xyz": a.direction.mean.tolist(),
            "spread_deg": float(np.degrees(a.direction.spread)),
            "n_upward": a.direction.upward,
        },
        **milled,
        "max_correction_mm": float(np.linalg.norm(c.correction, axis=1).max() * MM) if corrected else 0.0,
        "reversals": [t.as_dict() for t in a.reversals],
        "torque_sign_changes": [t.as_dict() for t in a.sign_changes],
        **({} if c.path.chosen is None else {"turn": turn_report(c.path.chosen)}),
        **({} if c.path.axes is None else {"external": axes_report(c.path.axes)}),
        "motion": motion_report(a.motion, c.path, a.added),
        "solve": {"iterations_max": c.iterations, "unconverged": int(np.sum(~c.command.converged))},
        "inserted_poses": c.inserted,
        "unknown_state": {"n_cut": int(np.sum(a.spread > 0)), "max_spread_mm": float(a.spread.max(initial=0.0) * MM)},
        "not_learned": [part.as_dict() for part in a.open.not_learned],
        "collisions": collisions_report(a.collisions),
        "left_open_mm": statistics(a.open.sd),
        "controller": {"absolute_accuracy": c.job.placement.absolute_accuracy},
        "not_applied": list(c.job.arm.not_applied),
        "findings": findings_report(a.findings),
        "notes": [str(f) for f in a.findings if f.kind in ("cell", "model")],
        "seconds": round(seconds, 3),
    }


def _band(band: ErrorBand | None, size: Report) -> Report:
    """95 % bands of mean, p95 and max, mm, and the share of each input in the variance of the mean."""
    if band is None:
        return {}
    n = len(band.size)
    weights = {"mean": band.evenly, "p95": np.eye(1, n, n - 2)[0], "max": np.eye(1, n, n - 1)[0]}
    out: Report = {k: [max(size[k] - MM * band.of(w), 0.0), size[k] + MM * band.of(w)] for k, w in weights.items()}
    first = [{"what": words, "share": share} for words, share in list(band.first.items())[:FIRST]]
    return {"band95": {**out, "share": band.shares, "measure_first": first}}


def _uncoupled(c: Compensation) -> Report:
    """The prediction with the force of the nominal path, where that above follows the deflection."""
    if c.uncoupled is None:
        return {}
    return {"uncoupled": statistics(np.linalg.norm(c.uncoupled.error_before[c.cutting], axis=1))}


def _share(shares: ShareSizes, name: str) -> Report:
    """Statistics of the size of a share, and its mean, mm: the means of all shares add up."""
    return {**statistics(shares.size[name]), "mean_xyz": (shares.mean[name] * MM).tolist()}


def statistics(error: Floats) -> dict[str, float]:
    """mean, p95 and max of distances (N,) m, in mm."""
    if not len(error):
        return {"mean": 0.0, "p95": 0.0, "max": 0.0}
    mm = error * MM
    return {"mean": float(mm.mean()), "p95": float(np.percentile(mm, 95)), "max": float(mm.max())}
