"""The JSON report of ``diagnose``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.cell.controller_frames import session_frame_findings
from compensator.report.json.findings import findings_report, of_doubts
from compensator.report.json.fit import station_report
from compensator.report.json.path_trace import trace_report
from compensator.report.json.text import MM, Report
from stiffness.diagnosis.doubts import registration_doubts, session_doubts
from stiffness.diagnosis.result import AddedEffect, Diagnosis, HeldOutScores

Floats = npt.NDArray[np.float64]
SCHEMA = "diagnosis-summary/1"
KINDS = ("displacement", "absolute", "path")


def diagnosis_report(d: Diagnosis) -> Report:
    """The JSON report of a diagnosis; readings of both kinds are those that took no part."""
    return {
        "schema": SCHEMA,
        "findings": findings_report([
            *of_doubts((*session_doubts(d.fit.sessions, d.outliers), *registration_doubts(d.last))),
            *session_frame_findings(s.session for s in d.fit.sessions),
        ]),
        "verdict": d.verdict,
        "added": [_added(a) for a in d.added],
        "removed": [{"effect": r.effect, "where": list(r.where), "why": r.why} for r in d.removed],
        "changed": [
            {
                "effect": c.effect, "where": list(c.where), "parameter": c.parameter,
                "from": float(c.before), "to": float(c.after), "sd": float(c.sd), "unit": c.unit,
                "confused_with": list(c.confused_with),
            }
            for c in d.changed
        ],
        "rms_mm": {kind: _rms(d.scores.get(kind)) for kind in KINDS},
        "split_mm": {kind: split(d.scores.get(kind)) for kind in KINDS},
        "candidates": [
            {
                "effect": c.effect, "where": list(c.where), "heldout_rms_mm": float(c.heldout_rms * MM),
                "confused_with": list(c.confused_with),
            }
            for c in d.candidates
        ],
        "residual_points_at": [
            {"what": s.what, "share": float(s.fraction), "follows": s.follows} for s in d.residual_sources
        ],
        "next_setups": [
            {
                "q_deg": np.degrees(s.q).tolist(), "wrench_n_nm": np.asarray(s.wrench, dtype=float).tolist(),
                "reflectors": list(s.reflectors), "why": s.why,
            }
            for s in d.next_setups
        ],
        "next_traces": list(d.next_traces),
        "outlier_rows": [{"session": name, "row": int(row)} for name, row in d.outliers],
        "held_setups": [list(map(int, setups)) for setups in d.held],
        "not_applied": not_applied(d),
        **station_report(d.last),
        **trace_report(d.fit.sessions, d.base.sessions),
        "notes": [*d.notes, *_trace_notes(d)],
    }  # fmt: skip


def _trace_notes(d: Diagnosis) -> list[str]:
    """What was decided where traces were read."""
    return [note for s in d.fit.sessions if s.session.path is not None for note in s.session.path.notes]


def _added(a: AddedEffect) -> Report:
    return {
        "effect": a.effect,
        "where": list(a.where),
        "parameters": {
            name: {"value": _plain(value), "sd": _plain(sd), "unit": unit}
            for name, (value, sd, unit) in a.parameters.items()
        },
        "explains": float(a.explains),
        "confused_with": list(a.confused_with),
    }


def _plain(values: Floats) -> float | list[float]:
    """A single number as a number, several as a list."""
    listed: list[float] = np.asarray(values, dtype=float).reshape(-1).tolist()
    return listed[0] if len(listed) == 1 else listed


def _rms(held_out: HeldOutScores | None) -> dict[str, float] | None:
    if held_out is None:
        return None
    return {
        "before": held_out.before.rms * MM,
        "after": held_out.after.rms * MM,
        "noise_floor": held_out.after.noise_floor * MM,
        "refitted": held_out.refitted.rms * MM,
    }


def split(held_out: HeldOutScores | None) -> dict[str, float] | None:
    """What the error before is made of, mm, RMS per axis; squares add.

    ``parameters``: goes when the model's own numbers are fitted anew. ``structure``: is left then above the noise.
    ``left``: above the noise when what was found is in the model.
    """
    if held_out is None:
        return None
    floor = held_out.after.noise_floor
    return {
        "noise": floor * MM,
        "parameters": _above(held_out.before.rms, held_out.refitted.rms) * MM,
        "structure": _above(held_out.refitted.rms, floor) * MM,
        "left": _above(held_out.after.rms, floor) * MM,
    }


def _above(whole: float, part: float) -> float:
    return float(np.sqrt(max(whole**2 - part**2, 0.0)))


def not_applied(d: Diagnosis) -> list[str]:
    """Effects of the model that these sessions do not show: of another tool."""
    shown = {e.name for e in d.base.unknowns.effects}
    return [e.name for e in d.model.effects if e.name not in shown and e.name not in {a.effect for a in d.added}]
