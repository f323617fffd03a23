"""JSON text of a report, and how reports write a number that is not known."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

Report = dict[str, Any]
MM = 1e3  # reports give lengths in mm


def as_json(report: Report) -> str:
    """JSON text; a number that is not finite would not be JSON."""
    return json.dumps(report, indent=2, allow_nan=False) + "\n"


def known_numbers(values: npt.NDArray[np.float64], known: Iterable[bool]) -> list[float | None]:
    """Numbers one by one, null where not known."""
    return [float(v) if ok else None for v, ok in zip(values, known, strict=True)]
