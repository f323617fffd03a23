"""Poses put between two others: where they lie, what they carry, and the one just before a corner."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from compensator.path.added_poses import BEFORE_CORNER, rows_between, with_poses_before_corners, with_poses_between
from tests.compensator.handmade_toolpaths import angle, toolpath, wandering_axes
from toolpaths.toolpath import CUT, RAPID, Event, Setting


def test_between_lies_on_the_line_and_carries_the_end() -> None:
    """Position and row linear; feed, kind, tool and line those of the move's end; events stay with their pose."""
    path = toolpath(
        [[0, 0, 0], [10, 0, 0], [10, 20, 0]], "rrc",
        feed=np.array([0.1, 0.2, 0.3]), tool=np.array([1, 1, 2], dtype=np.int32),
        events=(Event(0, "M3", 1), Event(2, "T2", 4), Event(3, "M30", 9)),
    )  # fmt: skip
    got = with_poses_between(path, np.array([0, 1, 1]), np.array([0.5, 0.25, 0.75]))
    assert rows_between(np.array([0, 1, 1])).tolist() == [1, 3, 4]
    assert np.allclose(got.position * 1e3, [[0, 0, 0], [5, 0, 0], [10, 0, 0], [10, 5, 0], [10, 15, 0], [10, 20, 0]])
    assert np.allclose(got.row, [0, 0.5, 1, 1.25, 1.75, 2])
    assert got.feed.tolist() == [0.1, 0.2, 0.2, 0.3, 0.3, 0.3]
    assert got.kind.tolist() == [RAPID, RAPID, RAPID, CUT, CUT, CUT]
    assert got.tool.tolist() == [1, 1, 1, 2, 2, 2] and got.line.tolist() == [2, 3, 3, 4, 4, 4]
    assert [(e.pose, e.word) for e in got.events] == [(0, "M3"), (5, "T2"), (6, "M30")]


def test_between_keeps_what_the_program_says_of_itself() -> None:
    """Without the setting nobody knows where rails and tables stand, nor in which work object the poses are."""
    setting = Setting({}, np.eye(4), {}, np.zeros(3), np.zeros(3, dtype=np.int32), {"E1": np.full(3, 1200.0)})
    path = toolpath([[0, 0, 0], [10, 0, 0], [10, 20, 0]], "rcc", setting=setting)
    assert with_poses_between(path, np.array([1]), np.array([0.5])).setting is setting
    assert with_poses_before_corners(path).setting is setting and len(with_poses_before_corners(path)) == 4


def test_between_turns_the_shorter_way() -> None:
    """Axes on the great circle, quaternions by slerp, whatever sign the file gives them; against SciPy."""
    g = np.random.default_rng(3)
    rotations = Rotation.random(40, rng=g)
    xyzw = rotations.as_quat() * np.where(g.random(40) < 0.5, -1, 1)[:, None]
    path = toolpath(g.normal(size=(40, 3)), quaternion=xyzw[:, [3, 0, 1, 2]])
    fraction = g.uniform(0.01, 0.99, 39)
    got, added = with_poses_between(path, np.arange(39), fraction), rows_between(np.arange(39))
    assert got.quaternion is not None
    new = Rotation.from_quat(got.quaternion[added][:, [1, 2, 3, 0]])
    expected = Slerp(np.arange(40), rotations)(np.arange(39) + fraction)
    assert np.max((new * expected.inv()).magnitude()) < 1e-7
    axis = wandering_axes(40, 5, [0.3, 0.2, 1], 0.6)
    path = toolpath(g.normal(size=(40, 3)), axis=axis)
    got, added = with_poses_between(path, np.arange(39), fraction), rows_between(np.arange(39))
    assert np.allclose(np.linalg.norm(got.axis, axis=1), 1)
    turn = np.arccos(np.sum(axis[:-1] * axis[1:], axis=1))
    assert np.allclose(np.arccos(np.sum(axis[:-1] * got.axis[added], axis=1)), fraction * turn, atol=1e-7)
    assert np.allclose(np.arccos(np.sum(axis[1:] * got.axis[added], axis=1)), (1 - fraction) * turn, atol=1e-7)


def test_a_pose_just_before_every_sharp_corner() -> None:
    """0.05 mm before, on the arriving segment; none at a gentle bend, nor before a rapid's corner."""
    square = [[0, 0, 0], [40, 0, 0], [40, 40, 0], [80, 43, 0], [120, 42, 0], [120, 90, 0], [0, 90, 0]]
    path = toolpath(square, "rcccrrr")
    got = with_poses_before_corners(path)
    new = np.setdiff1d(got.row, path.row)
    assert len(got) == len(path) + 2
    assert np.allclose(new, [1 - 0.05 / 40, 2 - 0.05 / 40], atol=1e-9)  # at (40, 0) and (40, 40)
    where = np.searchsorted(got.row, new)
    assert np.allclose(got.position[where] * 1e3, [[39.95, 0, 0], [40, 39.95, 0]], atol=1e-9)
    assert got.kind[where].tolist() == [CUT, CUT] and got.line[where].tolist() == [3, 4]
    assert pytest.approx(5e-5) == BEFORE_CORNER


def test_facets_of_a_curve_get_none() -> None:
    """A polygon of many small segments, each turning by a few degrees, stays as it is."""
    t = np.linspace(0, 2 * np.pi, 181)
    circle = np.column_stack([100 * np.cos(t), 100 * np.sin(t), 0 * t])
    assert with_poses_before_corners(toolpath(circle)).position.shape == (181, 3)
    back = toolpath([[0, 0, 0], [30, 0, 0], [0, 0, 0]])  # a full reversal is the sharpest corner there is
    assert len(with_poses_before_corners(back)) == 4
    assert len(with_poses_before_corners(toolpath([[0, 0, 0], [30, 0, 0]]))) == 2


def test_rotations_agree() -> None:
    """The test's own angle function: 1 deg is 1 deg."""
    a = Rotation.from_euler("z", [[0], [10]], degrees=True).as_matrix()
    b = Rotation.from_euler("z", [[1], [11]], degrees=True).as_matrix()
    assert np.allclose(np.degrees(angle(a, b)), 1)
