"""What a plan of circles or touches tells of every joint, for scripts."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator.trials.ballbar import BallbarPlan
from compensator.trials.probe import ProbePlan
from stiffness.planning.reversals import Reversal
from toolpaths.frame import Frame

Report = dict[str, Any]


def ballbar_report(plan: BallbarPlan, joints: int, workobject: Frame) -> Report:
    """Circles, and by which reversal each joint is told."""
    return {
        "center_mm": _rounded(workobject.at(plan.center) * 1e3),
        "radius_mm": round(plan.radius * 1e3, 6),
        "circles": [
            {
                "circle": k,
                "plane": c.shape.plane,
                "tilt_deg": _rounded(np.degrees(c.shape.tilt)),
                "arc_deg": _rounded(np.degrees(c.shape.arc)),
                "overshoot_deg": round(float(np.degrees(c.shape.overshoot)), 6),
                "reversals": [_reversal(r) for r in c.turns],
            }
            for k, c in enumerate(plan.circles, 1)
        ],
        "joints": [_circled(plan, j) for j in range(joints)],
        "n_tried": plan.tried[0],
        "n_reached": plan.tried[1],
    }


def _circled(plan: BallbarPlan, joint: int) -> Report:
    found, sd = plan.told(joint), plan.sd[joint]
    known = {"gap_sd_urad": float(f"{sd * 1e6:.4g}") if np.isfinite(sd) else None}
    if found is None:
        return {"joint": joint + 1, "circle": None, "why_not": plan.why_not(joint), **known}
    return {"circle": found[0] + 1, **_reversal(found[1]), "why_not": None, **known}


def _reversal(r: Reversal) -> Report:
    return {
        "joint": r.joint + 1,
        "at_deg": round(float(np.degrees(r.along)), 3),
        "q_deg": round(float(np.degrees(r.angle)), 3),
        "um_per_mrad": round(r.lever * 1e3, 3),
        "apart_deg": round(float(np.degrees(r.apart)), 3) if np.isfinite(r.apart) else None,
    }


def probe_report(plan: ProbePlan, joints: int) -> Report:
    """Touches, in the order of the program."""
    return {
        "touches": [
            {
                "touch": number,
                "joint": t.joint + 1,
                "posture": t.number + 1,
                "q_deg": _rounded(np.degrees(t.posture)),
                "gauge_along": "xyz"[t.axis],
                "um_per_mrad": round(t.lever * 1e3, 3),
                "turn_deg": round(float(np.degrees(t.turn)), 4),
                "gap_sd_urad": float(f"{t.sd * 1e6:.4g}"),
            }
            for number, t in enumerate(plan.touches, 1)
        ],
        "joints": [
            {"joint": j + 1, "touch": plan.number_of(j), "why_not": None if plan.of(j) else plan.why_not(j)}
            for j in range(joints)
        ],
        "n_tried": plan.tried,
    }


def with_torques(report: Report, torque: np.ndarray) -> Report:
    """A report with what the weight does to each joint; ``torque``: (M, n) N*m at the readings."""
    low, high = (np.round(v, 3) + 0.0 for v in (torque.min(axis=0), torque.max(axis=0)))
    keeps = low * high > 0
    told = [
        {**j, "torque_nm": [float(low[k]), float(high[k])], "weight_keeps_its_side": bool(keeps[k])}
        for k, j in enumerate(report["joints"])
    ]
    return {**report, "joints": told}


def _rounded(values: Any) -> list[float]:
    return [round(float(v), 6) + 0.0 for v in values]
