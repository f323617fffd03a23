"""Numbers as programs print them: no exponent, no negative zero."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pydantic_core import from_json

from toolpaths.writing.program import Floats


def number(value: float, digits: int) -> str:
    """A decimal number without exponent, trailing zeros and negative zero."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def printed(values: Floats, digits: int) -> Floats:
    """Values as they will be printed with so many decimals, without negative zeros."""
    return np.asarray(np.round(values, digits) + 0.0)


def numbers_of(rows: Sequence[str], width: int) -> Floats:
    """(M, width) of rows of decimal numbers with commas between: what ``float`` makes of each.

    A JSON parser is several times as fast. What is no JSON, as a number that was edited by hand may be, is left to
    ``float``.

    Raises:
        ValueError: something else stands there, or another count.
    """
    text = ",".join(rows)
    try:
        values = from_json(f"[{text}]")
    except ValueError:
        values = [float(number) for number in text.split(",")]
    return np.array(values, dtype=np.float64).reshape(-1, width)
