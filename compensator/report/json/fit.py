"""The JSON report of ``identify``, by the global and by the local method."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator.cell.controller_frames import session_frame_findings
from compensator.report.analysis.by_reflector import KINDS
from compensator.report.analysis.predicted import predicted_sessions
from compensator.report.json.findings import findings_report, of_doubts
from compensator.report.json.path_trace import trace_report
from compensator.report.json.text import MM, Report, known_numbers
from stiffness.diagnosis.doubts import registration_doubts, session_doubts, set_up_doubts
from stiffness.effects import BASE
from stiffness.identification import scores
from stiffness.identification.evaluate import predicted_by
from stiffness.identification.fit import Fit
from stiffness.identification.placed_station import placed_reflectors, placed_trackers
from stiffness.local_method.fit import LocalFit
from stiffness.local_method.text import local_text
from stiffness.model.model import ComplianceModel
from toolpaths.finding import WARNING, Finding

SCHEMA = "fit-summary/1"


def fit_report(fit: Fit) -> Report:
    """The numbers of a global fit."""
    n = fit.unknowns.joints
    known = np.ones(n, dtype=bool)
    for u, ok in zip(fit.unknowns.free, fit.determined(), strict=True):
        if u.effect == BASE.name:
            known[u.index] = ok
    k = fit.values()[BASE.name]["k_nm_per_rad"]
    sd = fit.deviations()[BASE.name]["k_nm_per_rad"]
    return {
        "schema": SCHEMA,
        "findings": findings_report([
            *of_doubts((*session_doubts(fit.sessions), *registration_doubts(fit))),
            *session_frame_findings(s.session for s in fit.sessions),
            *_misfit(fit),
        ]),
        "effects": [e.name for e in fit.unknowns.effects],
        "stiffness_nm_per_rad": known_numbers(k, known),
        "stiffness_sd_nm_per_rad": known_numbers(sd, known),
        "identifiable": known.tolist(),
        "rms_mm": _rms(fit),
        "misfit": fit.solution.misfit,
        "lacks": fit.lacks or None,
        "n_readings": sum(len(s.samples) for s in fit.sessions),
        "outlier_rows": [{"session": name, "row": row} for name, row in fit.outlier_rows()],
        "condition_number": fit.condition_number(),
        "observability": fit.observability(),
        "converged": fit.solution.converged,
        "not_identified": fit.not_identified(),
        **station_report(fit),
        **trace_report(fit.sessions),
        "notes": [*fit.notes, *(n for s in fit.sessions if s.session.path is not None for n in s.session.path.notes)],
    }


def _misfit(fit: Fit) -> list[Finding]:
    """A warning where more is left than the noise explains."""
    sessions = ", ".join(s.session.source for s in fit.sessions)
    return [Finding(WARNING, sessions, fit.lacks, kind="model")] if fit.lacks else []


def station_report(fit: Fit) -> Report:
    """Tracker poses in the base, and reflectors in their links, that were estimated beside the model."""
    return {
        "tracker_poses": [
            {
                "session": t.session,
                "block": t.block,
                "xyz_mm": (t.origin * MM).tolist(),
                "rpy_deg": np.degrees(t.rpy).tolist(),
                "xyz_sd_mm": (t.origin_sd * MM).tolist(),
                "turn_sd_deg": np.degrees(t.rotation_sd).tolist(),
            }
            for t in placed_trackers(fit)
        ],
        "reflectors": [
            {
                "session": r.session,
                "name": r.name,
                "link": r.link,
                "xyz_mm": (r.position * MM).tolist(),
                "xyz_sd_mm": (r.sd * MM).tolist(),
            }
            for r in placed_reflectors(fit)
        ],
    }


def _rms(fit: Fit) -> dict[str, Any]:
    """RMS residual of each kind of reading: of the rigid arm, of the fit, and expected of the noise alone."""
    out: dict[str, Any] = {}
    sessions = predicted_sessions(fit)
    for kind, judge in KINDS.items():
        fitted = scores.pooled([judge(s.fit.session, s.fit.predicted, s.fit.used, s.fit.used) for s in sessions])
        rigid = scores.pooled([judge(s.fit.session, s.rigid, s.fit.used, s.fit.used) for s in sessions])
        out[kind] = None
        if fitted is not None and rigid is not None:
            out[kind] = {"rigid": rigid.rms * MM, "fitted": fitted.rms * MM, "noise_floor": fitted.noise_floor * MM}
    return out


def local_fit_report(fit: LocalFit, model: ComplianceModel) -> Report:
    """The numbers of a fit joint by joint, and of the model made of it, under the same keys."""
    seen = [predicted_by(model, s, np.ones(len(s.samples), dtype=bool)) for s in fit.sessions]
    return {
        "schema": SCHEMA,
        "findings": findings_report([*of_doubts(set_up_doubts(seen)), *session_frame_findings(fit.sessions)]),
        "effects": list(model.values),
        "stiffness_nm_per_rad": known_numbers(fit.stiffness, fit.identified),
        "stiffness_sd_nm_per_rad": known_numbers(fit.sd, fit.identified),
        "identifiable": fit.identified.tolist(),
        "rms_mm": {"displacement": None, "absolute": None, "path": None},
        "n_readings": sum(len(s.samples) for s in fit.sessions),
        "outlier_rows": [],
        "not_identified": [f"joint {r.joint}: {r.problem}" for r in fit.joints if r.problem],
        "notes": local_text(fit).splitlines(),
    }
