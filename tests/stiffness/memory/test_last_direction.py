"""The direction of the last real travel: rounding in a command is no reversal."""

from __future__ import annotations

import numpy as np
import pytest

import stiffness.memory.last_direction as last_direction_module
from stiffness.effects.effect import REVERSAL
from stiffness.memory.last_direction import last_direction


def test_it_is_the_sign_of_the_last_travel() -> None:
    move = np.array([[0.0], [0.1], [0.0], [-0.2], [-0.1], [0.3]])
    assert last_direction(move).ravel().tolist() == [0, 1, 1, -1, -1, 1]


def test_less_than_a_reversal_changes_nothing() -> None:
    move = np.array([[0.1], [-0.3 * REVERSAL], [0.2 * REVERSAL], [-2 * REVERSAL]])
    directions = last_direction(move).ravel()
    assert directions[0] == 1 and directions[-1] == -1 and -1 not in directions[:-1]


def test_joints_are_apart_and_no_pose_is_no_direction() -> None:
    move = np.array([[0.1, -0.1], [-0.1, 0.0]])
    assert last_direction(move).tolist() == [[1, -1], [-1, -1]]
    assert last_direction(np.empty((0, 6))).shape == (0, 6)


def test_how_many_poses_are_looked_at_together_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    move = np.random.default_rng(2).normal(0.0, REVERSAL, size=(200, 3))
    whole = last_direction(move)
    monkeypatch.setattr(last_direction_module, "TOGETHER", 7)
    np.testing.assert_array_equal(last_direction(move), whole)
    assert {-1.0, 1.0} <= set(whole.ravel().tolist())
