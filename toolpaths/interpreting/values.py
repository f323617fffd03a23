"""Values of robot programs: known ones are plain Python, those that only the controller knows are Runtime."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


class ExpressionError(Exception):
    """The text cannot be evaluated as an expression."""


@dataclass(frozen=True)
class Runtime:
    """A value that only the controller knows while the program runs; ``reason`` names its origin."""

    reason: str


@dataclass(frozen=True)
class OnUnit(Runtime):
    """A frame on a mechanical unit, which only the controller knows while the program runs.

    Attributes:
        unit: its name, or its number in MACHINE_DEF. pose: rows of (4, 4) in the frame of the unit, m.
    """

    unit: str | int
    pose: tuple[tuple[float, ...], ...]

    @property
    def key(self) -> str:
        """The same for the same frame."""
        return f"{self.unit!r} {self.pose!r}"


def first_runtime(*values: Any) -> Runtime | None:
    """The first value that only the controller knows, for what is worked out from it: that is no frame on a unit."""
    found = next((v for v in values if isinstance(v, Runtime)), None)
    return Runtime(found.reason) if isinstance(found, OnUnit) else found
