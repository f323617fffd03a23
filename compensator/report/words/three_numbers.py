"""The three numbers that matter about a path, for the head of a page."""

from __future__ import annotations

from typing import Any

from compensator.report.words.numbers import deflection_mm

Report = dict[str, Any]


def three_numbers(report: Report, corrected: bool) -> list[dict[str, str]]:
    """What matters about the run: value and words."""
    before, after = (report["predicted_error_mm"][key] for key in ("before", "after"))
    shown = [
        (before["mean"], "off on average, as the file stands"),
        (before["max"], "off at the worst pose, as the file stands"),
        (after["max"], "left at the worst pose, with the program as written")
        if corrected
        else (before["p95"], "is not exceeded by 95 % of the cut"),
    ]
    return [{"value": f"{deflection_mm(value)} mm", "words": words} for value, words in shown]
