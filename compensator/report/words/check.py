"""What ``check`` found, in sentences with what each is worth."""

from __future__ import annotations

from typing import Any

from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import deflection_mm


def check_lines(report: dict[str, Any]) -> list[str]:
    """A line per finding, the worst first; a last one that counts them."""
    lines = []
    for row in report["findings"]:
        (line,) = finding_sentences({"findings": [row]})
        worth = row["worth_mm"]
        lines.append(line if worth is None else f"{line} [{deflection_mm(worth)} mm]")
    levels = [row["level"] for row in report["findings"]]
    counts = [f"{levels.count(level)} {level}s" for level in ("error", "warning", "note")]
    return [*lines, ", ".join(counts)]
