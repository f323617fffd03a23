"""Frames of SINUMERIK programs and CYCLE800, against rotations of scipy; how the tool stands in them."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.read_text import read_text
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.machine import Machine
from toolpaths.toolpath import Toolpath

HEAD = "G710 G90 G17\nF600\n"
PLACE = np.array([7.0, -11.0, 13.0])
read = partial(read_text, "part.mpf")


def last(tmp_path: Path, frames: str) -> Toolpath:
    """The pose at PLACE under frames."""
    path = read(tmp_path, f"{HEAD}{frames}\nG0 X7 Y-11 Z13\nM30\n")
    return path.take([len(path) - 1])


def shifted(place: np.ndarray, x: float, y: float, z: float) -> np.ndarray:
    return np.asarray(place + np.array([x, y, z]))


def turned(order: str, *angles: float) -> Rotation:
    return Rotation.from_euler(order, angles, degrees=True)


FRAMES = {
    "TRANS X1 Y2 Z3": shifted(PLACE, 1, 2, 3),
    "TRANS X9 Y9 Z9\nTRANS X1 Y2 Z3": shifted(PLACE, 1, 2, 3),
    "TRANS X9 Y9 Z9\nATRANS X1 Y2 Z3": shifted(PLACE, 10, 11, 12),
    "TRANS X9\nTRANS": PLACE,
    "ROT X20 Y30 Z40": turned("ZYX", 40, 30, 20).apply(PLACE),
    "ROT Z40\nAROT X20": turned("ZX", 40, 20).apply(PLACE),
    "ROT X20\nROT Z40": turned("Z", 40).apply(PLACE),
    "ROT RPL=40": turned("Z", 40).apply(PLACE),
    "G18\nROT RPL=40": turned("Y", 40).apply(PLACE),
    "G19\nROT RPL=40": turned("X", 40).apply(PLACE),
    "TRANS X1 Y2 Z3\nAROT Z40": shifted(turned("Z", 40).apply(PLACE), 1, 2, 3),
    "ROT Z40\nATRANS X1 Y2 Z3": turned("Z", 40).apply(shifted(PLACE, 1, 2, 3)),
    "TRANS X1\nROT Z40": turned("Z", 40).apply(PLACE),
}


@pytest.mark.parametrize("frames", FRAMES)
def test_programmable_frames(tmp_path: Path, frames: str) -> None:
    """The tool stands as before: only the coordinates count from elsewhere."""
    path = last(tmp_path, frames)
    np.testing.assert_allclose(path.position * 1e3, [FRAMES[frames]], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(path.axis, [[0, 0, 1]])


def test_frames_count_in_the_unit_of_the_file(tmp_path: Path) -> None:
    path = read(tmp_path, "G700 G90\nTRANS X1\nG0 X1 Y0 Z0\nM30\n")
    np.testing.assert_allclose(path.position * 1e3, [[50.8, 0, 0]], rtol=0, atol=1e-12)


#: Mode, angles A B C, and the same as a rotation.
PLANES = {
    57: turned("XYZ", 20, 30, 40), 39: turned("ZXY", 20, 30, 40), 27: turned("ZYX", 20, 30, 40),
    45: turned("XZY", 20, 30, 40), 30: turned("YZX", 20, 30, 40), 54: turned("YXZ", 20, 30, 40),
    64: turned("ZY", 20, 30),
}  # fmt: skip


@pytest.mark.parametrize("mode", PLANES)
def test_cycle800(tmp_path: Path, mode: int) -> None:
    """Point, rotation, shift in the plane; the tool stands at right angles to it."""
    path = last(tmp_path, f'CYCLE800(1,"TC1",0,{mode},1,2,3,20,30,40,4,5,6,-1,100,1)')
    plane = PLANES[mode]
    np.testing.assert_allclose(
        path.position * 1e3, [shifted(plane.apply(shifted(PLACE, 4, 5, 6)), 1, 2, 3)], rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(path.axis, [plane.apply([0, 0, 1])], rtol=0, atol=1e-14)


def test_a_plane_on_a_plane_and_frames_on_it(tmp_path: Path) -> None:
    first, second = 'CYCLE800(1,"",0,57,1,2,3,20,0,0,0,0,0,-1)', 'CYCLE800(1,"",1,57,4,5,6,0,30,0,0,0,0,-1)'
    path = last(tmp_path, f"TRANS X99\n{first}\n{second}\nATRANS X7\nAROT Z10")
    place = shifted(turned("Z", 10).apply(PLACE), 7, 0, 0)
    place = shifted(turned("X", 20).apply(shifted(turned("Y", 30).apply(place), 4, 5, 6)), 1, 2, 3)
    np.testing.assert_allclose(path.position * 1e3, [place], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.axis, [turned("XY", 20, 30).apply([0, 0, 1])], rtol=0, atol=1e-14)
    with pytest.raises(ReadError, match="adds to the plane before, and TRANS or ROT is on"):
        last(tmp_path, f"{first}\nTRANS X5\n{second}")


UPRIGHT = ["CYCLE800()", "CYCLE800", 'CYCLE800(1,"TC1",0,57,0,0,0,0,0,0,0,0,0,-1)', 'CYCLE800(1,"0")']


@pytest.mark.parametrize("end", UPRIGHT)
def test_cycle800_ends(tmp_path: Path, end: str) -> None:
    path = last(tmp_path, f'CYCLE800(1,"TC1",0,57,1,2,3,20,30,40,0,0,0,-1)\nG0 X0 Y0 Z0\n{end}')
    np.testing.assert_allclose(path.position * 1e3, [PLACE], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(path.axis, [[0, 0, 1]])


def test_where_the_tool_is_after_a_plane_is_not_known(tmp_path: Path) -> None:
    """The swivel lets it stand in the machine; with _ST 10 its tip is carried along with the work."""
    text = "G0 X0 Y0 Z50\nCYCLE800(1,\"\",{},57,0,0,0,0,90,0,0,0,0,-1)\nG0 X5\nZ6\nM30\n"
    path = read(tmp_path, HEAD + text.format(0) .replace("Z6\n", "Z6\nY0\n"))
    assert path.line.tolist() == [3, 7] and "G0 X5, before the position is known" in [e.word for e in path.events]
    path = read(tmp_path, HEAD + text.format(10))
    np.testing.assert_allclose(path.position * 1e3, [[0, 0, 50], [0, 0, -5], [6, 0, -5]], rtol=0, atol=1e-12)


def test_only_the_coordinates_are_tilted(tmp_path: Path) -> None:
    """_DIR 0: the axes are not turned, so words of the program have to turn them, or the tool stands elsewhere."""
    text = 'G0 X0 Y0 Z50\nCYCLE800(1,"",0,57,0,0,0,0,30,0,0,0,0,0)\n{}G0 X0 Y0 Z9\nM30\n'
    assert read(tmp_path, HEAD + text.format("G0 B=DC(30) C=DC(0)\n")).axis[-1] == pytest.approx(
        [0.5, 0, np.sqrt(0.75)]
    )


def test_vectors_under_traori(tmp_path: Path) -> None:
    """Any length, a part that is missing is 0, in the frame in force; a vector stays until the next."""
    text = "ROT Z90\nTRAORI\nG0 X1 Y0 Z0 A3=3 C3=4\nG1 X2\nX3 A3=0 B3=1 C3=0\nTRAFOOF\nTRANS\nCYCLE800()\nG0 X0 Y0 Z0\n"
    path = read(tmp_path, HEAD + text + "M30\n")
    np.testing.assert_allclose(path.axis, [[0, 0.6, 0.8], [0, 0.6, 0.8], [-1, 0, 0], [0, 0, 1]], rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.position[:3] * 1e3, [[0, 1, 0], [0, 2, 0], [0, 3, 0]], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("word", "axis"),
    [
        ("ORIRPY\nG1 X1 A2=20 B2=30 C2=40", turned("ZYX", 40, 30, 20)),
        ("ORIRPY2\nG1 X1 A2=20 B2=30 C2=40", turned("XYZ", 20, 30, 40)),
        ("ORIEULER\nG1 X1 A2=20 B2=30 C2=40", turned("ZXZ", 20, 30, 40)),
    ],
)
def test_angles_under_traori(tmp_path: Path, word: str, axis: Rotation) -> None:
    path = read(tmp_path, f"{HEAD}TRAORI\nG0 X0 Y0 Z0\n{word}\nM30\n")
    np.testing.assert_allclose(path.axis[-1], axis.apply([0, 0, 1]), rtol=0, atol=1e-14)


def test_settable_frames(tmp_path: Path) -> None:
    """Coordinates count from G54; a second one only where the cell says how the two lie."""
    assert read(tmp_path, "G710 G54\nG0 X1 Y2 Z3\nG54 X2\nM30\n").position[1] == pytest.approx([2e-3, 2e-3, 3e-3])
    file = tmp_path / "part.mpf"
    file.write_text("G710 G90 G505\nG0 X1 Y2 Z3\nG506 X1\nM30\n")
    with pytest.raises(ReadError, match="G506 after G505: how the two lie to each other"):
        read_toolpath(file)
    machine = Machine(systems={"G505": (0.1, 0.0, 0.0), "G506": (0.0, 0.0, 0.0)})
    np.testing.assert_allclose(read_toolpath(file, machine=machine).position * 1e3, [[101, 2, 3], [1, 2, 3]])
