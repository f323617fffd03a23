"""Common numbers: against the constrained least squares of a linear problem."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stiffness.effects import BY_NAME
from stiffness.identification.common_numbers import with_common_numbers
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import unknowns
from stiffness.numerics.least_squares import Solution

EFFECT = next(e for e in BY_NAME.values() if any(p.common for p in e.parameters))


def solved(truth: np.ndarray, seed: int = 3) -> tuple[Any, np.ndarray, np.ndarray]:
    """A fit of three common numbers and one beside them, with its design and readings of noise one."""
    rng = np.random.default_rng(seed)
    design = rng.normal(size=(200, 4)) * [30.0, 30.0, 0.5, 20.0]
    read = design @ truth + rng.normal(size=200)
    information = design.T @ design
    covariance = np.linalg.inv(information)
    vector = covariance @ design.T @ read
    solution = Solution(vector, covariance, information, 200.0, 200, 196.0, 1)
    layout = unknowns((EFFECT,), 6)
    return SimpleNamespace(unknowns=layout, solution=solution), design, read


def tied(fit: Any, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, tuple[str, ...]]:
    def changed(old: Any, **new: Any) -> Any:
        return SimpleNamespace(**{**vars(old), **new})

    monkeypatch.setattr("stiffness.identification.common_numbers.replace", changed)
    return with_common_numbers(cast(Fit, fit))


def test_what_cannot_be_split_is_one_number(monkeypatch: pytest.MonkeyPatch) -> None:
    fit, design, read = solved(np.array([0.3, 0.3, 0.3, 1.0]))
    assert abs(fit.solution.vector[2] - 0.3) > 0.02  # it is hardly seen
    one, notes = tied(fit, monkeypatch)
    together = np.column_stack([design[:, :3].sum(axis=1), design[:, 3]])
    expected = np.linalg.lstsq(together, read, rcond=None)[0]
    np.testing.assert_allclose(one.solution.vector, [*[expected[0]] * 3, expected[1]], rtol=1e-9)
    spread = np.linalg.inv(together.T @ together)
    np.testing.assert_allclose(one.solution.covariance[2, 2], spread[0, 0], rtol=1e-6)
    np.testing.assert_allclose(one.solution.covariance[3, 3], spread[1, 1], rtol=1e-6)
    assert len(notes) == 1


def test_what_differs_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    fit, *_ = solved(np.array([0.3, 0.0, 0.3, 1.0]))
    same, notes = tied(fit, monkeypatch)
    np.testing.assert_array_equal(same.solution.vector, fit.solution.vector)
    assert not notes
