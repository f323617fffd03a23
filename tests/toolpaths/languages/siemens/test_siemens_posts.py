"""Programs as posts of CAM systems write them: 2.5 D with cycles, 3 + 2 axes with CYCLE800, five axes with TRAORI."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import CUT

read = partial(read_text, "part.mpf")
PLATE = """%_N_PLATE_MPF
; PLATE 42, OP 10
N10 G90 G94
N11 G71
N12 G64
N13 G17
N14 WORKPIECE(,,,"BOX",112,0,-20,-80,0,0,120,80)
N15 ; FACE
N16 T="FACE_50" D1
N17 M6
N18 MSG("FACE")
N19 S3200 M3
N20 G54
N21 M8
N22 G0 X-30 Y20
N23 G0 Z15
N24 G1 Z0 F900
N25 X150 F1200
N26 G2 X150 Y60 I0 J20
N27 G1 X-30
N28 G0 Z15
N29 M9
N30 ; DRILL
N31 T="DRILL_8.5" D1
N32 M6
N33 S2400 M3
N34 M8
N35 G0 X20 Y20
N36 G0 Z15
N37 F250
N38 MCALL CYCLE83(15, 0, 2, -24, , , 8, 0, 0, 0, 1, 0, , , , , )
N39 X20 Y20
N40 X100 Y20
N41 MCALL
N42 M9
N43 SUPA G0 Z0 D0
N44 SUPA X0 Y0
N45 M30
"""
TILTED = """N1 G90 G17 G40 G710 G94
N2 CYCLE800()
N3 T1 D1
N4 M6
N5 S8000 M3
N6 G54
N7 CYCLE832(0.02,1,1)
N8 SUPA G0 Z0 D0
N9 CYCLE800(1,"TC1",100000,27,0,0,0,0,30,0,0,0,0,-1,100,1)
N10 D1
N11 G0 X10 Y20
N12 G0 Z50
N13 G1 Z-2 F500
N14 X40
N15 G3 X50 Y30 CR=10
N16 G0 Z50
N17 CYCLE800()
N18 SUPA G0 Z0 D0
N19 TRAORI
N20 D1
N21 ORIWKS ORIVECT
N22 FGROUP(X,Y,Z)
N23 G54
N24 G0 X0 Y0 Z80 A3=0 B3=0 C3=1
N25 G1 Z1 F1500 A3=0.1 B3=0.2 C3=0.9746794
N26 X5 Y1 Z1.5 A3=0.11 B3=0.2 C3=0.973601
N27 G0 Z80
N28 TRAFOOF
N29 CYCLE800()
N30 SUPA G0 Z0 D0
N31 CYCLE832()
N32 M30
"""


def test_a_plate(tmp_path: Path) -> None:
    path = read(tmp_path, PLATE)
    cuts = path.take(np.flatnonzero((path.kind == CUT) & (path.row % 1 == 0)))
    assert cuts.line.tolist() == [17, 18, 19, 20, *[32] * 5, *[33] * 5]
    expected = [[-30, 20, 0], [150, 20, 0], [150, 60, 0], [-30, 60, 0]]
    np.testing.assert_allclose(cuts.position[:4] * 1e3, expected, atol=1e-9)
    np.testing.assert_allclose(cuts.position[4:9, 2] * 1e3, [-8, -7, -16, -15, -24], atol=1e-9)
    assert sorted(set(path.tool.tolist())) == [1, 2] and path.tool[-1] == 2
    assert np.unique(np.round(cuts.feed * 6e4, 9)).tolist() == [250, 900, 1200]
    said = [e.word for e in path.events]
    assert 'MSG("FACE")' in " ".join(said) and "SUPA X0 Y0" in " ".join(said) and said[-1] == "M30"


def test_three_and_two_axes_then_five(tmp_path: Path) -> None:
    path = read(tmp_path, TILTED)
    half = np.radians(30)
    tilted = np.array([np.sin(half), 0.0, np.cos(half)])
    in_plane = path.take(np.flatnonzero(np.isin(path.line, [12, 13, 14, 15, 16])))
    np.testing.assert_allclose(in_plane.axis, np.tile(tilted, (len(in_plane), 1)), atol=1e-12)
    start = in_plane.position[1] * 1e3
    np.testing.assert_allclose(start, [10 * np.cos(half) - 2 * np.sin(half), 20, -10 * np.sin(half) - 2 * np.cos(half)])
    five = path.take(np.flatnonzero(path.line == 26))
    np.testing.assert_allclose(five.axis[-1], np.array([0.11, 0.2, 0.973601]) / np.linalg.norm([0.11, 0.2, 0.973601]))
    assert sum(e.word.startswith("SUPA") or "SUPA" in e.word for e in path.events) == 3


def test_a_setting_that_this_reader_does_not_know_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="NEWWORD: this reader does not know the word"):
        read(tmp_path, TILTED.replace("ORIVECT", "NEWWORD"))
