"""One suite over all readers: a remark without its end never swallows a move; texts and comments may name moves."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.contracts.languages.inform import job
from tests.contracts.languages.val3 import DATA, SET, program
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.reading.swallowed import behind_call, without_quotes

POSE = "[[{},0,0],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
RAPID = f"MoveL {POSE.format(5)},v10,z1,tool0;"
KRL_POSE = "{{X {},Y 0,Z 0,A 0,B 0,C 180}}"
UR = "movel(p[0.5,0,0.3,0,0,0],a=1,v=0.1)"
TP_POINT = (
    "P[{0}]{{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = {0}.0 mm, Y = 0.0 mm, Z = 0.0 mm,\n"
    " W = 0.0 deg, P = 0.0 deg, R = 0.0 deg\n}};\n"
)
#: Language -> suffix, the line that ``{}`` stands in, and a program of two moves around it.
PROGRAMS = {
    "heidenhain": ("h", 3, "BEGIN PGM A MM\n1 L X+0 Y+0 Z+9 R0 FMAX\n{}\n8 L X+9 F500\nEND PGM A MM\n"),
    "apt": ("apt", 4, "UNITS/MM\nFEDRAT/500,MMPM\nGOTO/0,0,5\n{}\nGOTO/50,50,-1\nFINI\n"),
    "rapid": (
        "mod",
        4,
        f"MODULE M\nPROC main()\n MoveL {POSE.format(1)},v10,z1,tool0;\n{{}}\n"
        f" MoveL {POSE.format(9)},v10,z1,tool0;\nENDPROC\nPROC cut()\n {RAPID}\nENDPROC\nENDMODULE\n",
    ),
    "fanuc": (
        "ls",
        4,
        "/PROG A\n/MN\n   1:L P[1] 100mm/sec FINE ;\n{}\n   9:L P[3] 100mm/sec FINE ;\n/POS\n"
        + "".join(map(TP_POINT.format, (1, 2, 3)))
        + "/END\n",
    ),
    "inform": ("jbi", 21, job("MOVL C00001 V=10.0", "{}", "MOVL C00003 V=10.0")),
    "val3": ("pgx", 19, program(*SET, "{}", "movel(pa,t,m)")),
    "krl": ("src", 4, f"DEF A()\n$VEL.CP=0.1\nPTP {KRL_POSE.format(0)}\n{{}}\nLIN {KRL_POSE.format(9)}\nEND\n"),
    "urscript": (
        "script",
        3,
        "def prog():\n  movel(p[0.4,0,0.3,0,0,0],a=1,v=0.1)\n  {}\n  movel(p[0.4,0.1,0.3,0,0,0],a=1,v=0.1)\nend\n",
    ),
    "siemens": ("mpf", 3, "G90 G710 G94\nG0 X0 Y0 Z5\n{}\nG1 Y5 F100\nM30\n"),
    "gcode": ("nc", 3, "G21 G90 G94\nG0 X0 Y0 Z5\n{}\nG1 Y5 F100\nM30\n"),
}
CYCLE = "3 CYCL DEF 200 DRILLING ~\n" + "".join(
    f"    Q{q} ;VALUE ~\n" for q in ("200=2", "201=-5", "206=100", "202=5", "210=0", "203=0", "204=10")
)
#: What stands there -> a word of the refusal.
REFUSED = {
    "heidenhain": {
        f"{CYCLE}    Q211=0 ;DWELL ~\n4 L X+5 Y+5 R0 FMAX M99": "is a block of its own",
        f"{CYCLE}    Q211=0 ;DWELL ~\nL X+5 Y+5 R0 FMAX M99": "is a block of its own",
        f"{CYCLE}    Q211=0 L X+5 R0 FMAX M99": "would be lost",
        "4 * - CONTOUR ~\n5 L X+50 F1000": "'5 L X+50 F1000', which is a block of its own",
        "4 * - CONTOUR ~\nC X+5 Y+5 DR+": "is a block of its own",
        "4 CYCL DEF 32.0 TOLERANZ ~\n5 L X+5 F100": "goes on ('~') into line 4",
        "4 STOP ~\n5 L X+5 F100": "goes on",
        "4 STOP L X+5 F100": "would be lost",
        "4 STOP M99": "would be lost",
        "4 TOOL DEF 5 ~\n5 L X+5 F100": "goes on",
        "4 TOOL DEF 5 L X+5 F100": "would be lost",
        "4 BLK FORM 0.1 Z X+0 Y+0 Z-2 ~\n5 L X+5 F100": "goes on",
        "4 LBL 1 L X+5 F100": "would be lost",
        "4 FN 16: F-PRINT A.A / B.TXT ~\n5 L X+5 F100": "goes on",
        "4 FN 16: F-PRINT A.A CYCL CALL": "would be lost",
        "4 FUNCTION DWELL TIME1 L X+5": "would be lost",
        "4 CYCL DEF 9.1 TIME 2 L X+5 F100": "would be lost",
    },
    "apt": {
        "PPRINT SIDE A $\nGOTO/50,0,-1": "'GOTO/50,0,-1', which is a statement of its own",
        "INSERT M08 $\nGOTO/50,0,-1": "goes on ('$') into line 5",
        "PARTNO X $\nUNITS/MM": "goes on",
        "INSERT M08 $\nRAPID": "goes on",
        "COOLNT/ON $\nCIRCLE/0,0,0,0,0,1,5": "goes on",
        "COOLNT/ON GOTO/50,0,-1": "would be lost",
        "PAINT PATH; GOTO/1,1,1": "would be lost",
        "SPINDL/1000,RPM,CLW GOTO/1,1,1": "would be lost",
        "INSERT G1 X50 Y2": "a block for the machine that moves it",
    },
    "rapid": {
        f"WaitTime 2\n{RAPID}": "'WaitTime 2' has no end (;)",
        f"Stop\n{RAPID}": "no end",
        "Stop\ncut;": "'cut;' would be lost",
        f"IF di1=1 WaitTime 2\n{RAPID}": "no end",
        'TPWrite "a"\ncut;': "no end",
        f"SetDO do1,1 {RAPID}": "no end",
        f"VAR num n:=3\n{RAPID}": "no end",
        f"AccSet 50,50\n{RAPID}": "no end",
        f"gripOpen\n{RAPID}": "no end",
    },
    "fanuc": {
        "   3: WAIT 1.00(sec)\n   4:L P[2] 100mm/sec FINE ;": "'WAIT 1.00(sec)' without ';' goes on into 'L P[2]",
        "   3: DO[1]=ON\n   4:L P[2] 100mm/sec FINE ;": "without ';'",
        "   3: !hello\n   4:L P[2] 100mm/sec FINE ;": "without ';'",
        " : !hello\n :L P[2] 100mm/sec FINE ;": "without ';'",
        "   3: DO[1]=ON L P[2] 100mm/sec FINE ;": "would be lost",
        "   3: WAIT 1.00(sec) CALL CUT ;": "would be lost",
        "   3: DO[1]=ON R[1]=5 ;": "would be lost",
        "   3: IF DI[1]=ON,DO[1]=ON L P[2] 100mm/sec FINE ;": "decides about",
    },
    "inform": {
        "DOUT OT#(5) ON MOVL C00002 V=20.0": "'MOVL C00002 V=20.0', which would be lost",
        "TIMER T=1.00 MOVL C00002 V=20.0": "would be lost",
        "PAUSE CALL JOB:X": "would be lost",
        "*LABEL MOVL C00002 V=20.0": "would be lost",
        "HPVELON MOVJ C00002": "would be lost",
    },
    "val3": {
        "delay(1) movel(pa,t,m)": "would be lost",
        'putln("x") pa.trsf.x=850': "more than one statement",
        "n=5 movel(pa,t,m)": "would be lost",
        "else movel(pa,t,m)": "would be lost",
        "n=5 pa.trsf.x=850": "more than one",
        "call x() movel(pa,t,m)": "would be lost",
        "movel(pa,t,m) delay(1)": "more than one statement",
    },
    "krl": {
        "WAIT SEC 1 LIN {X 5}": "'LIN {X 5}', which would be lost",
        "WAIT SEC 1 CUT()": "more than one statement",
        "HALT LIN {X 5}": "would be lost",
        "CONTINUE CUT()": "more than one",
        "INT K=3 LIN {X 5}": "would be lost",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE LIN {X 5}": "would be lost",
        "BAS(#VEL_CP,0.1) LIN (5)": "would be lost",
        "PULSE($OUT[1],TRUE,0.5) $VEL.CP=2": "more than one",
        f"LIN {{X 10}}:{KRL_POSE.format(1)}": "Y, Z, A, B, C missing beside ':'",
    },
    "urscript": {
        f"sleep(1) {UR}": "would be lost",
        f'$ 3 "W" {UR}': "would be lost",
        f"sleep(1); {UR}": "would be lost",
        f"set_digital_out(1,True) {UR}": "would be lost",
        f"return {UR}": "would be lost",
        "sleep(1) x=5": "more than one",
        f'textmsg("a", {UR})': "would be lost",
    },
    "siemens": {
        "IF 1==1\nENDIF X5": "'X5' is not expected here",
        "PROC A G1 X5": "no other words",
        "EXTERN A(REAL) X5": "no other words",
        "FOR R1=1 TO 2 X5\nENDFOR": "not expected",
        "DEF INT AA=5 X5": "not expected",
        "IF 1==1\nELSE X5\nENDIF": "not expected",
        'IF $A_IN[1]==1\nMSG("x") G1 X5\nENDIF': "known only at run time",
        "TRANS X50\nG91 G1 X5 F100": "SD42440",
        "ATRANS Z-2\nZ=IC(-1)": "the frame has shifted it by 2 mm",
    },
    "gcode": {"G4 P1 G1 X5": "put the dwell into a block of its own", "(hello G1 X5": "a comment that is not closed"},
}
#: What stands there -> how many poses it adds.
READ = {
    "heidenhain": {
        "4 TOOL DEF 5 L+10 R+5": 0,
        f"{CYCLE}    Q211=0 ;DWELL\n4 L X+5 FMAX M99": 4,
        "4 L X+5 ~\n    Y+5 F100": 1,
        "4 ; L X+5 F100": 0,
        "4 * L X+5 F100": 0,
        "4 LBL 1": 0,
    },
    "apt": {
        "PPRINT SIDE $\n  B": 0,
        "PPRINT GOTO/1,2,3": 0,
        "INSERT Stock X220. Y220.": 0,
        "GOTO/50,0,$\n-1": 1,
        "$$ GOTO/1,2,3 $": 0,
    },
    "rapid": {
        'TPWrite "MoveL p" \\Num:=3;': 0,
        "WaitTime\\InPos,0.5;": 0,
        "PulseDO \\High \\PLength:=0.2, do1;": 0,
        "WaitUntil di1=1 AND di2=0 \\MaxTime:=3;": 0,
        "SetDO do1,1 ! MoveL\n;": 0,
        "! hello\ncut;": 1,
    },
    "fanuc": {
        "   3:L P[2] 100mm/sec\n    :  FINE ;": 1,
        "   3: !L P[2] 100mm/sec FINE ;": 0,
        "   3: MESSAGE[CALL L P] ;": 0,
        "   3: WAIT DI[1]=ON OR\n    : R[1]=5 ;": 0,
        "   3: SKIP CONDITION R[1]=5 ;": 0,
        "   3: F[1]=(R[1]=2) ;": 0,
    },
    "inform": {"'MOVL C00002 V=20.0": 0, "*CALL": 0, 'MSG "MOVL C2"': 0, "WAIT IN#(1)=ON T=5.00": 0},
    "val3": {
        'putln("movel(pa,t,m)")': 0,
        "// movel(pa,t,m)": 0,
        "if (n==1) and (n==2)\nn=3\nendIf": 0,
        "for i=0 to (n)\nendFor": 0,
    },
    "krl": {
        "WAIT FOR NOT $IN[1] AND ($IN[2])": 0,
        'CWRITE(H,S,M,"LIN X")': 0,
        "WAIT FOR $MODE==#LIN": 0,
        "; LIN {X 5}": 0,
        f"LIN {KRL_POSE.format(5)}:{KRL_POSE.format(1)}": 1,
        "BRAKE F": 0,
    },
    "urscript": {
        'textmsg("movel(x)")': 0,
        "sleep(1)": 0,
        '$ 3 "movel(p)"': 0,
        "# movel(p)": 0,
        'textmsg("v", conveyor_speed)': 0,
    },
    "siemens": {
        'MSG("x") G1 X5 F9': 1,
        "STOPRE G1 X5 F9": 1,
        'IF $A_IN[1]==1\nMSG("x"<<R1)\nM0\nENDIF': 0,
        "EXTERN A(REAL, INT)": 0,
        "TRANS X50\nTRANS\nG91 G1 X5 F9\nG90": 1,
        "TRANS X50\nG1 X0 F9\nG91 X5\nG90": 2,
    },
    "gcode": {"M0 G1 X5 F9": 1, "(G1 X5)": 0},
}


def test_tapping_that_is_announced(tmp_path: Path) -> None:
    """M29 in front of G84 changes nothing about its moves, and asks for nothing by itself."""
    tap = "M3 S500\n{}G84 X5 Z-3 R2 F250\nG80\nG1 X9"
    plain, rigid = (read_toolpath(given(tmp_path, "gcode", tap.format(m))) for m in ("", "M29 S500\n"))
    assert rigid.position.tolist() == plain.position.tolist() and len(rigid) > 4
    said = {e.word: [c.word for c in e.commands] for e in rigid.events}
    assert said["S500 M29"] == ["M3"]


def given(tmp_path: Path, language: str, text: str) -> Path:
    suffix, _, around = PROGRAMS[language]
    (tmp_path / "part.dtx").write_text(DATA if language == "val3" else "")
    file = tmp_path / f"part.{suffix}"
    lines = text if language != "val3" else text.replace("\n", "\n  ")
    file.write_text(around.replace("{}", lines))
    return file


@pytest.mark.parametrize(("language", "text"), [(name, text) for name, texts in REFUSED.items() for text in texts])
def test_a_swallowed_move_is_refused_where_it_begins(tmp_path: Path, language: str, text: str) -> None:
    file = given(tmp_path, language, text)
    with pytest.raises(ReadError, match=re.escape(REFUSED[language][text])) as caught:
        read_toolpath(file)
    first = PROGRAMS[language][1]
    assert first <= (caught.value.line or 0) <= first + text.count("\n")


@pytest.mark.parametrize(("language", "text"), [(name, text) for name, texts in READ.items() for text in texts])
def test_texts_that_name_moves_are_texts(tmp_path: Path, language: str, text: str) -> None:
    path = read_toolpath(given(tmp_path, language, text))
    alone = read_toolpath(given(tmp_path, language, ""))
    assert len(path) - len(alone) == READ[language][text]


def test_what_stands_behind_a_call() -> None:
    assert behind_call('putln("a) b(") x=1') == "x=1" and behind_call("f(g(1))") == "" and behind_call("x = 5") == ""
    assert without_quotes('a "b c" d') == 'a "     d'
