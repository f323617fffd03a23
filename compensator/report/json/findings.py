"""The findings of a JSON report: what stands first in every output of a verb that reads sessions."""

from __future__ import annotations

from collections.abc import Iterable

from compensator.report.json.text import Report
from stiffness.diagnosis.doubt import Doubt
from toolpaths.finding import NOTE, WARNING


def findings(doubts: Iterable[Doubt]) -> list[Report]:
    """As the interface has them."""
    return [
        {"level": WARNING, "what": d.what, "where": d.where, "source_line": d.first, "count": d.count} for d in doubts
    ]


def notes(where: str, sentences: Iterable[str]) -> list[Report]:
    """What a result does not know."""
    return [{"level": NOTE, "what": text, "where": where, "source_line": None, "count": 1} for text in sentences]
