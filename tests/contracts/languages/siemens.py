"""SINUMERIK 840D in the contract suites."""

from __future__ import annotations

from tests.contracts.languages.gcode import MACHINE
from tests.contracts.sample import ReadSample, Sample

HEAD = "G710 G90 G17\nG0 X0 Y0 Z0\nF600\n"
#: Lines behind HEAD: line and words of the refusal.
REFUSED: dict[str, tuple[int, str]] = {
    "G1 X1 A90": (4, "A90: a rotary axis"),
    "G41 X5": (4, "G41: cutter compensation"),
    "G33 Z-5 K1": (4, "G33: threading"),
    "G70": (4, "G70: lengths in inch"),
    "G700": (4, "the unit changes"),
    "G1 X1 E0.5": (4, "E0.5: this reader does not know the address"),
    "G0 X1 L=AC(2)": (4, "G0 X1 L=AC(2): a subprogram that is not in the file"),
    "X2=50": (4, "X2=...: no address that is read"),
    "G1 X1=50": (4, "X1=50: this block has no use for it"),
    "X1=50": (4, "X1=50: this block has no use for it"),
    "TURN=2": (4, "TURN=2: this block has no use for it"),
    "G0 G1 X1": (4, "G0 G1: two words of one group"),
    "OVR=50": (4, "OVR: it scales the feed"),
    "G1 U5": (4, "U5: this reader does not know the address"),
    "G5": (4, "G5: an oblique plunge"),
    "G999": (4, "G999: this reader does not know it"),
    "G55\nG54": (4, "G55 after G54"),
    "SUPA G1 Z5": (4, "a feed move to a place of the machine"),
    "SUPA G0 Z0\nG1 X5": (5, "a cutting move, but where Z is"),
    "SUPA G0 Z0\nG91 G0 Z5": (5, "Z counts from where the tool is, and that is not known"),
    "G75 Z1=0\nG2 X5 CR=5": (5, "an arc, but where it starts is not known"),
    "G93\nG1 X1": (5, "a feed F is needed in every block under G93"),
    "G95\nG1 X1": (5, "a cutting move needs a feed, none is given"),
    "G95\nG1 X1 F0.1": (5, "no speed S above 0"),
    "F0\nG1 X1": (5, "it is F0"),
    "G1 X1 X2": (4, "the address X stands twice"),
    "G1 X1.2.3": (4, "is not expected here"),
    "G1 X": (4, "X"),
    "G1 X2000000": (4, "beyond 1000 m"),
    "G1 X99999999999": (4, "beyond 1e"),
    "G1 X1 I2": (4, "words of an arc in G0 or G1"),
    "G2 X5": (4, "an arc without centre"),
    "G2 X5 CR=1": (4, "too small"),
    "G2 CR=5": (4, "ends where it starts"),
    "G2 X10 I4": (4, "radius is 4 mm at the start, 6 mm at the end"),
    "G2 X5 K2": (4, "K"),
    "CIP X5 Y5 I1=2.5 J1=2.5": (4, "one line"),
    "CT X5": (4, "no move"),
    "G1 X5 RND=1\nG0 Z5": (5, "the rounding of line 4 stands beside a move out of the plane"),
    "G1 X5 RND=1\nM30": (5, "has no move behind it"),
    "G1 X5 A3=1 B3=0 C3=1": (4, "without TRAORI"),
    "TRAORI\nG1 X5 A3=0 B3=0 C3=0": (5, "no length"),
    "TRAORI\nG1 X5 A2=5 B2=0 C2=0": (5, "as which angles"),
    "TRAORI\nG1 X5 A3=1 C3=1\nTRAFOOF\nX0": (7, "the tool stands tilted"),
    "TRAORI\nCYCLE800(1,\"\",0,57,0,0,0,0,30,0,0,0,0,-1)": (5, "CYCLE800 under TRAORI"),
    "CYCLE800(1,\"\",0,192,0,0,0,0,30,0,0,0,0,-1)": (4, "positions of the rotary axes"),
    "CYCLE800(1,\"\",0,57,0,0,0,0,30,0,0,0,0,-1)\nG1 X5": (5, "a cutting move, but where Y, Z is"),
    "SCALE X2": (4, "SCALE: it scales or mirrors"),
    "MIRROR X0": (4, "MIRROR: it scales or mirrors"),
    "ROT X30 RPL=5": (4, "ROT with RPL and axes"),
    "ROTS X30 Y5": (4, "ROTS: it turns"),
    "TRANS X5 G1": (4, "TRANS beside other words"),
    "CYCLE81(5,0,1)": (4, "CYCLE81 without DP"),
    "CYCLE81(5,0,1,3)": (4, "in this order from above"),
    "CYCLE83(5,0,1,-30,,,,0,0,0,1,0)": (4, "a first depth"),
    "CYCLE84(5,0,1,-30,,0,3)": (4, "CYCLE84(...): a cycle or subprogram"),
    "POCKET3(5,0,1,-30)": (4, "POCKET3(...): a cycle or subprogram"),
    "MCALL POCKET3(5,0,1,-30)": (4, "MCALL POCKET3"),
    "HOLES1(0,0,0,5,5,3)": (4, "without a drilling cycle called by MCALL"),
    "L77": (4, "a subprogram that is not in the file"),
    "CALL \"OTHER\"": (4, "there is no such program"),
    "EXTCALL \"OTHER.SPF\"": (4, "there is no such program"),
    "PART_2": (4, "this reader does not know the word"),
    "IF $AA_IW[X]>5 GOTOF ENDE\nG1 X5\nENDE:": (4, "known only at run time"),
    "GOTOF NOWHERE": (4, "there is no label NOWHERE"),
    "R1=R2+1\nG1 X=R1": (5, "R2, which has no value in the file"),
    "$P_UIFR[1]=CTRANS(X,5)": (4, "CTRANS(...) is no function"),
    "$P_PFRAME=1": (4, "it writes into the control"),
    "WHILE 1==1\nR1=1\nENDWHILE": (4, "runs too many lines"),
    "LOOP\nG1 X5\nENDLOOP": (5, "runs too many lines"),
    "FOR R1=1 TO 5\nG1 X5": (4, "FOR: its end is missing"),
    "ENDIF2": (4, "ENDIF2"),
    "/G1 X1": (4, "whether the block counts"),
    "/M30\nG1 X5": (4, "whether the block counts"),
    "WHEN $AA_IM[X]>5 DO M8": (4, "WHEN: a synchronized action"),
    "POS[X]=5": (4, "POS: an axis"),
    "G1 X5 ANG=30": (4, "ANG: a contour by angles"),
    "BSPLINE": (4, "BSPLINE: a spline"),
    "T=\"A\" M6\nT1": (5, "tool 1 by its number, others by name"),
    "T1 D1 M6\nD2": (5, "D2 after D1"),
    "DIAMON": (4, "DIAMON: a word of lathes"),
    "G96 S100": (4, "G96"),
    "G1 X5 $": (4, "$"),
    "G20": (4, "G20: a word of the ISO dialect; write G710"),
    "G28 Z0": (4, "G28: a word of the ISO dialect"),
    "G4 X5": (4, "G4 with coordinates"),
    "G1 X=1/0": (4, "has no value"),
    "G1 X=SQRT(-1)": (4, "has no value"),
    "DEF AXES A": (4, "DEF AXES"),
    "G1 AP=30 RP=5 X3": (4, "AP, RP and X, Y or Z"),
    "REPEATB NONE": (4, "there is no label NONE"),
}
#: Whole programs.
PROGRAMS: tuple[tuple[str, int | None, str], ...] = (
    ("G0 X1 Y1 Z1\nM30\n", 1, "no units"),
    ("G710\nX1 Y1 Z1\nM30\n", 2, "no G0"),
    ("G710\nG91 G0 X1 Y1 Z1\nM30\n", 2, "that is not known"),
    ("G710\nG0 X1 Y1 Z1\nX2\n", 4, "ends without M30"),
    ("G710\nG0 X1 Y1 Z1\nM30\nG1 X5\n", 4, "words after the end"),
    ("%_N_A_MPF\nG710\nG0 X1 Y1 Z1\nM30\n%_N_B_MPF\nM30\n", 5, "two main programs"),
    ("G0 X0\n%_N_A_MPF\nG710\nM30\n", 1, "words before the first program header"),
    ("G710\nG0 X0 Y0 Z5\nL1\nM30\n%_N_L1_SPF\nG1 X5\nM17\n", 1, "words before"),
    ("%_N_A_MPF\nG710\nG0 X0 Y0 Z5\nL1\nM30\n%_N_L1_SPF\nG1 X5 E1\nM17\n", 7, "E1"),
    ("UNITS/MM\nGOTO/0,0,5\nFINI\n", 1, "'/' is not expected here"),
    ("BEGIN PGM A MM\nL X0 FMAX\nEND PGM A MM\n", 1, "name the file .h"),
)
WORDS = [
    "G0", "G1", "G2", "G3", "G4", "G17", "G18", "G19", "G40", "G41", "G53", "G54", "G55", "G500", "G64", "G70",
    "G71", "G700", "G710", "G75", "G90", "G91", "G93", "G94", "G95", "G110", "G111", "G112", "G153", "X1", "X-2.5",
    "Y3", "Z", "Z0", "Z-1", "X=AC(3)", "X=IC(3)", "X=R1", "R1=5", "R2=R1*2", "I3", "I=AC(5)", "J0", "J1", "K1",
    "CR=9", "CR=-2", "AR=90", "TURN=2", "CIP", "CT", "I1=3", "AP=30", "RP=10", "RND=1", "CHF=1", "CHR=1", "F100",
    "F0", "S900", "T1", 'T="A"', "D1", "M3", "M6", "M17", "M30", "RET", "SUPA", "TRAORI", "TRAFOOF", "A3=1", "B3=0",
    "C3=1", "A30", "B-10", "C=DC(90)", "TRANS", "ATRANS", "ROT", "AROT", "RPL=30",
    'CYCLE800(1,"",0,57,1,2,3,10,20,30,0,0,0,-1)', "CYCLE800()", "CYCLE81(5,0,1,-3)",
    "CYCLE83(5,0,1,-9,,-3,,90,0,0,1,1)", "MCALL", "HOLES1(0,0,0,5,5,3)", "HOLES2(0,0,5,0,60,6)", "MSG(", '"', "DEF",
    "REAL", "INT", "IF", "ELSE", "ENDIF", "FOR", "TO", "ENDFOR", "WHILE", "ENDWHILE", "LOOP", "ENDLOOP", "REPEAT",
    "UNTIL", "GOTOF", "GOTOB", "L1:", "L1", "L2", "P2", "%_N_A_MPF", "%_N_L1_SPF", "PROC", "%", "(", ")", "[", "]",
    "=", ";", "/", "N5", ":10", "99999999999", "é", "SIN(30)", "ORIRPY", "A2=5", "FFWON", "SOFT",
    "CYCLE832(0.01,1,1)", "EXTCALL", "CALL",
]  # fmt: skip
WHOLE = """%_N_PART_MPF
;$PATH=/_N_WKS_DIR/_N_PART_WPD
N10 G90 G17 G710 G40 G64
N20 MSG("PART")
DEF REAL DEEP=-2, SIDE[3]
N30 T="MILL 10" D1
N40 M6
N50 S5000 M3 F600
N60 G0 X0 Y0 Z10
N70 TRAORI
N80 G1 X1 Y1 Z1 A3=0.1 B3=0 C3=1
N90 TRAFOOF
N100 CYCLE800()
N110 G0 X0 Y0 Z10
R1=5 R2=R1*2
FOR R3=1 TO 3
G1 X=R3*5 Z=DEEP RND=1
G1 Y=IC(5)
ENDFOR
IF R2>5 GOTOF NEXT
G1 X999
NEXT: G2 X=IC(4) I2 J0
G3 X=IC(-4) CR=2 TURN=1
CIP X30 Y30 I1=25 J1=40
CT X40
MCALL CYCLE83(20,0,2,-15,,-5,,2,0,0,1,1)
HOLES2(50,50,20,0,60,6)
MCALL
TRANS X10 Y20
AROT Z30
L10 P2
TRANS
CYCLE800(1,"",0,57,0,0,0,30,0,0,0,0,0,-1)
G0 X0 Y0 Z50
G0 Z5
G1 Z-1
G0 Z50
CYCLE800()
SUPA G0 Z0 D0
M30
%_N_L10_SPF
G0 X5 Y5
G1 Z-1
G0 Z10
M17
"""

SAMPLE = Sample(
    read=ReadSample(
        text="G710 G90\nG0 X0 Y0 Z5\nG1 X10 Z0 F600\nY-4\nG0 Z5\nM30\n",
        pieces="\t".join(WORDS).replace(" ", "").replace("\t", " "),
        machine=MACHINE,
        whole=WHOLE,
        refused=(*((HEAD + text + "\nM30\n", *expected) for text, expected in REFUSED.items()), *PROGRAMS),
        spelled=(
            (
                "%_N_PART_MPF\n;$PATH=/_N_WKS_DIR/_N_A_WPD\nN10 G71 G90 G54 G64 SOFT FFWON COMPCAD\n"
                ":20 CYCLE832(0.01,_ORI_FINISH,0.1)\nN30 WORKPIECE(,,,\"BOX\",112,0,-20,-80,0,0,100,100)\n"
                "g0 x0 y0 z5 ; up\nN50 G01 X=1 Y=4/2 Z=1+2 F=99\nM2\n",
                (1, 2, 3),
            ),
        ),
        huge=("G710 G90 G17\nG0 X0 Y0 Z5\n" + "G2 X0 Y0 I900000 J0 TURN=99 F9\n" * 30 + "M30\n", 1e-5),
    ),
    examples=7,
)
