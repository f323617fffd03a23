"""Contact: which pose of a program made a point, against circles and lines that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from compensator.trace.contact import TouchingCutter, contacts
from stiffness.session.path_trace import CommandedRows


def line(points: np.ndarray) -> CommandedRows:
    """Rows (R,3) m of one cut with an upright tool."""
    count = len(points)
    axes = np.tile(np.diag([1.0, -1.0, -1.0]), (count, 1, 1))  # z out of the tool, down
    return CommandedRows(
        q=np.zeros((count, 6)), position=points, nominal=points.copy(), wrench=np.zeros((count, 6)), path_axes=axes,
        cut=np.ones(count, dtype=bool), feed=np.full(count, np.nan), first=np.zeros(6, dtype=np.int64),
    )  # fmt: skip


FLAT = TouchingCutter(0.005, 0.0, 0.02)


def test_a_wall_point_belongs_to_the_place_where_the_axis_passes_it() -> None:
    rows = line(np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]))
    found = contacts(np.array([[0.03, 0.005, 0.01], [0.16, -0.005, 0.004], [0.1, 0.05, 0.0]]), rows, FLAT)
    assert found[:2] == pytest.approx([0.3, 1.6]) and np.isnan(found[2])


def test_where_two_passes_touch_a_point_the_last_one_counts() -> None:
    there = np.array([[0.0, 0, 0], [0.1, 0, 0]])
    rows = line(np.concatenate([there, there[::-1]]))
    assert contacts(np.array([[0.03, 0.005, 0.01]]), rows, FLAT)[0] == pytest.approx(2.7)


def test_a_rapid_makes_nothing_and_the_shank_neither() -> None:
    rows = line(np.array([[0.0, 0, 0], [0.1, 0, 0]]))
    idle = replace(rows, cut=np.array([True, False]))
    assert np.isnan(contacts(np.array([[0.03, 0.005, 0.01]]), idle, FLAT)[0])
    assert np.isnan(contacts(np.array([[0.03, 0.005, 0.05]]), rows, FLAT)[0])


@pytest.mark.parametrize(
    ("across", "up", "distance"),
    [(0.006, 0.01, 0.001), (0.0, -0.002, 0.002), (0.003, 0.001, -0.001), (0.008, -0.004, 0.005)],
)
def test_distances_from_a_flat_cutter(across: float, up: float, distance: float) -> None:
    assert FLAT.distance(np.array(across), np.array(up)) == pytest.approx(distance)


def test_distances_from_a_ball() -> None:
    ball = TouchingCutter(0.005, 0.005, 0.02)
    assert ball.distance(np.array(0.0), np.array(0.0)) == pytest.approx(0.0)
    assert ball.distance(np.array(0.006), np.array(0.005)) == pytest.approx(0.001)
    slant = 0.005 / np.sqrt(2)
    assert ball.distance(np.array(slant), np.array(0.005 - slant)) == pytest.approx(0.0, abs=1e-9)
