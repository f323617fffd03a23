"""Sharing: work on many things, one after the other, of which somebody else may do a part.

Nothing here knows who: whoever runs a long job says it once (``shared_by``), and files are then written, or read back,
by several at a time. The results are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

A = TypeVar("A")
B = TypeVar("B")

#: (work, things, poses that they are about) -> what the work makes of each thing, in their order.
Share = Callable[[Callable[[Any], Any], Sequence[Any], int], list[Any]]

_SHARE: ContextVar[Share | None] = ContextVar("share", default=None)


def each(work: Callable[[A], B], things: Sequence[A], *, poses: int) -> list[B]:
    """What ``work`` makes of each thing, in their order; it may leave files behind, but keeps nothing in memory.

    Args:
        poses: that all of them are about: few are not worth sharing.
    """
    share = _SHARE.get()
    return [work(thing) for thing in things] if share is None else share(work, things, poses)


def is_shared() -> bool:
    """Whether somebody else may do a part."""
    return _SHARE.get() is not None


@contextmanager
def shared_by(share: Share) -> Iterator[None]:
    """Let ``share`` do what is given to ``each`` inside."""
    token = _SHARE.set(share)
    try:
        yield
    finally:
        _SHARE.reset(token)
