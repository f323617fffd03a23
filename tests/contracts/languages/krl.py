"""KRL in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from tests.oracles.robot_programs import KRL, KRL_DAT, source
from toolpaths.writing.marker import MARKER

POSE = "{X 1,Y 2,Z 3,A 10,B 20,C 30}"
#: What the program does: line and words of the refusal.
REFUSED = [
    ("P=$POS_ACT\nLIN P", 3, "$POS_ACT, where the arm stands (line 2). Give the poses as numbers, there in place of"),
    ("LIN XP9", 2, "XP9"),
    (f"WHILE $IN[1]\nLIN {POSE}\nENDWHILE", 2, "WHILE"),
    (f"LOOP\nLIN {POSE}\nENDLOOP", 2, "LOOP"),
    (f"IF $IN[1]==TRUE THEN\nLIN {POSE}\nENDIF", 2, "$IN[1]"),
    (f"FOR I=1 TO N\nLIN {POSE}\nENDFOR", 2, "N, which"),
    ("LIN {X 1,Y 2}", 2, "missing"),
    ("LIN_REL {X 1}", 2, "where the arm stands"),
    ("PTP_REL {A1 5}", 2, "PTP_REL"),
    (f"LIN {POSE}\nCIRC {POSE},{POSE},CA 90", 3, "CA"),
    (f"LIN {POSE}\nCIRC {POSE},{POSE}", 3, "one line"),
    ("SPLINE\nENDSPLINE", 2, "SPLINE"),
    (f"SWITCH N\nCASE 1\nLIN {POSE}\nENDSWITCH", 2, "N, which"),
    ("SWITCH 1\nCASE\nENDSWITCH", 3, "CASE without a value"),
    ("SWITCH 1\nCASE 1\n", 5, "ENDSWITCH is missing"),
    (f"LIN {POSE}\n$BASE=BASE_DATA[7]\nLIN {{X 1}}", 4, "what is kept of the pose before is not known"),
    (f"LIN {POSE}\n$TOOL={{X 9,Y 0,Z 0,A 0,B 0,C 0}}\nLIN_REL {{X 1}}", 4, "where the arm stands before"),
    ("LIN {X 1,Y 2,Z 1e999,A 0,B 0,C 0}", 2, "finite"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0", 2, ""),
    (f"DRILL({POSE})", 2, "arguments"),
    (f"$VEL.CP=20\nLIN {POSE}", 2, "0.02 where 20 mm/s is meant"),
    (f"$VEL={{CP 3.5,ORI1 200,ORI2 200}}\nLIN {POSE}", 3, "at most 3"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0,E1 1e999}", 2, "finite"),
    (f"$IPO_MODE=#TCP\nLIN {POSE}", 3, "#TCP"),
    ("G1 X1", 2, "no line of KRL"),
]  # fmt: skip

START = "$VEL.CP=0.02\nP={X 1,Y 2,Z 3,A 0,B 0,C 180}\nI=1\nPTP {X 0,Y 0,Z 50,A 0,B 0,C 180}\n"


def behind(*lines: str, declared: str = "FRAME P\nINT I", rest: str = "") -> str:
    """Lines between a rapid and a cut to P."""
    return source(f"{declared}\n{START}" + "".join(f"{line}\n" for line in lines) + "LIN P", rest)


#: The same, as whole programs: what may change a value, moves that would be lost, a number in the wrong unit.
LOST = (
    (behind("FOO(I)", "P.X=I"), 10, "FOO may set"),
    (behind("I=F(2)", rest="DEFFCT INT F(X:IN)\nINT X\nLIN {X 9}\nRETURN X\nENDFCT\n"), 13, "moves the arm"),
    ("DEF PART()\n$VEL.CP=20\nPTP {X 0,Y 0,Z 5,A 0,B 0,C 180}\nEND\n", 2, "it is in m/s"),
)
FULL = "CIRC {X 0,Y 1800000,Z 0},{X 900000,Y 900000,Z 0}\nCIRC {X 0,Y 1800000,Z 0},{X 0,Y 0,Z 0}\n"
DOWN = "A 0,B 0,C 180"

SAMPLE = Sample(
    read=ReadSample(
        text="DEF PART()\n$VEL.CP=0.01\nPTP {X 0,Y 0,Z 5,A 0,B 0,C 180}\nLIN {X 10,Y 0,Z 0,A 0,B 0,C 180}\n"
        "LIN {X 10,Y -4,Z 0,A 0,B 0,C 180}\nPTP {X 10,Y -4,Z 5,A 0,B 0,C 180}\nEND\n",
        pieces="DEF PART() LIN PTP CIRC {X 1,Y 2,Z 3,A 0,B 0,C 180} , C_DIS $VEL.CP= $TOOL= $BASE=$NULLFRAME E6POS P : "
        "( ) 1.0E999 ; &ACCESS IF TRUE THEN ENDIF FOR I=1 TO 9 ENDFOR LIN_REL {Z 5} END ;FOLD DECL REAL R[3] } { "
        '" XP1.X=3 - [2] $POS_ACT DECL INT XP1 WITH $VEL=5 =',
        whole=KRL,
        beside=(".dat", KRL_DAT),
        refused=(*((source(body), line, words) for body, line, words in REFUSED), *LOST),
        spelled=(
            (behind("Q=P", declared="DECL INT I,J\nDECL FRAME P,Q\nREAL A[2,3], B"), (1, 2, 3)),
            (behind("FOO(I)", "FOO(I)"), (1, 2, 3)),
        ),
        huge=("DEF P()\n$VEL.CP=0.1\nPTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\n" + FULL * 8 + "END\n", 1e-8),
    ),
    written=WrittenSample(
        rapid_speed=True,
        frame=1e-6,
        most_lines=12000,
        no_names=("1110_wall", "a-b", "a" * 25, "circ", "größe", "a b"),
        no_name="is no KRL name",
        longest=(24, 20),
        fastest="3 m/s",
    ),
    filtered=FilterSample(
        source=KRL,
        beside=(".dat", KRL_DAT),
        marker=(4, (f"; {MARKER}",)),
        # XP1 serves as a frame and XP2 as a rapid: both are split; 2 literals, 2 relative poses
        lines=(7, 8),
        told=("XP1_C1 was declared beside it", "line 21: {Z 20} became numbers"),
        arc=(
            source(
                f"LIN {{X 0,Y 0,Z 0,{DOWN}}}\nCIRC {{X 10,Y 10,Z 0,{DOWN}}},{{X 20,Y 0,Z 0,{DOWN}}} C_DIS\n"
                f"LIN {{X 30,Y 0,Z 0,{DOWN}}}"
            ),
            "CIRC",
        ),
        arc_told=("poses put in before the move", "an arc became short lines"),
        twice=(source("SUB()\nSUB()", "DEF SUB()\nLIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\nEND\n"), "several times"),
        real={"line3_cleaned.src": "POS_ACT", "Hollow_Box_cleaned.src": "POS_ACT", "KUKA_KRC2_test_post.src": "END"},
        elsewhere=("robodk/Program.src", "line 64: Subprog is not in this file", "not compensated"),
    ),
    examples=2,
)
