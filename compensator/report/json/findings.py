"""The findings of a JSON report: the one list that the terminal, standard error and the page show, too."""

from __future__ import annotations

from collections.abc import Iterable

from compensator.report.json.text import Report
from stiffness.diagnosis.doubt import Doubt
from toolpaths.finding import NOTE, WARNING, Finding, merged


def findings_report(found: Iterable[Finding]) -> list[Report]:
    """As the interface has them, repeats merged, errors first and notes last."""
    return [
        {
            "level": f.level,
            "kind": f.kind,
            "what": f.what,
            "remedy": f.remedy,
            "where": f.place,
            "source_line": f.source_line,
            "count": f.count,
        }
        for f in merged(found)
    ]


def of_doubts(doubts: Iterable[Doubt]) -> list[Finding]:
    """What is wrong with measurements, or looks so."""
    return [Finding(WARNING, d.where, d.what, count=d.count, kind="measurement", line=d.first) for d in doubts]


def notes(kind: str, where: str, sentences: Iterable[str]) -> list[Finding]:
    """What a result does not know."""
    return [Finding(NOTE, where, text, kind=kind) for text in sentences]
