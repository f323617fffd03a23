"""When each state was read, how warm it was, and what the further columns said then."""

from __future__ import annotations

from collections.abc import Sequence

from .lab_request import Form
from .moment import REFERENCE, Moment


def moments(form: Form, keys: Sequence[tuple[int, int, int, int]]) -> dict[tuple[int, int], Moment]:
    """(set-up, state) -> the moment of its first reading. keys: (set-up, state, repeat, target) in reading order."""
    found: dict[tuple[int, int], Moment] = {}
    for number, (i, k, _, _) in enumerate(keys):
        if (i, k) in found:
            continue
        time = number * (form.seconds or 0.0)
        warm = REFERENCE if form.climate is None else form.climate(time)
        columns = {name: float(v[i]) for name, v in form.extra.items() if isinstance(v[i], int | float)}
        found[i, k] = Moment(time, warm, columns)
    return found
