"""JSON text of a report, and how reports write a number that is not known."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

Report = dict[str, Any]
MM = 1e3  # reports give lengths in mm
WIDTH = 120  # of a line


def as_json(report: Report) -> str:
    """JSON text, arrays in as few lines as fit; a number that is not finite would not be JSON."""
    return _text(report, 0) + "\n"


def _text(value: Any, depth: int, used: int = 0) -> str:
    """``used``: characters of the key before it."""
    line = json.dumps(value, allow_nan=False)
    if not isinstance(value, dict | list) or not value:
        return line
    inner, outer = "  " * (depth + 1), "  " * depth
    if depth and len(inner) + used + len(line) <= WIDTH:
        return line
    if isinstance(value, dict):
        pairs = [f"{inner}{json.dumps(k)}: {_text(v, depth + 1, len(k) + 5)}" for k, v in value.items()]
        return "{\n" + ",\n".join(pairs) + f"\n{outer}}}"
    if any(isinstance(v, dict | list) for v in value):
        return "[\n" + ",\n".join(inner + _text(v, depth + 1) for v in value) + f"\n{outer}]"
    rows, row = list[str](), ""
    for word in (json.dumps(v, allow_nan=False) for v in value):
        if row and len(inner) + len(row) + len(word) + 3 > WIDTH:
            rows, row = [*rows, row], ""
        row += f", {word}" if row else word
    return "[\n" + ",\n".join(inner + r for r in [*rows, row]) + f"\n{outer}]"


def known_numbers(values: npt.NDArray[np.float64], known: Iterable[bool]) -> list[float | None]:
    """Numbers one by one, null where not known."""
    return [float(v) if ok else None for v, ok in zip(values, known, strict=True)]
