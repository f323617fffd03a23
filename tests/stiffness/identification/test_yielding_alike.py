"""A base without a reflector yields about the axis of joint 1 as that joint does: one motion to all readings."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stiffness.identification.nearest import yielding_alike


@pytest.mark.parametrize(("apart", "alike"), [(0.0, True), (0.005, True), (0.05, False), (1.0, False)])
def test_a_place_that_readings_see_as_a_spring(apart: float, alike: bool) -> None:
    """Spring, base about its axis, an offset that goes with it, a second spring; ``apart``: what tells two."""
    rng = np.random.default_rng(4)
    own = rng.normal(size=(500, 4))
    columns = np.column_stack([own[:, 0], 7 * (own[:, 0] + apart * own[:, 1]), own[:, 0], own[:, 3]])
    free = [SimpleNamespace(parameter=SimpleNamespace(yields=k == 1)) for k in range(4)]

    class Layout:
        def __init__(self) -> None:
            self.free = free

        def __len__(self) -> int:
            return 4

    station = rng.normal(size=(500, 3))
    whole = np.column_stack([columns, station])
    fit: Any = SimpleNamespace(unknowns=Layout(), solution=SimpleNamespace(information=whole.T @ whole))
    first, second = np.array([True, False, False, False]), np.array([False, False, False, True])
    assert yielding_alike(fit, first).tolist() == [False, alike, False, False]
    assert not yielding_alike(fit, second).any() and not yielding_alike(fit, first & second).any()
