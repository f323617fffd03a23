"""What surrounds the arm at one instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

REFERENCE = 20.0  # deg C, where the arm is as its file says


@dataclass(frozen=True)
class Moment:
    """Clock (s), climate (deg C) and whatever else is written in a column of its own."""

    time: float = 0.0
    temperature: float = REFERENCE
    columns: Mapping[str, float] = field(default_factory=dict)
