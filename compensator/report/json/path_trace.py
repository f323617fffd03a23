"""The parts of a JSON report that traces add: ISO 230-4 of ball-bars, and what belongs to the measurement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from compensator.report.analysis.circular_test import CircularTest, circular_tests
from compensator.report.json.text import MM, Report
from stiffness.identification.session_fit import SessionFit


def trace_report(fits: Sequence[SessionFit], before: Sequence[SessionFit] | None = None) -> Report:
    """``iso230_4`` and ``traces``; nothing for sessions without a trace.

    Args:
        fits: with the model that stands at the end. before: with the model at hand; None: the same.
    """
    traced = [(fit, (before or fits)[k]) for k, fit in enumerate(fits) if fit.session.path is not None]
    if not traced:
        return {}
    out: Report = {"traces": [_placed(fit) for fit, _ in traced]}
    circles = [entry for fit, first in traced for entry in _circles(fit, first)]
    if circles:
        out["iso230_4"] = circles
    return out


def _circles(fit: SessionFit, before: SessionFit) -> list[Report]:
    path = fit.session.path
    if path is None or path.kind != "ballbar":
        return []
    read = circular_tests(path, fit.samples.position[:, 0])
    old = circular_tests(path, before.predicted.position[:, 0])
    new = circular_tests(path, fit.predicted.position[:, 0])
    return [
        {
            "trace": fit.session.source,
            "plane": one.plane,
            "feed_mm_min": None if np.isnan(one.feed) else round(one.feed * 6e4, 6),
            "unit": "mm",
            **_numbers(one),
            "center_mm": (one.centre * MM).tolist(),
            "predicted": {"before": _numbers(was), "after": _numbers(now)},
            "reversals": [
                {
                    "joint": f"joint-{t.joint}", "joint_deg": float(np.degrees(t.angle)),
                    "at_deg": float(np.degrees(t.place)), "step_mm": t.step * MM, "predicted_mm": p.step * MM,
                }
                for t, p in zip(one.turning, now.turning, strict=True)
            ],
        }
        for one, was, now in zip(read, old, new, strict=True)
    ]  # fmt: skip


def _numbers(one: CircularTest) -> Report:
    most, least = one.radial_error
    return {
        "circular_error": {
            "clockwise": _mm(one.circular_error(True)),
            "counter_clockwise": _mm(one.circular_error(False)),
        },
        "bidirectional_circular_error": _mm(one.bidirectional_circular_error),
        "mean_bidirectional_radial_error": one.mean_bidirectional_radial_error * MM,
        "radial_error": {"max": most * MM, "min": least * MM},
    }


def _mm(value: float | None) -> float | None:
    return None if value is None else value * MM


def _placed(fit: SessionFit) -> Report:
    """What was estimated of the measurement itself."""
    path, station = fit.session.path, fit.observations.data.station
    if path is None:
        return {}
    own = {e.name: fit.own[e.span] for e in station.entries}
    out: Report = {
        "trace": fit.session.source, "kind": path.kind, "n_samples": path.given, "n_used": int(fit.used.sum()),
        "dry": path.dry, "notes": list(path.notes),
    }  # fmt: skip
    if "centre" in own:
        out["center_mm"] = ((path.centre + own["centre"]) * MM).tolist()
    if "length" in own:
        out["length_error_mm"] = float(own["length"][0]) * MM
    if "part" in own:
        out["part_shift_mm"] = (own["part"][:3] * MM).tolist()
        out["part_turn_deg"] = np.degrees(own["part"][3:]).tolist()
    if "probe" in own:
        out["probe_offset_mm"] = float(own["probe"][0]) * MM
    if "latency" in own:
        out["latency_s"] = float(own["latency"][0])
    return out
