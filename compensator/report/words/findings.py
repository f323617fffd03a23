"""Findings about the measurements, in sentences: the first lines of the terminal, of stderr and of the page."""

from __future__ import annotations

from typing import Any

Report = dict[str, Any]


def finding_sentences(report: Report) -> list[str]:
    """The findings of a JSON report, one sentence each."""
    return [f"{f['level']}: {f['where']}: {f['what']}" for f in report["findings"]]
