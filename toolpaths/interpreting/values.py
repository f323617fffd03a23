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


def first_runtime(*values: Any) -> Runtime | None:
    """The first value that only the controller knows."""
    return next((v for v in values if isinstance(v, Runtime)), None)
