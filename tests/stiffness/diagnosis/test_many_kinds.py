"""Three kinds of effects that leave more than noise are no explanation, as one or two may be."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from stiffness.diagnosis import structure
from stiffness.effects import BY_NAME

NAMES = ["payload", "tracker-drift", "joint-friction"]


def fit(misfit: float) -> Any:
    """Of 2,000 readings."""
    solution = SimpleNamespace(chi2=2000 * misfit**2, freedom=2000.0, noises=misfit)
    return SimpleNamespace(solution=solution, sessions=(), unknowns=SimpleNamespace(effects=()))


@pytest.mark.parametrize(
    ("misfit", "kinds", "known", "left"),
    [
        (1.1, 2, 0, False),
        (1.1, 3, 0, True),
        (1.1, 3, 1, False),  # the model at hand had one of them
        (1.25, 2, 0, False),  # a law that is not exact
        (1.25, 3, 0, True),
        (1.0, 3, 0, False),
    ],
)
def test_many_kinds_have_to_leave_noise(
    monkeypatch: pytest.MonkeyPatch, misfit: float, kinds: int, known: int, left: bool
) -> None:
    source = SimpleNamespace(what="joint-3", fraction=0.05, is_place=True)
    monkeypatch.setattr(structure, "_sources", lambda search, fit: [source])
    monkeypatch.setattr(structure, "of_all_readings", lambda fits, additions, fit: (fits, fit))
    additions: list[Any] = [SimpleNamespace(effect=BY_NAME[name]) for name in NAMES[:kinds]]
    search: Any = SimpleNamespace(known=tuple(additions[:known]), fits=None)
    seen = structure._seen(search, fit(9.0), fit(misfit), additions)
    assert (seen.structure.left, seen.additions) == (left, additions)
