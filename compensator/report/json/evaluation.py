"""The JSON report of ``evaluate``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from compensator.cell.controller_frames import session_frame_findings
from compensator.report.json.findings import findings_report, notes, of_doubts
from compensator.report.json.path_trace import trace_report
from compensator.report.json.text import MM, Report
from compensator.solve.unlearned_angles import NotLearned
from stiffness.diagnosis.doubts import session_doubts
from stiffness.identification.evaluate import REGISTER, Evaluation
from stiffness.identification.scores import Score
from toolpaths.finding import WARNING, Finding

SCHEMA = "evaluation-summary/1"


def evaluation_report(
    result: Evaluation, not_learned: Sequence[NotLearned] = (), findings: Sequence[Finding] = ()
) -> Report:
    """The scores of both kinds of evidence, without wrong rows and with them; null where a session has none.

    Args:
        not_learned: angles of the session that the model did not learn. findings: of session and model together.
    """
    session = result.seen.session
    rows = session.samples.line[np.flatnonzero(result.wrong)]
    return {
        "schema": SCHEMA,
        "findings": findings_report([
            *of_doubts(session_doubts([result.seen])),
            *session_frame_findings([session]),
            *_unplaced(result),
            *findings,
            *notes("model", session.source, (str(part) for part in not_learned)),
        ]),
        "displacement": _score(result.displacement),
        "absolute": _score(result.absolute),
        "path": _score(result.path),
        "with_outliers": {kind: _score(score) for kind, score in result.with_wrong.items()},
        "n_readings": len(session),
        "n_placing": result.registered_on,
        "outlier_rows": [{"session": session.source, "row": int(row)} for row in rows],
        **trace_report([result.seen]),
        "not_learned": [part.as_dict() for part in not_learned],
    }


def _unplaced(result: Evaluation) -> list[Finding]:
    """A warning of reflectors that are scored where they roughly are, as no state placed them."""
    session, score = result.seen.session, result.absolute
    if result.registered_on or score is None:
        return []
    rough = [r.name for r in session.reflectors if not r.exact and r.name in score.by_reflector]
    if not rough:
        return []
    each = ", ".join(f"{name} ({score.by_reflector[name] * MM:.3f} mm RMS)" for name in rough)
    return [
        Finding(
            WARNING,
            session.source,
            f"roughly known reflectors are scored where the session has them: {each}, absolute",
            kind="measurement",
            remedy=f"--register {REGISTER} places them with {REGISTER} states and scores the others",
        )
    ]


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
