"""Datum shifts, rotations, presets and tilted planes of Klartext, against rotations of scipy; how the tool stands."""

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

PLACE = np.array([7.0, -11.0, 13.0])
read = partial(read_text, "part.h")


def program(text: str) -> str:
    return f"BEGIN PGM A MM\nL F600\n{text}\nEND PGM A MM\n"


def last(tmp_path: Path, frames: str) -> Toolpath:
    """The pose at PLACE under frames."""
    path = read(tmp_path, program(f"{frames}\nL X+7 Y-11 Z+13 R0 FMAX"))
    return path.take([len(path) - 1])


def turned(order: str, *angles: float) -> Rotation:
    return Rotation.from_euler(order, angles, degrees=True)


def shifted(place: np.ndarray, x: float, y: float, z: float) -> np.ndarray:
    return np.asarray(place + np.array([x, y, z]))


def shift(*words: str) -> str:
    return "\n".join(["CYCL DEF 7.0 DATUM SHIFT", *(f"CYCL DEF 7.{k} {w}" for k, w in enumerate(words, 1))])


def rotation(word: str) -> str:
    return f"CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 {word}"


TILT = "PLANE SPATIAL SPA+20 SPB+30 SPC+40 TURN FMAX"
R, E, Y15 = turned("xyz", 20, 30, 40), turned("ZXZ", 20, 30, 40), turned("y", 15)
FRAMES = {
    shift("X+1", "Y+2", "Z+3"): (shifted(PLACE, 1, 2, 3), (0, 0, 1)),
    shift("X+1 Y+2 Z+3"): (shifted(PLACE, 1, 2, 3), (0, 0, 1)),
    shift("X+9", "Y+9") + "\n" + shift("X+1", "IY+2"): (shifted(PLACE, 1, 11, 0), (0, 0, 1)),
    "TRANS DATUM AXIS X+1 Y+2 Z+3": (shifted(PLACE, 1, 2, 3), (0, 0, 1)),
    "TRANS DATUM AXIS X+1\nTRANS DATUM RESET": (PLACE, (0, 0, 1)),
    rotation("ROT+40"): (turned("z", 40).apply(PLACE), (0, 0, 1)),
    rotation("ROT+10") + "\n" + rotation("IROT+30"): (turned("z", 40).apply(PLACE), (0, 0, 1)),
    rotation("ROT+40") + "\n" + rotation("ROT+0"): (PLACE, (0, 0, 1)),
    shift("X+1", "Y+2", "Z+3") + "\n" + rotation("ROT+40"): (shifted(turned("z", 40).apply(PLACE), 1, 2, 3), (0, 0, 1)),
    TILT: (R.apply(PLACE), R.apply([0, 0, 1])),
    shift("X+1", "Y+2", "Z+3") + "\n" + TILT: (shifted(R.apply(PLACE), 1, 2, 3), R.apply([0, 0, 1])),
    TILT + "\n" + shift("X+1", "Y+2", "Z+3"): (R.apply(shifted(PLACE, 1, 2, 3)), R.apply([0, 0, 1])),
    TILT + "\n" + rotation("ROT+40"): (R.apply(turned("z", 40).apply(PLACE)), R.apply([0, 0, 1])),
    "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+20 B+30 C+40\nL A+Q120 B+Q121 C+Q122 FMAX": (
        R.apply(PLACE), R.apply([0, 0, 1]),
    ),
    "PLANE EULER EULPR+20 EULNU+30 EULROT+40 STAY": (E.apply(PLACE), E.apply([0, 0, 1])),
    f"{TILT}\nPLANE RELATIV SPB+15 TURN FMAX": ((R * Y15).apply(PLACE), (R * Y15).apply([0, 0, 1])),
    "PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY+3 NZ+4 STAY": ((7, -11 * 0.8 + 13 * 0.6, 11 * 0.6 + 13 * 0.8), (0, 0.6, 0.8)),
    f"{TILT}\nPLANE RESET TURN FMAX": (PLACE, (0, 0, 1)),
    "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+20\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0\nL A+0 FMAX\n"
    "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1": (PLACE, (0, 0, 1)),
}  # fmt: skip


@pytest.mark.parametrize("frames", FRAMES)
def test_frames(tmp_path: Path, frames: str) -> None:
    place, axis = FRAMES[frames]
    path = last(tmp_path, frames)
    np.testing.assert_allclose(path.position * 1e3, [place], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.axis, [axis], rtol=0, atol=1e-14)


REFUSED = {
    f"{rotation('ROT+40')}\n{shift('X+1')}": "a datum shift while a rotation (cycle 10) is on",
    f"{shift('X+1')}\n{TILT}\n{shift('X+2')}": "a datum shift in the tilted plane, and one before it",
    f"{TILT}\n{shift('X+2')}\nPLANE RESET STAY": "another plane while a datum shift (cycle 7)",
    f"{rotation('ROT+40')}\n{TILT}": "another plane while a rotation (cycle 10)",
    "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+20\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 B+20": "without A",
    "PLANE VECTOR BX+0 BY+0 BZ+1 NX+0 NY+0 NZ+1 STAY": "a vector has no length, or both have one direction",
    "PLANE RELATIV SPA+5 SPB+5 STAY": "with one of SPA, SPB, SPC",
    f"{TILT}\nM128": "M128 or FUNCTION TCPM in a tilted plane",
    "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 A+5": "a shift of a rotary axis",
}


@pytest.mark.parametrize("frames", REFUSED)
def test_refused(tmp_path: Path, frames: str) -> None:
    with pytest.raises(ReadError) as caught:
        last(tmp_path, frames)
    assert REFUSED[frames] in str(caught.value)


def test_where_the_tool_is_after_a_plane_is_not_known(tmp_path: Path) -> None:
    """Turned by the control, it stands in the machine; with MOVE the control carries the tip along with the work."""
    text = "L X+0 Y+0 Z+50 FMAX\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 {}\nL X+5 FMAX\nL Z+6 FMAX\n{}L X+8"
    path = read(tmp_path, program(text.format("TURN FMAX", "L Y+0 FMAX\n")))
    assert path.line.tolist() == [3, 7, 8]
    assert "L X+5 FMAX, before the position is known" in [e.word for e in path.events]
    path = read(tmp_path, program(text.format("MOVE FMAX", "")))
    np.testing.assert_allclose(path.position[1] * 1e3, [0, 0, -5], rtol=0, atol=1e-12)
    with pytest.raises(ReadError, match="a cutting move, but where Y is"):
        read(tmp_path, program(text.format("MOVE ABST50 FMAX", "")))


def test_an_untilted_plane_keeps_the_place(tmp_path: Path) -> None:
    path = read(tmp_path, program("L X+0 Y+0 Z+50 FMAX\nPLANE RESET TURN FMAX\nL X+5 FMAX"))
    np.testing.assert_allclose(path.position * 1e3, [[0, 0, 50], [5, 0, 50]], rtol=0, atol=1e-12)


def test_vectors_under_m128(tmp_path: Path) -> None:
    """Any length; a vector stays until the next; LN may turn the tool where it stands."""
    text = "M128\nLN X+1 Y+0 Z+0 TX+3 TY+0 TZ+4 FMAX\nL X+2\nLN TX+0 TY+1 TZ+0\n{}L X+0 Y+0 Z+9 FMAX"
    path = read(tmp_path, program(text.format("LN TX+0 TY+0 TZ+1\nM129\n")))
    expected = [[0.6, 0, 0.8], [0.6, 0, 0.8], [0, 1, 0], [0, 0, 1], [0, 0, 1]]
    np.testing.assert_allclose(path.axis, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.position[:, 0] * 1e3, [1, 2, 2, 2, 0])
    with pytest.raises(ReadError, match="the tool stands tilted and tool centre point control is off"):
        read(tmp_path, program(text.format("M129\n")))


@pytest.mark.parametrize(
    ("on", "off"),
    [
        ("M128 F1000", "M129"),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR", "FUNCTION RESET TCPM"),
        ("FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS REFPNT TIP-TIP", "FUNCTION RESET TCPM"),
        ("L X+0 Y+0 Z+0 FMAX M128", "L M129"),
    ],
)
def test_spellings_of_tool_centre_point_control(tmp_path: Path, on: str, off: str) -> None:
    path = read(tmp_path, program(f"{on}\nLN X+0 Y+0 Z+0 TX+3 TY+0 TZ+4 FMAX\nLN TX+0 TY+0 TZ+1\n{off}\nL X+1"))
    np.testing.assert_allclose(path.axis[-3], [0.6, 0, 0.8], rtol=0, atol=1e-15)


def test_spatial_angles(tmp_path: Path) -> None:
    text = "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+0 Y+0 Z+0 A+20 B+30 C+40 FMAX\nL X+1 B+0"
    path = read(tmp_path, program(text))
    expected = [R.apply([0, 0, 1]), turned("xyz", 20, 0, 40).apply([0, 0, 1])]
    np.testing.assert_allclose(path.axis, expected, rtol=0, atol=1e-14)


def test_presets(tmp_path: Path) -> None:
    """The file counts from its preset; a second one only where the cell says how the two lie."""
    one = "CYCL DEF 247 DATUM SETTING ~\n Q339=+1 ;DATUM NUMBER\nL X+1 Y+2 Z+3 FMAX\n"
    assert read(tmp_path, program(one)).position[0] * 1e3 == pytest.approx([1, 2, 3])
    file = tmp_path / "part.h"
    file.write_text(program(one + "CYCL DEF 247 Q339=+2\nL X+1 FMAX"))
    with pytest.raises(ReadError, match="preset 2 after 1: how the two lie to each other"):
        read_toolpath(file)
    machine = Machine(systems={"1": (0.1, 0.0, 0.0), "2": (0.0, 0.0, 0.0)})
    np.testing.assert_allclose(read_toolpath(file, machine=machine).position * 1e3, [[101, 2, 3], [1, 2, 3]])
