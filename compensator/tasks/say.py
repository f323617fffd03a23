"""Progress: how a task reports what it is doing."""

from __future__ import annotations

from collections.abc import Callable

Say = Callable[[str], None]


def quiet(_: str) -> None:
    """Report no progress."""
