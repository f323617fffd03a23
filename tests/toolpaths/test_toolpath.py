"""Toolpath: some of its poses, and poses put into its moves; every column goes along, one that is to come as well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.toolpath import CUT, RAPID, Event, Floats, Toolpath, tool_axis


@dataclass(frozen=True, repr=False)
class WithLoad(Toolpath):
    """A toolpath with one more column."""

    load: Floats | None = None


def path(quaternion: np.ndarray | None = None) -> WithLoad:
    n = 4
    return WithLoad(
        source="a.nc",
        language="gcode",
        position=np.arange(3.0 * n).reshape(n, 3),
        axis=np.tile([0.0, 0.0, 1.0], (n, 1)) if quaternion is None else tool_axis(quaternion),
        quaternion=quaternion,
        feed=np.array([0.1, 0.2, 0.3, 0.4]),
        kind=np.array([RAPID, RAPID, CUT, CUT]),
        tool=np.array([1, 1, 2, 2], dtype=np.int32),
        spindle=np.array([np.nan, 0.0, 500.0, 600.0]),
        sense=np.array([0, 1, 1, -1], dtype=np.int8),
        line=np.array([5, 6, 8, 9], dtype=np.int32),
        row=np.arange(4.0),
        events=(Event(0, "M3", 4), Event(2, "T2", 7), Event(4, "M30", 10)),
        load=np.array([0.0, 10.0, 20.0, 30.0]),
    )


END, ROW = np.array([2, 2, 3]), np.array([1.25, 1.5, 2.5])
POINTS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])


def test_points_take_everything_else_from_the_end_of_their_move() -> None:
    """In the order given, ahead of the pose; every column, and one that this project does not have yet."""
    tilt = np.tile([0.0, 0.6, 0.8], (3, 1))
    got = path().with_points(END, ROW, POINTS, tilt)
    assert isinstance(got, WithLoad) and got.load is not None
    assert got.row.tolist() == [0, 1, 1.25, 1.5, 2, 2.5, 3]
    assert np.array_equal(got.position[[2, 3, 5]], POINTS) and np.array_equal(got.axis[[2, 3, 5]], tilt)
    assert np.array_equal(got.position[[0, 1, 4, 6]], path().position) and got.axis[4].tolist() == [0, 0, 1]
    assert got.feed.tolist() == [0.1, 0.2, 0.3, 0.3, 0.3, 0.4, 0.4]
    assert got.kind.tolist() == [0, 0, 1, 1, 1, 1, 1] and got.tool.tolist() == [1, 1, 2, 2, 2, 2, 2]
    assert got.spindle[1:].tolist() == [0, 500, 500, 500, 600, 600] and got.sense.tolist() == [0, 1, 1, 1, 1, -1, -1]
    assert got.line.tolist() == [5, 6, 8, 8, 8, 9, 9]
    assert got.load.tolist() == [0, 10, 20, 20, 20, 30, 30]


def test_events_stay_ahead_of_the_move() -> None:
    """What stands between two poses of the file comes before the move, so before the poses put into it."""
    got = path().with_points(END, ROW, POINTS, POINTS)
    assert [(e.pose, e.word, e.line) for e in got.events] == [(0, "M3", 4), (2, "T2", 7), (7, "M30", 10)]


def test_orientations_are_quaternions_where_the_path_has_them() -> None:
    """The tool axis follows from them."""
    turned = Rotation.random(7, rng=np.random.default_rng(1))
    wxyz = turned.as_quat()[:, [3, 0, 1, 2]]
    got = path(wxyz[:4]).with_points(END, ROW, POINTS, wxyz[4:])
    assert got.quaternion is not None and np.array_equal(got.quaternion[[2, 3, 5]], wxyz[4:])
    np.testing.assert_allclose(got.axis[[2, 3, 5]], -turned[4:].as_matrix()[:, :, 2], atol=1e-14)


def test_no_points_are_the_same_path() -> None:
    none = np.empty(0, dtype=np.intp)
    got = path().with_points(none, np.empty(0), np.empty((0, 3)), np.empty((0, 3)))
    assert got.events == path().events and np.array_equal(got.position, path().position)


def test_some_poses() -> None:
    """Every column, in the order asked for; events move to the next pose kept; nothing can be written to."""
    got = path().take([1, 3])
    assert isinstance(got, WithLoad) and got.load is not None
    assert got.row.tolist() == [1, 3] and got.load.tolist() == [10, 30] and got.line.tolist() == [6, 9]
    assert [e.pose for e in got.events] == [0, 1, 2]
    for column in (got.position, got.load, path().with_points(END, ROW, POINTS, POINTS).row):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 0.0


def test_a_column_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match=r"Toolpath\.load has 2 rows, position 3"):
        WithLoad(**{**vars(path().take([0, 1, 2])), "load": np.zeros(2)})
