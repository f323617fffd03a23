"""Findings in sentences: the terminal, standard error and the page have the same ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from toolpaths.finding import LEVELS, NOTE

Report = dict[str, Any]
MEASUREMENT = "measurement"  # kind of findings whose words count the rows that they are about


def finding_sentences(report: Report, levels: Sequence[str] = LEVELS) -> list[str]:
    """The findings of a JSON report, one sentence each."""
    return [f"{f['level']}: {_told(f)}" for f in report["findings"] if f["level"] in levels]


def note_sentences(report: Report) -> list[str]:
    """What a result does not know, under a heading that tells their level."""
    return [_told(f) for f in report["findings"] if f["level"] == NOTE]


def _told(f: Report) -> str:
    more = f["count"] - 1 if f["kind"] != MEASUREMENT else 0
    also = f" (and {more} more place{'s' if more > 1 else ''})" if more else ""
    where = f"{f['where']}{also}: " if f["where"] else ""
    return f"{where}{f['what']}" + (f". {f['remedy']}" if f["remedy"] else "")
