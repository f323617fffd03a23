"""A verification in sentences."""

from __future__ import annotations

from typing import Any

from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import deflection_mm


def verification_lines(report: dict[str, Any]) -> list[str]:
    """The verdict first, the numbers, then the findings."""
    error = report["predicted_error_mm"]
    lines = [f"{report['program']}: {report['verdict']}"]
    if error["program"] is not None:
        sizes = ", ".join(f"{name} {deflection_mm(error['program'][key])}" for name, key in _SIZES.items())
        told = "" if error["head"] is None else f"; when it was written max {deflection_mm(error['head'])}"
        lines.append(f"predicted error of the program as it stands, mm: {sizes}{told}")
    p = report["provenance"]
    lines.append(", ".join(f"{name} {p[name]}" for name in ("version", "cell", "model", "toolpath")))
    return [*lines, *finding_sentences(report)]


_SIZES = {"mean": "mean", "95 %": "p95", "max": "max"}
