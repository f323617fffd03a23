"""Numbers and units as devices write them; what is none is refused by file and line."""

from __future__ import annotations

import math
import re

from compensator.errors import DeviceError

_UNITS = {
    1.0: ("mm", "millimeter", "millimetre", "millimeters", "millimetres"),
    25.4: ("in", "inch", "inches", '"'),
    1e-3: ("um", "µm", "μm", "micron", "microns", "micrometer", "micrometre"),
    10.0: ("cm", "centimeter", "centimetre"),
    1000.0: ("m", "meter", "metre", "meters", "metres"),
}
#: Name of a unit of length -> mm in it.
MM_IN = {name: size for size, names in _UNITS.items() for name in names}
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?$")
LARGEST = 1e9


def number(word: str, label: str, line: int, what: str) -> float:
    """A finite number; ``.5`` and ``0.`` are numbers too.

    Raises:
        DeviceError: names the line, what stands there, and what was expected.
    """
    value = float(word) if _NUMBER.match(word) else math.nan
    if math.isfinite(value) and abs(value) < LARGEST:
        return value
    hint = "; a decimal sign is a point" if re.match(r"[-+]?\d+,\d+$", word) else ""
    shown = repr(word[:40]) if word else "nothing"
    raise DeviceError(f"{label}: line {line}: {what} is {shown}, expected a number{hint}; correct it or export again")


def is_number(word: str) -> bool:
    """Whether a word is a number."""
    return bool(_NUMBER.match(word))
