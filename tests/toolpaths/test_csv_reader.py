"""CSV poses: values, and every mistake by row and column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import CUT, RAPID, Toolpath

HEADER = "x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind\n"


def read(tmp_path: Path, text: str | bytes) -> Toolpath:
    file = tmp_path / "poses.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_toolpath(file)


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


GOOD = "1,2,3,0,0,1,60,cut\n"
REFUSED = {
    "x_mm,y_mm,i,j,k\n1,2,0,0,1\n": (1, "missing column z_mm"),
    "x_mm,y_mm,z_mm\n1,2,0\n": (1, "missing column i, j, k (or qw"),
    "x_mm,y_mm,z_mm,qw,qx,qy\n1,2,0,1,0,0\n": (1, "missing column qz"),
    "x_mm,y_mm,z_mm,i,j,k,qw,qx,qy,qz\n": (1, "both"),
    "x,y,z,i,j,k\n1,2,3,0,0,1\n": (1, "unknown column 'x'"),
    "x_mm,y_mm,z_mm,i,j,k,i\n1,2,3,0,0,1,1\n": (1, "'i' stands twice"),
    "x_mm;y_mm;z_mm;i;j;k\n1,0;2;3;0;0;1\n": (1, "not separated by commas"),
    "x_mm\ty_mm\tz_mm\ti\tj\tk\n1\t2\t3\t0\t0\t1\n": (1, "not separated by commas"),
    HEADER: (None, "no pose"),
    HEADER + GOOD + "1,2,3,0,0,1,60\n": (3, "7 values, the header has 8"),
    HEADER + GOOD + "1,2\n": (3, "2 values"),
    HEADER + GOOD + "1,5,2,3,0,0,1,60,cut\n": (3, "9 values"),
    HEADER + GOOD + GOOD + "1,zwei,3,0,0,1,60,cut\n": (4, "column y_mm: 'zwei'"),
    HEADER + "1,2,,0,0,1,60,cut\n": (2, "column z_mm: an empty cell"),
    HEADER + GOOD + "1,2,nan,0,0,1,60,cut\n": (3, "column z_mm: nan"),
    HEADER + GOOD + "-inf,2,3,0,0,1,60,cut\n": (3, "column x_mm: -inf"),
    HEADER + GOOD + "1e400,2,3,0,0,1,60,cut\n": (3, "column x_mm: inf"),
    HEADER + GOOD + "2e6,2,3,0,0,1,60,cut\n": (3, "beyond 1e+06"),
    HEADER + GOOD + "1,2,3,0,0,0,60,cut\n": (3, "i, j, k: length 0"),
    HEADER + GOOD + "1,2,3,0,0.1,1,60,cut\n": (3, "i, j, k: length 1.00499"),
    "x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,0,0,0\n": (2, "qw, qx, qy, qz: length 0"),
    HEADER + GOOD + "1,2,3,0,0,1,60,drill\n": (3, "column kind: 'drill'"),
    HEADER + GOOD + "1,2,3,0,0,1,60,cutting_with_long_word\n": (3, "'cutting_with_long_word'"),
    HEADER + GOOD + "1,2,3,0,0,1,0,cut\n": (3, "column feed_mm_min: 0, above 0"),
    HEADER + GOOD + "1,2,3,0,0,1,-5,rapid\n": (3, "column feed_mm_min: -5"),
    HEADER + GOOD + "<<<<<<< HEAD\n" + GOOD: (3, "merge-conflict"),
}


@pytest.mark.parametrize(("text", "expected"), REFUSED.items(), ids=[v[1] for v in REFUSED.values()])
def test_refused_by_row_and_column(tmp_path: Path, text: str, expected: tuple[int | None, str]) -> None:
    with pytest.raises(ReadError) as caught:
        read(tmp_path, text)
    assert caught.value.line == expected[0]
    assert expected[1] in str(caught.value)
