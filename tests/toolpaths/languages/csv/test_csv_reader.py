"""CSV poses: values, and every mistake by row and column."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tests.oracles.read_text import read_text
from toolpaths.toolpath import CLOCKWISE, COUNTERCLOCKWISE, CUT, RAPID, SENSE_OPEN

HEADER = "x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind\n"

read = partial(read_text, "poses.csv")


def test_values(tmp_path: Path) -> None:
    text = HEADER + "1.5,-2,30,0,0,1,0,rapid\n4,5e1,-6,0.6,0,0.8,1200,cut\n"
    path = read(tmp_path, text)
    np.testing.assert_allclose(path.position, [[1.5e-3, -2e-3, 0.03], [4e-3, 0.05, -6e-3]], rtol=1e-15)
    np.testing.assert_allclose(path.axis, [[0, 0, 1], [0.6, 0, 0.8]], rtol=0, atol=1e-15)
    np.testing.assert_array_equal(path.kind, [RAPID, CUT])
    np.testing.assert_allclose(path.feed, [np.nan, 0.02], rtol=1e-15)
    np.testing.assert_array_equal(path.line, [2, 3])
    np.testing.assert_array_equal(path.row, [0, 1])
    np.testing.assert_array_equal(path.tool, [0, 0])
    assert path.quaternion is None and path.language == "csv" and path.events == ()


def test_spellings_of_the_same_file_agree(tmp_path: Path) -> None:
    text = HEADER + "1,2,3,0,0,1,60,cut\n4,5,6,0,0.6,-0.8,120,rapid\n"
    plain = read(tmp_path, text)
    shuffled = "kind, k ,z_mm,y_mm,x_mm,feed_mm_min,i,j\n cut,1, 3,2,1,60,0,0\nrapid,-0.8,6,5,4,120,0,0.6\n\n"
    for other in (
        text.replace("\n", "\r\n").encode(),
        b"\xef\xbb\xbf" + text.encode(),
        text.rstrip().encode(),
        shuffled,
    ):
        path = read(tmp_path, other)
        for name in ("position", "axis", "feed", "kind", "line", "row"):
            np.testing.assert_array_equal(getattr(path, name), getattr(plain, name), err_msg=name)


def test_spindle(tmp_path: Path) -> None:
    """An empty cell gives none; m5 stands; without the columns nothing is known."""
    head = "x_mm,y_mm,z_mm,i,j,k,spindle_rpm,spindle\n"
    path = read(tmp_path, head + "0,0,5,0,0,1,,\n0,0,0,0,0,1,12000,m3\n1,0,0,0,0,1,6000, M4\n2,0,0,0,0,1,6000,m5\n")
    np.testing.assert_allclose(path.spindle, [np.nan, 400 * np.pi, 200 * np.pi, 0.0], rtol=1e-15)
    np.testing.assert_array_equal(path.sense, [SENSE_OPEN, CLOCKWISE, COUNTERCLOCKWISE, SENSE_OPEN])
    bare = read(tmp_path, HEADER + "1,2,3,0,0,1,60,cut\n")
    assert np.isnan(bare.spindle).all() and (bare.sense == SENSE_OPEN).all()


def test_blank_lines_keep_the_line_numbers(tmp_path: Path) -> None:
    path = read(tmp_path, "x_mm,y_mm,z_mm,i,j,k\n1,2,3,0,0,1\n\n\n4,5,6,0,0,1\n")
    np.testing.assert_array_equal(path.line, [2, 5])
    np.testing.assert_array_equal(path.row, [0, 1])
    assert np.isnan(path.feed).all() and (path.kind == CUT).all()


def test_quaternions_give_the_axis_and_are_normalised(tmp_path: Path) -> None:
    rotations = Rotation.random(200, random_state=7)
    quaternion = np.roll(rotations.as_quat(), 1, axis=1)  # scipy has w last
    rows = "".join("0,0,0," + ",".join(f"{v * 1.0005:.8f}" for v in q) + "\n" for q in quaternion)
    path = read(tmp_path, "x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + rows)
    assert path.quaternion is not None
    np.testing.assert_allclose(path.quaternion, quaternion, rtol=0, atol=2e-8)
    np.testing.assert_allclose(np.linalg.norm(path.quaternion, axis=1), 1.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.axis, -rotations.as_matrix()[:, :, 2], rtol=0, atol=1e-7)
