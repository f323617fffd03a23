"""Processes of several sessions: effects of the process hold for one material and one cutter, those of a model file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from stiffness.session.session import Session

Names = tuple[str, str]  # of material and cutter; "" where they are not told


def process_of(sessions: Sequence[Session]) -> Names:
    """Names of the material and the cutter that effects of the process hold for."""
    return next((p for p in map(_cut, sessions) if p is not None), ("", ""))


def of_one_process(sessions: Sequence[Session], known: Iterable[Names] = ()) -> tuple[Session, ...]:
    """Sessions in which effects of the process act in traces of one material and cutter only; all others are taken to
    have cut as their process says, and a note of theirs tells so.

    Args:
        known: names that a model has effects of the process for: the first that was traced is the one, else that of
            the first trace.
    """
    traced = [p for p in map(_cut, sessions) if p is not None]
    if len(set(traced)) < 2:
        return tuple(sessions)
    one = next((names for names in known if names in traced), traced[0])
    return tuple(s if _cut(s) in (None, one) else _as_said(s, one) for s in sessions)


def in_words(names: Names) -> str:
    """Material and cutter, as a message tells them."""
    told = [f"{key} {value!r}" for key, value in zip(("material", "cutter"), names, strict=True) if value]
    return ", ".join(told) or "a process without names"


def _cut(session: Session) -> Names | None:
    """What was cut, with what; None: nothing, or it is taken as said."""
    path = session.path
    return None if path is None or path.dry or path.as_said else path.process


def _as_said(session: Session, one: Names) -> Session:
    path = session.path
    if path is None:
        return session
    note = (
        f"{session.source}: cut {in_words(path.process)} as its process says: effects of the process are looked for in "
        f"{in_words(one)} only, one material and cutter at a time; give this trace first, or alone, to look there"
    )
    return replace(session, path=replace(path, as_said=True, notes=(*path.notes, note)))
