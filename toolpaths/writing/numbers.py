"""Numbers as programs print them: no exponent, no negative zero."""

from __future__ import annotations

import numpy as np

from toolpaths.writing.program import Floats


def number(value: float, digits: int) -> str:
    """A decimal number without exponent, trailing zeros and negative zero."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def printed(values: Floats, digits: int) -> Floats:
    """Values as they will be printed with so many decimals, without negative zeros."""
    return np.asarray(np.round(values, digits) + 0.0)
