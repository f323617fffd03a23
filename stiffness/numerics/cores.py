"""Cores: how many this process may use, and how many of them are left to it while another works beside it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_LEFT: ContextVar[Callable[[], int] | None] = ContextVar("cores", default=None)


def cores() -> int:
    """Cores that this process may use; on a shared machine fewer than there are."""
    allowed = getattr(os, "sched_getaffinity", None)  # not on every system
    count = len(allowed(0)) if allowed else os.cpu_count() or 1
    left = _LEFT.get()
    return count if left is None else min(left(), count)


def keep(count: int) -> None:
    """Use so many from here on: what a process that works for another one is told once."""
    _LEFT.set(lambda: count)


@contextmanager
def left_with(count: int | Callable[[], int]) -> Iterator[None]:
    """Use so many at most inside; a function tells how many at the moment."""
    token = _LEFT.set(count if callable(count) else lambda: count)
    try:
        yield
    finally:
        _LEFT.reset(token)
