"""The JSON report of ``check``: findings, and what assumptions are worth, in one list."""

from __future__ import annotations

from collections.abc import Iterable

from compensator.report.json.findings import findings_report
from compensator.report.json.text import MM, Report
from compensator.solve.worth import Worth
from toolpaths.finding import ERROR, LEVELS, Finding

SCHEMA = "check/1"


def check_report(findings: Iterable[Finding], worth: Iterable[Worth]) -> Report:
    """Errors first, notes last; in each level what is worth most first. ``worth_mm``: null where it is not known."""
    rows = [{**row, "worth_mm": None} for row in findings_report(findings)]
    for w in worth:
        rows += [{**row, "worth_mm": w.size * MM} for row in findings_report([w.finding])]
    rows.sort(key=lambda row: (LEVELS.index(row["level"]), -(row["worth_mm"] or 0.0)))
    return {"schema": SCHEMA, "findings": rows, "n_errors": sum(row["level"] == ERROR for row in rows)}
