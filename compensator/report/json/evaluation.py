"""The JSON report of ``evaluate``."""

from __future__ import annotations

from compensator.report.json.text import MM, Report
from stiffness.identification.evaluate import Evaluation
from stiffness.identification.scores import Score


def evaluation_report(result: Evaluation) -> Report:
    """The scores of both kinds of evidence; null where a session has none."""
    return {"displacement": _score(result.displacement), "absolute": _score(result.absolute)}


def _score(score: Score | None) -> Report | None:
    if score is None:
        return None
    return {
        "rms_mm": score.rms * MM,
        "p95_mm": score.p95 * MM,
        "max_mm": score.largest * MM,
        "noise_floor_mm": score.noise_floor * MM,
        "by_reflector": {name: value * MM for name, value in score.by_reflector.items()},
    }
