"""G-code in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from toolpaths.machine import Machine, RotaryAxis
from toolpaths.writing.marker import MARKER

HEAD = "G21 G90 G17\nG0 X0 Y0 Z0\nF600\n"
#: Statement behind HEAD: line and words of the refusal.
REFUSED: dict[str, tuple[int, str]] = {
    "G1 X1 A90": (4, "A90"),
    "G41 D1 X5": (4, "G41"),
    "G1 X1 E0.5": (4, "3D printer"),
    "M104 S200": (4, "3D printers"),
    "G92": (4, "G92 without X, Y or Z"),
    "G92 X1 A3": (4, "G92 with A"),
    "G52 X1\nG92 X0": (5, "G92 on top of G52"),
    "G28 G91 Z0\nG90\nG92 Z5": (6, "where Z is, is not known"),
    "G28 G91 Z0\nG90\nG1 X5": (6, "a cutting move, but where Z is"),
    "G55": (4, "G55 after G54"),
    "G54.1 P2": (4, "G54.1 P2 after G54"),
    "G93\nG1 X1": (5, "a feed in every block under G93"),
    "G95\nG1 X1 F.1": (5, "needs an S above 0"),
    "G95\nG1 X1 S500": (5, "needs a feed, none is given"),
    "G0 G81 X1 Z-1 R1": (4, "two words for motion"),
    "G94 G95": (4, "two words for feed mode"),
    "G81 X1 Z-3": (4, "needs R"),
    "G81 X1 R2": (4, "needs Z"),
    "G81 X1 Z3 R2": (4, "R lies below the bottom"),
    "G83 X1 Z-3 R2": (4, "needs Q"),
    "G73 X1 Z-3 R2 Q0": (4, "Q0 mm"),
    "G83 X1 Z-300 R2 Q0.01": (4, "Q0.01 mm"),
    "G81 X1 Z-3 R2 L0": (4, "0 repetitions"),
    "G81 X1 Z-3 R2 L99999": (4, "moves, at most"),
    "G81 X1 Z-3 R2\nR3": (5, "no X, Y or Z"),
    "G81 X1 Z-3 R2\nG82 X3": (5, "needs R"),
    "G81 X1 Z-3 R2\nG18 X3": (5, "the plane changes"),
    "G81 X1 Z-3 R2\nG91 X3": (5, "needs R"),
    "G93 G81 X1 Z-3 R2 F1": (4, "canned cycle in G93"),
    "G84 X1 Z-3 R2": (4, "a canned cycle other than"),
    "L3": (4, "L3: read only with canned cycles"),
    "G90.1 G2 X5 I2.5": (4, "without J: with G90.1 both"),
    "G43.4 H1\nG1 X1 I0 J0 K0": (5, "no length"),
    "G43.4 H1\nG1 X1 I1 J0 K1\nG49\nX5": (7, "tilted and G43.4 is off"),
    "G43.4 H1\nG1 X1 I1 J0 K1\nG81 Z-3 R2": (6, "tool vectors"),
    "G5.1 X1 I2": (4, "spline"),
    "G5.1 Q1 X3": (4, "spline"),
    "G68.2 X0 Y0 Z0": (4, "tilted work plane"),
    "G10 L2 P1 X0": (4, "writes offsets"),
    "G4 P1 X5": (4, "dwell into a block of its own"),
    "O100 sub": (4, "O-word"),
    "o<drill> call [1]": (4, "O-word"),
    "IF [#1 EQ 2] GOTO 10": (4, "macro statement (IF)"),
    "#1=5": (4, "variable"),
    "G1 X-#1": (4, "variable"),
    "G1 C90": (4, "rotary axis"),
    "G17.1": (4, "G17.1"),
    "G65 P100": (4, "macro"),
    "M98 P100": (4, "subprogram"),
    "M77": (4, "M77"),
    "G1 X#101": (4, "variable"),
    "G1 X[1+2]": (4, "expression"),
    "/G1 X1": (4, "block delete"),
    "G1 X1 X2": (4, "X stands twice"),
    "G0 G1 X1": (4, "two words for motion"),
    "G1 X1.2.3": (4, "'.'"),
    "G1 X": (4, "'X'"),
    "G1 X1 (never closed": (4, "not closed"),
    "G1 X1 I2": (4, "G2 and G3"),
    "F0\nG1 X1": (5, "needs a feed, it is F0"),
    "F-3\nG1 X1": (5, "F-3"),
    "G2 X5": (4, "without centre"),
    "G2 X5 R1": (4, "too small"),
    "G2 R5": (4, "ends where it starts"),
    "G2 X5 R5 I2": (4, "both R and I"),
    "G2 X5 K2": (4, "K is no centre word"),
    "G18 G2 X5 J2": (4, "J is no centre word"),
    "G2 X10 I4": (4, "radius is 4 mm at the start, 6 mm at the end"),
    "G2 I0": (4, "radius zero"),
    "G80\nX5": (5, "no G0, G1, G2 or G3"),
    "G28 X1": (4, "G28 by way of a point"),
    "G53 G1 X1": (4, "rapid retract"),
    "G43 Z5\nH1": (5, "H1 without G43"),
    "G2 X5 I2.5 P1.5": (4, "P1.5"),
    "G2 X5 I2.5 P0": (4, "P0"),
    "G1 X5 P2": (4, "P2"),
    "T1.5 M6": (4, "T1.5"),
    "G20\nG1 X1": (5, "needs a feed"),
    "O2\nG1 X1": (4, "second program"),
    "M30\nG1 X1": (5, "after the end"),
    "%\nG1 X1": (4, "middle of the program"),
    "G1 X2000000": (4, "beyond 1000 m"),
    "G1 X1 I99999999999": (4, "beyond 1e"),
    "T9999999999999999999999": (4, "beyond 1e"),
    "G1 X1 V2": (4, "V2"),
    "G1 X1 $": (4, "not a G-code word"),
}
#: Whole programs.
HEAD_AND_END = (
    ("G0 X1 Y1 Z1\n", 1, "no units"),
    ("G21\nX1 Y1 Z1\n", 2, "no G0"),
    ("G21\nG91 G0 X1 Y1 Z1\n", 2, "where X starts is not known"),
    ("G21\nG0 X1 Y1\nG2 X3 I1\n", 3, "needs a feed"),
    ("G21\nG0 X1 Y1\nG2 X3 I1 F5\n", 3, "not known (Z)"),
    ("%\nG21\nG0 X1 Y1 Z1\nX2\n", 5, "does not end with one"),
    ("G21\nM3 S100\nG0 X1 Y1 Z1\nX2\n", 5, "spindle turns"),
    ("G21\nG0 X1 Y1 Z1\nX2", 3, "without a line end"),
    ("UNITS/MM\nGOTO/0,0,5\nFINI\n", 1, "APT/CL, name the file .apt or .cls"),
    ("G21 G90\nCYCLE81(5,0,1,-3)\nM30\n", 2, "'CYCLE' is no word of G-code"),
    ("G0 X0 Y0 Z5\nG1 Z-1 F100\nM30\n", 1, "no units"),
    ("G17 G90 G71\nG0 X0 Y0 Z5\nM30\n", 1, "write G21 for mm"),
    ("G21 G90\nG0 X0 Y0 Z5\nG5 X1 Y1 P2\nM30\n", 3, "spline"),
    ("G21 G90\nG0 X0 Y0 Z5\nG50.1 X0\nM30\n", 3, "with coordinates"),
)
MACHINE = Machine(
    "head-table", (RotaryAxis("B", (0.0, 1.0, 0.0)), RotaryAxis("C", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))), 0.2
)
WORDS = [
    "G0", "G1", "G2", "G3", "G4", "G17", "G18", "G19", "G20", "G21", "G28", "G43", "G43.4", "G49", "G52", "G53",
    "G54", "G55", "G73", "G80", "G81", "G82", "G83", "G85", "G90", "G90.1", "G91", "G92", "G92.1", "G92.2", "G92.3",
    "G93", "G94", "G95", "G98", "G99", "X1", "X-2.5", "Y3", "Z", "Z0", "Z-1", "I3", "J0", "J1", "K1", "R9", "R-2",
    "Q1", "P2", "L3", "F100", "F0", "S900", "T1", "M3", "M6", "M30", "H1", "%", "(", ")", ";", "#1", "E1", "O1",
    "N5", "A30", "B-10", "B400", "C90", "1", ".", "-", "+", "1e5", "99999999999", "X999999", "é", "[", "IF",
]  # fmt: skip

#: Spellings of real posts.
SPELLED = (
    (
        "%\n:1001 (ISO)\nG21 G90 G15 G50 G50.1 G67 G13.1\nG0 X0 Y0 Z5\nG05 P10000\nG08 P1\nG187 P3\nM19\nM88\n"
        "G09 G01 X1 Y2 Z3 F99\nG5 P0\nG187\nM89\nM30\n%\n",
        (1, 2, 3),
    ),
    ("%\nO2001\nG21 G90\nG0 X0 Y0 Z5\nG1 X1 Y2 Z3 F99\nM99\n%\n", (1, 2, 3)),
)

SAMPLE = Sample(
    read=ReadSample(
        text="G21 G90\nG0 X0 Y0 Z5\nG1 X10 Z0 F600\nY-4\nG0 Z5\nM30\n",
        pieces=" ".join(WORDS),
        end_word=False,
        printed={"slicer": (2, "3D printers"), "extruder": (5, "3D printer"), "firmware": (3, "3D printers")},
        machine=MACHINE,
        refused=(*((HEAD + text + "\nM30\n", *expected) for text, expected in REFUSED.items()), *HEAD_AND_END),
        spelled=SPELLED,
        huge=("G21 G90 G17\nG0 X0 Y0 Z5\n" + "G2 X0 Y0 I900000 P100 F100\n" * 30 + "M30\n", 1e-5),
    ),
    written=WrittenSample(split=False, turns=False, start=0),
    filtered=FilterSample(
        source="%\nO1001 (PART)\nG21 G90 G17\nG0 X0 Y0 Z5\nF600\nG1 X10. Z-1\nG2 X20 I5 (half)\nG91 G1 X.5\nG90\n"
        "G98 G81 X3 R2 Z-1\nG80\nG0 Z5\nM30\n%\n",
        marker=(3, (f"({MARKER})",)),
        lines=(3, 7),
        turns=False,
        position=6e-7,
        arc=("G21 G90 G17\nG0 X0 Y0 Z5\nF600\nG1 X0 Z-1\nG2 X10 Y0 I5 J0 F900\nG1 X30\nG0 Z5\nM30\n", "G2 "),
        arc_told=("an arc became lines",),
        arcs_grow=False,
    ),
    examples=7,
    own_blocks=4,
)
