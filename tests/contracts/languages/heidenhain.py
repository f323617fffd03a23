"""HEIDENHAIN Klartext in the contract suites."""

from __future__ import annotations

from tests.contracts.languages.gcode import MACHINE
from tests.contracts.sample import ReadSample, Sample

HEAD = "BEGIN PGM A MM\nTOOL CALL 1 Z S5000\nL X+0 Y+0 Z+0 R0 FMAX\nL F600\n"
_DRILL = "CYCL DEF 200 Q200=2 Q201=-9 Q206=150 Q202=3 Q210=0 Q203=+0 Q204=9 Q211=0"
#: Blocks behind HEAD: line and words of the refusal.
REFUSED: dict[str, tuple[int, str]] = {
    "L X+5 RL": (5, "RL: cutter compensation"),
    "L X+5 RR F100": (5, "RR: cutter compensation"),
    "APPR LCT X+5 Y+5 R2 RL": (5, "APPR: "),
    "DEP LCT X+5 R2": (5, "DEP: "),
    "FL X+5": (5, "FL: free contour"),
    "FPOL X+5 Y+5": (5, "FPOL: free contour"),
    "TCH PROBE 1.0 X": (5, "TCH: probing"),
    "L X+5 X+6": (5, "X stands twice"),
    "L X+5 IX+6": (5, "X and IX in one block"),
    "L X": (5, "X without a value"),
    "L X+5 E1": (5, "no word of Klartext"),
    "L U+5": (5, "U: this block does not have it"),
    "L X+5 FU0.1": (5, "FU: a feed by the turn"),
    "L X+5 F AUTO": (5, "TOOL CALL gives no feed"),
    "L X+5 F0": (5, "it is F0"),
    "L X+5 F": (5, "F without a number"),
    "L A+30": (5, "the machine is not known"),
    "L X+5 A+30": (5, "A30: a rotary axis"),
    "L A+30 FMAX\nL X+5": (6, "the rotary axes stand at A30"),
    "L X+2000000": (5, "beyond 1000 m"),
    "L X+99999999999": (5, "beyond 1e"),
    "L Z+0 FMAX M91\nL X+5": (6, "a cutting move, but where Z is"),
    "L Z+0 F100 M91": (5, "a feed move to a place of the machine"),
    "L IZ+5 FMAX M91\nL IZ+5 FMAX": (6, "where Z is, is not known"),
    "C X+5 DR+": (5, "no CC before it"),
    "CC X+5 Y+0\nC X+10 Y+0": (6, "without its sense DR"),
    "CC X+4 Y+0\nC X+10 Y+0 DR+": (6, "radius is 4 mm at the start, 6 mm at the end"),
    "CC X+5 Y+0\nC X+10 Y+0 DR+ FMAX": (6, "at rapid (FMAX)"),
    "CR X+5 R+1 DR+": (5, "too small"),
    "CR X+5 DR+": (5, "without a radius"),
    "CR R+5 DR+": (5, "ends where it starts"),
    "CT X+5": (5, "no move in the plane"),
    "CC X+5 Y+0\nCP IPA+360 DR-": (6, "both signs have to agree"),
    "CC X+5 Y+0\nCP PR+5 DR-": (6, "PA or IPA"),
    "LP PR+5 PA+30": (5, "no CC before them"),
    "RND R1": (5, "no move ends in a corner"),
    "L X+5\nRND R1\nL Z+5 FMAX": (7, "the rounding of line 6 stands beside a move out of the plane"),
    "L X+5\nRND R1\nM30": (7, "has no move behind it"),
    "LN X+5 TX+0 TY+0 TZ+1": (5, "without M128"),
    "M128\nLN X+5 TX+0 TY+0 TZ+0": (6, "no length"),
    "M128\nLN X+5 TX+1 TZ+1\nM129\nL X+0": (8, "the tool stands tilted"),
    "PLANE SPATIAL SPA+0 SPB+30 STAY": (5, "without SPC"),
    "PLANE SPATIAL SPA+0 SPB+30 SPC+0": (5, "without TURN, MOVE or STAY"),
    "PLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX\nL X+5": (6, "a cutting move, but where Y, Z is"),
    "PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY\nL X+5 Y+0 Z+9 FMAX\nL Z+0": (7, "nothing has turned the rotary axes to it"),
    "PLANE PROJECTED PROPR+0 PROMIN+0 ROT+0 STAY": (5, "PLANE PROJECTED"),
    "PLANE AXIAL B+30 STAY": (5, "PLANE AXIAL"),
    "M128\nPLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY": (6, "PLANE under M128"),
    "PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY\nPLANE RESET STAY\nL X+0 Y+0 Z+9 FMAX": (7, "as in the tilted plane before"),
    "CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X": (6, "it mirrors"),
    "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.9": (6, "it scales"),
    "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 #5": (6, "a datum of a table"),
    "CYCL DEF 207 Q200=2": (5, "tapping"),
    "CYCL DEF 251 Q215=0": (5, "a cycle that this reader does not know"),
    "CYCL DEF 200 Q200=2": (5, "CYCL DEF 200 without Q201"),
    _DRILL.replace("Q201=-9", "Q201=9"): (5, "a depth Q201 of 9"),
    _DRILL.replace("Q202=3", "Q202=0"): (5, "an infeed Q202 of 0"),
    "CYCL CALL": (5, "no drilling cycle is defined"),
    "L X+5 FMAX M99": (5, "no drilling cycle is defined"),
    _DRILL + "\nCYCL CALL PAT FMAX": (6, "a pattern"),
    "CYCL DEF 247 Q339=1\nCYCL DEF 247 Q339=2": (5, "preset 1 after"),
    "CALL LBL 7": (5, "there is no such label"),
    "CALL PGM OTHER": (5, "there is no OTHER.H"),
    "SEL PGM \"A\"": (5, "SEL: "),
    "L X+Q7": (5, "Q7, which has no value in the file"),
    "FN 18: SYSREAD Q7 = ID210 NR4\nL X+Q7": (6, "Q7, which FN 18"),
    "FN 17: SYSWRITE ID210 = 1": (5, "it writes into the control"),
    "FN 9: IF +Q7 EQU +1 GOTO LBL 1": (5, "known only at run time"),
    "FN 9: IF +0 EQU +0 GOTO LBL 9": (5, "there is no such label"),
    "LBL 3\nL IX+1\nFN 9: IF +0 EQU +0 GOTO LBL 3": (7, "a loop that never ends"),
    "Q1 = 1 / 0": (5, "has no value"),
    "/L X+5": (5, "whether the block counts"),
    "/M30\nL X+5": (5, "whether the block counts"),
    "TOOL CALL 2 X": (5, "the tool axis X"),
    "TOOL CALL 2 Z DL+0.5": (5, "DL+0.5"),
    "TOOL CALL \"A\" Z": (5, "tool"),
    "M114": (5, "M114: "),
    "M144": (5, "M144: "),
    "XYZ 5": (5, "this reader does not know the block"),
    "BEGIN PGM B MM": (5, "a second BEGIN PGM"),
    "G1 X5": (5, "this reader does not know the block"),
}
#: Whole programs.
PROGRAMS: tuple[tuple[str, int | None, str], ...] = (
    ("L X+1 FMAX\nEND PGM A MM\n", 1, "BEGIN PGM is expected"),
    ("BEGIN PGM A\nL X+1 FMAX\nEND PGM A\n", 1, "without MM or INCH"),
    ("BEGIN PGM A MM\nL X+1 FMAX\nM30\n", None, "END PGM with its unit is missing"),
    ("BEGIN PGM A MM\nL X+1 Y+1 FMAX\nL X+1 F5\nEND PGM A MM\n", 3, "a cutting move, but where Z is"),
    ("BEGIN PGM A MM\nL X+1 Y+1 Z+1\nEND PGM A MM\n", 2, "needs a feed"),
    ("BEGIN PGM A MM\nL X+1 Y+1 Z+1 FMAX M30\nL X+5 F9\nEND PGM A MM\n", 3, "moves behind the end"),
    ("#ifndef A_H\n#define A_H\nint a;\n#endif\n", 1, "BEGIN PGM is expected"),
)
WORDS = [
    "L", "LN", "LP", "C", "CC", "CP", "CR", "CT", "CTP", "RND", "CHF", "X+1", "X-2.5", "Y+3", "Z", "Z+0", "Z-1",
    "IX+1", "IZ-1", "R0", "RL", "RR", "R+9", "R-2", "DR+", "DR-", "F100", "F0", "FMAX", "F", "MAX", "AUTO", "M3",
    "M8", "M30", "M91", "M99", "M89", "M128", "M129", "M140", "MB", "M126", "M136", "M103", "PR+5", "PA+30",
    "IPA+360", "IPA-90", "TX+0.1", "TY+0", "TZ+1", "NX+0", "NY+0", "NZ+1", "A+30", "B-10", "C+90", "A+Q120", "Q1",
    "Q2=Q1*2", "Q1=5", "FN", "0:", "Q1=+5", "9:", "IF", "+Q1", "EQU", "+5", "GOTO", "LBL", "1", "0", "CALL", "REP",
    "2", "PGM", "TOOL", "Z", "S900", "DR+0.1", "PLANE", "SPATIAL", "SPA+0", "SPB+30", "SPC+0", "STAY", "TURN",
    "MOVE", "ABST50", "RESET", "VECTOR", "CYCL", "DEF", "200", "Q200=2", "Q201=-9", "Q206=150", "Q202=3", "Q203=+0",
    "Q204=9", "7.0", "7.1", "10.1", "ROT+30", "19.1", "247", "Q339=1", "FUNCTION", "TCPM", "AXIS", "SPAT", "BEGIN",
    "END", "MM", "INCH", "BLK", "FORM", "STOP", ";", "*", "~", "/", "%", '"', "(", ")", "99999999999", "é", ",",
    "SIN",
]  # fmt: skip
WHOLE = """0 BEGIN PGM PART MM
1 BLK FORM 0.1 Z X+0 Y+0 Z-20
2 BLK FORM 0.2 X+100 Y+100 Z+0
3 * - Tool
4 TOOL CALL 1 Z S5000 F500 ; mill
5 L X+0 Y+0 R0 FMAX M3
6 L Z+10 R0 FMAX
7 L Z-1 F200 M8
8 L X+10 F AUTO
9 RND R2
10 L Y+20
11 CHF 1
12 L X+0
13 CC X+0 Y+10
14 C X+0 Y+0 DR+
15 CP IPA-360 IZ-1 DR-
16 CR X+10 Y+10 R+10 DR-
17 CT X+20 Y+5
18 LP PR+30 PA+30
19 L Z+50 FMAX
20 CYCL DEF 203 DRILLING ~
  Q200=2 ;CLEARANCE ~
  Q201=-15 ;DEPTH ~
  Q206=150 Q202=5 Q210=0 Q203=+0 Q204=20 Q212=1 Q213=2 Q205=3 Q211=0 Q208=999 Q256=0.2
21 L X+30 Y+30 R0 FMAX M99
22 LBL 1
23 L IX+10 FMAX M99
24 CALL LBL 1 REP 2
25 FN 0: Q1 = +5
26 Q2 = Q1 * 2 + SIN 30
27 FN 11: IF +Q1 GT +3 GOTO LBL 2
28 L X+999 F5
29 LBL 2
30 CYCL DEF 7.0 DATUM SHIFT
31 CYCL DEF 7.1 X+Q2
32 CYCL DEF 10.0 ROTATION
33 CYCL DEF 10.1 ROT+30
34 CALL LBL 5
35 CYCL DEF 10.0 ROTATION
36 CYCL DEF 10.1 ROT+0
37 PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY
38 L X+0 Y+0 Z+50 FMAX
39 CALL LBL 5
40 PLANE RESET TURN FMAX
41 L X+0 Y+0 Z+90 FMAX
42 M128
43 LN X+1 Y+1 Z+20 NX+0 NY+0 NZ+1 TX+0.1 TY+0 TZ+0.9 F500
44 M129
45 L Z+0 FMAX M91
46 M30
47 LBL 5
48 L X+5 Y+5 R0 FMAX
49 L Z-1 F200
50 L Z+50 FMAX
51 LBL 0
52 END PGM PART MM
"""

SAMPLE = Sample(
    read=ReadSample(
        text="BEGIN PGM A MM\nL X+0 Y+0 Z+5 R0 FMAX\nL X+10 Z+0 F600\nL Y-4\nL Z+5 FMAX\nEND PGM A MM\n",
        pieces=" ".join(WORDS),
        machine=MACHINE,
        whole=WHOLE,
        twice="wo programs in one file",
        refused=(*((HEAD + text + "\nEND PGM A MM\n", *expected) for text, expected in REFUSED.items()), *PROGRAMS),
        spelled=(
            (
                "%comment\n0  begin pgm part MM\n1  BLK FORM 0.1 Z X-50,5 Y-50 Z-20\n2  BLK FORM 0.2 X+50 Y+50 Z+0\n"
                "3  ;Fusion\n4  * - mill\n5  TOOL CALL 5 Z S1000 DL+0 DR+0\n6  L X+0 Y+0 Z+5 R0 FMAX M13\n"
                "7  L X1 Y+2 Z+3,0 R F99 M90\n8  STOP M30\n9  END PGM part MM\n",
                (1, 2, 3),
            ),
        ),
        huge=(
            "BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\nCC X+900000 Y+0\n" + "CP IPA+36000 DR+ F9\n" * 30 + "END PGM A MM\n",
            1e-5,
        ),
    ),
    examples=7,
)
