"""Numbers and units as reports write them: plain text, for pages and for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

LENGTHS = {"m": ("mm", 1e3), "rad": ("mrad", 1e3)}  # unit of the model file -> shown unit, factor
RATES = {
    "m/N": ("µm/N", 1e6),
    "rad/(N*m)": ("µrad/(N·m)", 1e6),
    "1/K": ("ppm/K", 1e6),
    "rad/K": ("µrad/K", 1e6),
    "m/s": ("nm/s", 1e9),
    "rad/s": ("nrad/s", 1e9),
}
ROUNDING = 1e-9  # mm: what is smaller comes from rounding, and is none
_TAILS = (
    *("_nm_per_rad", "_m_per_n", "_rad_per_nm", "_rad_per_k", "_m_per_s", "_rad_per_s"),
    *("_per_k", "_rad", "_nm", "_kg", "_m", "_n"),
)


def deflection_mm(value: float) -> str:
    """Millimetres to the micrometre: no model of a robot tells more, and no robot repeats that well."""
    return "< 0.001" if ROUNDING < value < 5e-4 else f"{value:.3f}"


def residual_mm(value: float) -> str:
    """Millimetres with four significant digits, no exponent down to 1 nm."""
    if value == 0 or not np.isfinite(value):
        return f"{value:g}"
    return f"{value:.{int(np.clip(3 - np.floor(np.log10(abs(value))), 0, 6))}f}"


def rounded(value: float, sd: float) -> str:
    """A number to the second significant digit of its standard deviation."""
    if not np.isfinite(value):
        return "∞" if value > 0 else "-∞"
    if not (np.isfinite(sd) and sd > 0):
        return f"{value:.6g}"
    digits = 1 - int(np.floor(np.log10(sd)))
    if digits > 9:
        return f"{value:.4g}"
    return f"{round(value, digits) + 0.0:,.{max(digits, 0)}f}"


def with_sd(value: float, sd: float) -> str:
    """A number and its standard deviation; one that was searched for, not fitted, has none."""
    return f"{rounded(value, sd)} ± {rounded(sd, sd)}" if sd > 0 else f"{value:.4g}"


def shown_unit(unit: str, *, rates: bool = True) -> tuple[str, float]:
    """The unit that a reader sees, and the factor to it; without ``rates`` only lengths and angles are scaled."""
    known = LENGTHS | RATES if rates else LENGTHS
    shown, factor = known.get(unit, (unit, 1.0))
    return shown.replace("*", "·"), factor


def parameter_words(name: str) -> str:
    """A parameter's name without its unit, which stands behind the number."""
    for tail in _TAILS:
        if name.endswith(tail):
            return name.removesuffix(tail).replace("_", " ")
    return name.replace("_", " ")


def joined(words: Sequence[str], last: str = "and") -> str:
    """a, b and c."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"
