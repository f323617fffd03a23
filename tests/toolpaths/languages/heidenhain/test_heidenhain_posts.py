"""Programs as posts of CAM systems write them: 2.5 D with cycles, 3 + 2 axes with PLANE, five axes with M128."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from tests.oracles.read_text import read_text
from toolpaths.toolpath import CUT

read = partial(read_text, "part.h")
PLATE = """0  BEGIN PGM PLATE MM
1  BLK FORM 0.1 Z X-60 Y-40 Z-20
2  BLK FORM 0.2 X+60 Y+40 Z+0
3  CYCL DEF 247 DATUM SETTING ~
    Q339=+1 ;DATUM NUMBER
4  CYCL DEF 32.0 TOLERANCE
5  CYCL DEF 32.1 T0.02
6  TOOL CALL  Z ;SET TOOL AXIS
7  L M140 MB MAX
8  * - Face
9  TOOL CALL 3 Z S3200 F900 ; D50
10 M3
11 L  X-90  Y-20 R0 FMAX
12 L  Z+15 R0 FMAX
13 M8
14 FN 0: Q50 =+1200 ; Cutting
15 FN 0: Q53 =+900 ; Entry
16 L  Z+0 FQ53
17 L  X+90 FQ50
18 CC X+90 Y+0
19 C  X+90  Y+20 DR+
20 L  X-90
21 L  Z+15 FMAX
22 * - Drill
23 TOOL CALL 8 Z S2400
24 L  X+30  Y+20 R0 FMAX M13
25 L  Z+15 R0 FMAX
26 CYCL DEF 200 DRILLING ~
    Q200=+2 ;SET-UP CLEARANCE ~
    Q201=-24 ;DEPTH ~
    Q206=+250 ;FEED RATE FOR PLUNGING ~
    Q202=+8 ;INFEED DEPTH ~
    Q210=+0 ;DWELL AT TOP ~
    Q203=+0 ;SURFACE COORDINATE ~
    Q204=+15 ;2ND SET-UP CLEARANCE ~
    Q211=+0 ;DWELL AT BOTTOM ~
    Q395=+0 ;DEPTH REFERENCE
27 CYCL CALL
28 L  X-30  Y+20 FMAX M99
29 M9
30 L M140 MB MAX
31 M5
32 TOOL CALL 0 Z
33 M30
34 END PGM PLATE MM
"""
TILTED = """0 BEGIN PGM TILTED MM
1 TOOL CALL "BALL 6" Z S12000 F1500
2 M126
3 L Z-1 R0 FMAX M91
4 PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN MB MAX FMAX SEQ- TABLE ROT
5 L X+10 Y+20 R0 FMAX M3
6 L Z+50 R0 FMAX
7 L Z-2 F500
8 L X+40
9 CR X+50 Y+30 R+10 DR+
10 L Z+50 FMAX
11 PLANE RESET TURN FMAX
12 L Z-1 R0 FMAX M91
13 FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR
14 L X+0 Y+0 Z+80 FMAX
15 LN X+0 Y+0 Z+1 NX+0 NY+0 NZ+1 TX+0.1 TY+0.2 TZ+0.9746794 F1500
16 LN X+5 Y+1 Z+1.5 NX+0 NY+0 NZ+1 TX+0.11 TY+0.2 TZ+0.973601
17 L Z+80 FMAX
18 LN TX+0 TY+0 TZ+1 FMAX
19 FUNCTION RESET TCPM
20 L Z-1 R0 FMAX M91
21 M127
22 M30
23 END PGM TILTED MM
"""


def test_a_plate(tmp_path: Path) -> None:
    path = read(tmp_path, PLATE)
    cuts = path.take(np.flatnonzero((path.kind == CUT) & (path.row % 1 == 0)))
    assert cuts.line.tolist() == [18, 19, 21, 22, *[38] * 3, *[39] * 3]
    expected = [[-90, -20, 0], [90, -20, 0], [90, 20, 0], [-90, 20, 0]]
    np.testing.assert_allclose(cuts.position[:4] * 1e3, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(cuts.position[4:, 2] * 1e3, [-8, -16, -24] * 2, rtol=0, atol=1e-9)
    assert sorted(set(path.tool.tolist())) == [3, 8]
    assert np.unique(np.round(cuts.feed * 6e4, 9)).tolist() == [250, 900, 1200]


def test_three_and_two_axes_then_five(tmp_path: Path) -> None:
    path = read(tmp_path, TILTED)
    half = np.radians(30)
    tilted = np.array([np.sin(half), 0.0, np.cos(half)])
    in_plane = path.take(np.flatnonzero(np.isin(path.line, [7, 8, 9, 10, 11])))
    np.testing.assert_allclose(in_plane.axis, np.tile(tilted, (len(in_plane), 1)), atol=1e-12)
    start = in_plane.position[1] * 1e3
    np.testing.assert_allclose(start, [10 * np.cos(half) - 2 * np.sin(half), 20, -10 * np.sin(half) - 2 * np.cos(half)])
    five = path.take(np.flatnonzero(path.line == 17))
    np.testing.assert_allclose(five.axis[-1], np.array([0.11, 0.2, 0.973601]) / np.linalg.norm([0.11, 0.2, 0.973601]))
    assert path.axis[-1].tolist() == [0, 0, 1] and sum("M91" in e.word for e in path.events) == 3
