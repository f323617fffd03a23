"""The findings of a JSON report: what stands first in every output of a verb that reads sessions."""

from __future__ import annotations

from collections.abc import Iterable

from compensator.report.json.text import Report
from stiffness.diagnosis.doubt import Doubt
from toolpaths.finding import WARNING


def findings(doubts: Iterable[Doubt]) -> list[Report]:
    """As the interface has them."""
    return [
        {"level": WARNING, "what": d.what, "where": d.where, "source_line": d.first, "count": d.count} for d in doubts
    ]
