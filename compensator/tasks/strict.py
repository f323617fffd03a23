"""--strict: warnings refuse a run before anything of it is written."""

from __future__ import annotations

from typing import Any

from compensator.errors import CompensatorError
from compensator.report.words.findings import finding_sentences
from toolpaths.finding import ERROR, WARNING


def refuse_warnings(report: dict[str, Any], strict: bool) -> None:
    """Refuse the run of a JSON report that has warnings, where that is asked for.

    Raises:
        CompensatorError: lists all of them.
    """
    found = finding_sentences(report, (ERROR, WARNING)) if strict else []
    if found:
        count = f"{len(found)} warnings refuse" if len(found) > 1 else "a warning refuses"
        raise CompensatorError("\n  ".join([f"--strict: {count} this run. Nothing was written", *found]))
