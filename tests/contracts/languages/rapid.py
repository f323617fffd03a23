"""RAPID in the contract suites."""

from __future__ import annotations

from tests.contracts.sample import FilterSample, ReadSample, Sample, WrittenSample
from tests.oracles.robot_programs import RAPID, module, target
from toolpaths.writing.marker import MARKER

TARGET = target(1, 2, 3)


def target_at(xyz: str) -> str:
    return f"[[{xyz}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def behind(*lines: str, rest: str = "") -> str:
    """Lines between a rapid and a cut to p, which is x further along X than TARGET."""
    body = "\n".join([f"MoveJ {TARGET},v1000,fine,tool0;", *lines, "MoveL Offs(p,x,0,0),v20,z1,tool0;"])
    return module(body, f"VAR robtarget p:={TARGET};\nVAR num x:=1;\nCONST num c:=1;\nVAR num y;\n", rest)


#: What main() does: line and words of the refusal.
REFUSED = [
    ("MoveL CRobT(),v10,z1,tool0;", 3, "run time"),
    ("MoveL p99,v10,z1,tool0;", 3, "p99"),
    (f"WHILE TRUE DO\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDWHILE", 3, "WHILE"),
    (f"IF di1 = 1 THEN\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDIF", 3, "di1"),
    (f"FOR i FROM 1 TO n DO\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDFOR", 3, "n, which"),
    (f"TriggL {target(1, 2, 3)},v10,t1,z1,tool0;", 3, "TriggL"),
    (f"SearchL di1,p1,{target(1, 2, 3)},v10,tool0;", 3, "SearchL"),
    ("PDispSet pose1;", 3, "PDispSet"),
    (f"DrillHole {target(1, 2, 3)};", 3, "instruction DrillHole is not known"),
    ("SpotL p99,v10,gun1,spot1,tool0;", 3, "SpotL"),
    ('%"cut" + "2"%;', 3, "routine is known only at run time"),
    (f"IF di1=1 MoveL {target(1, 2, 3)},v10,z1,tool0;", 3, "di1"),
    ("IF TRUE;", 3, "IF needs"),
    ("IF TRUE IF TRUE Stop;", 3, "one instruction is expected"),
    (f"TEST n\nCASE 1:\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDTEST", 3, "n, which"),
    ("TEST 1\nCASE 1\nStop;\nENDTEST", 4, "colon"),
    ("TEST 1\nCASE 1:\nStop;\n", 7, "ENDTEST is missing"),
    (f"MoveL {target(1, 2, 3)},v10,z1,tool0\\Corr;", 3, "sensor"),
    ("MoveL [[1,2,3],[1,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,z1,tool0;", 3, "length 1.41"),
    ("MoveL [[1,2,1e999],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,z1,tool0;", 3, "finite"),
    (f"MoveC {target(1, 2, 3)},{target(2, 2, 3)},v10,z1,tool0;", 3, "arc"),
    (f"MoveL {target(1, 2, 3)},v10,z1;", 3, "expected"),
    (f"MoveL {target(1, 2, 3)},v10,z1,tool0", 3, "no end"),
    ("GOTO again;", 3, "jump"),
]  # fmt: skip

#: The same, as whole programs: what may change a value, or moves that would be lost.
LOST = (
    (behind("Add x,4;"), 9, "Add may set"),
    (behind("Clear x;"), 9, "Clear may set"),
    (behind('TPReadNum x,"how far";'), 9, "TPReadNum may set"),
    (behind("Foo\\Far:=x,2;"), 9, "Foo may set"),
    (
        behind("y:=f(2);", rest=f"FUNC num f(num a)\nMoveL {TARGET},v20,z1,tool0;\nRETURN a;\nENDFUNC\n"),
        12,
        "the function f moves",
    ),
)
POSES = [("MoveJ", "0,0,5", "v100"), ("MoveL", "10,0,0", "v10"), ("MoveL", "10,-4,0", "v10"),
         ("MoveJ", "10,-4,5", "v100")]  # fmt: skip
ARC = "\n".join(
    f"MoveL {target(0, 0, 0)},v20,fine,tool0;\nMoveC {target(10, 10, 0)},{target(20, 0, 0)},v20,z1,tool0;\n"
    f"MoveL {target(30, 0, 0)},v20,fine,tool0;".split("\n")
)

SAMPLE = Sample(
    read=ReadSample(
        text="MODULE M\nPROC main()\n"
        + "".join(f"{word} {target_at(xyz)}, {speed}, fine, tool0;\n" for word, xyz, speed in POSES)
        + "ENDPROC\nENDMODULE\n",
        pieces="MODULE M PROC main() MoveL MoveJ MoveC MoveAbsJ [[1,2,3],[0,1,0,0],[0,0,0,0],[9E9]] , v10 fine tool0 ; "
        "CONST robtarget a := Offs( RelTool( ) \\WObj:= 1e999 IF TRUE THEN ENDIF FOR i FROM 1 TO 9 DO ENDFOR ENDPROC "
        'ENDMODULE ! %%% a(1,2) * - / PERS tooldata ] [ " 1e999 p10.trans.x:=3; \\ {2} CRobT() VAR num p10:=1;',
        rapid_feed=0.1,
        twice="Two programs in one file",
        whole=RAPID,
        refused=(*((module(body), line, words) for body, line, words in REFUSED), *LOST),
        spelled=(
            (
                behind(
                    "SpindleOn y;", "Spin c;", "x:=c;", "PDispOff;", "EOffsOff;", "IDelete i1;", "WorldAccLim\\Off;"
                ),
                (2, 2, 3),
            ),
        ),
    ),
    written=WrittenSample(frame=1e-7, most_lines=5100),
    filtered=FilterSample(
        source=RAPID.replace("! corner", "! Eck\u00fc, na so was") + "! the end",
        marker=(6, (f"  ! {MARKER}",)),
        lines=(7, 9),
        shown=("MoveC [[120.1200,39.6600,-1.4400],[0,1,0,0]",),
        told=("p10_c1 was declared beside it", "Offs(p10,0,0,82) became numbers"),
        arc=(module(ARC), "MoveC"),
        arc_told=("poses put in before the move", "an arc became short lines"),
        by_time=(
            (
                module(f"MoveL {TARGET},v10,z1,tool0;\nMoveL {target(5, 2, 3)},v10\\T:=2,z1,tool0;"),
                1,
                "a move with \\T cannot be divided",
                "\\T:=2",
            ),
        ),
        twice=(module("sub;\nsub;", rest=f"PROC sub()\nMoveL {TARGET},v5,fine,tool0;\nENDPROC\n"), "several times"),
        real={},
        elsewhere=("robodk/Program.mod", "line 30: Subprog is not in this file", "not compensated"),
    ),
    examples=2,
)
