"""The same readings given twice: their noise would count as half of what it is, and nothing new would be known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffness.session.session import Session
from stiffness.session.table import SessionError


def refuse_twice(sessions: Sequence[Session]) -> None:
    """Refuse two sessions with the same readings, whatever the path or the layout of their files.

    Raises:
        SessionError: names both.
    """
    for k, b in enumerate(sessions):
        for a in sessions[:k]:
            if _same(a, b):
                raise SessionError(
                    f"{b.samples_file}: the same {len(b)} readings as {a.samples_file}, given twice: they would count "
                    f"as twice as many. Give {a.source} once"
                )


def _same(a: Session, b: Session) -> bool:
    if a.sha256["samples"] == b.sha256["samples"] or len(a) != len(b):
        return a.sha256["samples"] == b.sha256["samples"] and len(a) == len(b)
    x, y = (np.column_stack([s.samples.q, s.samples.position, s.samples.load.wrench]) for s in (a, b))
    if x.shape != y.shape:
        return False
    x, y = (v[np.lexsort(v.T)] for v in (x, y))
    return bool(np.allclose(x, y, rtol=0, atol=1e-9))
