"""Variables, jumps, loops, subprograms and archives of SINUMERIK programs."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import Toolpath

HEAD = "G710 G90 G17\nG0 X0 Y0 Z0\nF600\n"
read = partial(read_text, "part.mpf")


def x_of(tmp_path: Path, text: str, end: str = "M30\n") -> list[float]:
    """Where X goes behind HEAD, mm."""
    return np.round(ends(read(tmp_path, f"{HEAD}{text}\n{end}"))[1:, 0], 9).tolist()  # type: ignore[no-any-return]


VALUES = {
    "R1=5 R3=2\nR2=R1*R3+1\nG1 X=R2": [11],
    "R1=-5\nG1 X=-R1": [5],
    "R[3]=4\nG1 X=R3 F=R3*100": [4],
    "G1 X=10-2*3+8/4": [6],
    "G1 X=(10-2)*3": [24],
    "G1 X=SIN(30)*10+COS(60)+TAN(45)": [6.5],
    "G1 X=ASIN(0.5)+ACOS(0.5)+ATAN2(10,10)": [135],
    "G1 X=SQRT(16)+POT(3)+ABS(-2)": [15],
    "G1 X=ROUND(2.5)+TRUNC(-2.5)+ROUNDUP(2.1)": [4],
    "G1 X=17 DIV 5+17 MOD 5": [5],
    "G1 X=MINVAL(3,2)+MAXVAL(3,2)+BOUND(0,5,9)": [10],
    "G1 X=1.5EX1": [15],
    "DEF REAL A_1=1.5, B_2\nDEF INT C_3\nB_2=A_1*2\nG1 X=B_2+C_3": [3],
    "DEF REAL TAB[4]\nTAB[2]=7\nG1 X=TAB[2]+1": [8],
    "DEF BOOL B_1=TRUE\nIF B_1 AND NOT (1>2)\nG1 X1\nELSE\nG1 X2\nENDIF": [1],
    'DEF STRING[20] S_1="HELLO"\nIF S_1=="HELLO"\nG1 X1\nENDIF': [1],
    "_CYCLE_DATA=7\nG1 X=_CYCLE_DATA": [7],
}


@pytest.mark.parametrize("text", VALUES)
def test_values(tmp_path: Path, text: str) -> None:
    assert x_of(tmp_path, text) == VALUES[text]


FLOW = {
    "IF": "R1=3\nIF R1<>3\nG1 X1\nELSE\nIF R1>=3\nG1 X2\nENDIF\nG1 X3\nENDIF\nG1 X4 : 2 3 4",
    "FOR": "FOR R1=1 TO 3\nG1 X=R1\nENDFOR\nG1 X=R1*10 : 1 2 3 40",
    "FOR, never": "FOR R1=5 TO 3\nG1 X=R1\nENDFOR\nG1 X9 : 9",
    "FOR in FOR": "FOR R1=1 TO 2\nFOR R2=1 TO 2\nG1 X=R1*10+R2\nENDFOR\nENDFOR : 11 12 21 22",
    "WHILE": "R1=0\nWHILE R1<3\nR1=R1+1\nG1 X=R1\nENDWHILE : 1 2 3",
    "REPEAT UNTIL": "R1=0\nREPEAT\nR1=R1+1\nG1 X=R1\nUNTIL R1==3 : 1 2 3",
    "LOOP": "R1=0\nLOOP\nR1=R1+1\nG1 X=R1\nIF R1>2 GOTOF OUT\nENDLOOP\nOUT: G1 X9 : 1 2 3 9",
    "GOTOB": "R1=0\nAGAIN: R1=R1+1\nG1 X=R1\nIF R1<3 GOTOB AGAIN : 1 2 3",
    "GOTOF a number": "GOTOF N90\nG1 X1\nN90 G1 X2 : 2",
    "GOTO": "GOTO A_1\nB_1: G1 X1\nGOTOF C_1\nA_1: G1 X2\nGOTO B_1\nC_1: G1 X3 : 2 1 3",
    "a section again": "A_1: G1 X=IC(1)\nX=IC(2)\nREPEAT A_1 P=2\nG1 X=IC(10) : 1 3 4 6 7 9 19",
    "a section by both labels": "A_1: G1 X=IC(1)\nX=IC(2)\nB_1: X=IC(3)\nX=IC(4)\nREPEAT A_1 B_1 : 1 3 6 10 11 13 16",
    "to ENDLABEL": "A_1: G1 X=IC(1)\nENDLABEL: X=IC(2)\nX=IC(4)\nREPEAT A_1 : 1 3 7 8 10",
    "one line again": "A_1: G1 X=IC(1)\nX=IC(2)\nREPEATB A_1 P=2 : 1 3 4 5",
    "CALL BLOCK": "A_1: G1 X=IC(1)\nB_1: X=IC(2)\nCALL BLOCK A_1 TO B_1 : 1 3 4 6",
    "an unknown IF around nothing": "IF $AC_TIME>5\nMSG(\"LATE\")\nM0\nENDIF\nG1 X1 : 1",
}


@pytest.mark.parametrize("name", FLOW)
def test_flow(tmp_path: Path, name: str) -> None:
    text, _, expected = FLOW[name].rpartition(" : ")
    assert x_of(tmp_path, text) == [float(v) for v in expected.split()]


def archive(*subprograms: str, main: str) -> str:
    return f"%_N_MAIN_MPF\n;$PATH=/_N_MPF_DIR\n{HEAD}{main}\nM30\n" + "\n".join(subprograms) + "\n"


def run(tmp_path: Path, text: str) -> Toolpath:
    return read(tmp_path, text)


def test_subprograms_of_an_archive(tmp_path: Path) -> None:
    """L and a number, a name, several times, nested, with values, with modal words that come back."""
    text = archive(
        "%_N_L10_SPF\nG91 G1 X1\nG90\nM17",
        "%_N_POCKET_SPF\n;$PATH=/_N_SPF_DIR\nPROC POCKET(REAL WIDE, INT TIMES=2) SAVE\n"
        "G91\nFOR R9=1 TO TIMES\nG1 X=WIDE\nENDFOR\n"
        "L10\nRET",
        "%_N_UNUSED_SPF\nG1 X999\nM17",
        main="G1 X0\nL10 P3\nPOCKET(10)\nPOCKET(100,1)\nG1 X=R9",
    )
    path = run(tmp_path, text)
    assert np.round(ends(path)[2:, 0], 9).tolist() == [1, 2, 3, 13, 23, 24, 124, 125, 2]
    assert path.line.tolist() == [4, 6, 13, 13, 13, 21, 21, 13, 21, 13, 10]
    line = next(e.line for e in path.events if e.word == "UNUSED_SPF is not called")
    assert text.split("\n")[line - 1] == "%_N_UNUSED_SPF"


def test_variables_of_a_subprogram_are_its_own(tmp_path: Path) -> None:
    text = archive(
        "%_N_SUB_SPF\nPROC SUB\nDEF REAL WIDE=7\nG1 X=WIDE\nWIDE=8\nM17", main="DEF REAL WIDE=1\nSUB\nG1 X=WIDE"
    )
    assert np.round(ends(run(tmp_path, text))[1:, 0], 9).tolist() == [7, 1]


def test_a_program_beside(tmp_path: Path) -> None:
    """Called by name, by text or by EXTCALL, whatever folders the name has; its poses carry the line of the call."""
    (tmp_path / "Op1.SPF").write_text("%_N_OP1_SPF\nG1 X1\nY1\nM17\n")
    (tmp_path / "l20.spf").write_text("G1 X20\nRET\n")
    calls = 'OP1\nCALL "OP1"\nEXTCALL "OP1.SPF"\nEXTCALL("/_N_EXT_DIR/_N_OP1_SPF")\nL20'
    path = read(tmp_path, f"{HEAD}{calls}\nM30\n")
    assert path.line.tolist() == [2, 4, 4, 5, 5, 6, 6, 7, 7, 8]
    assert np.round(path.position[-3:, 0] * 1e3).tolist() == [1, 1, 20]


def test_an_error_in_a_program_beside_names_its_file_and_line(tmp_path: Path) -> None:
    (tmp_path / "OP1.SPF").write_text("G1 X1\nG41 X2\nM17\n")
    with pytest.raises(ReadError, match=r"OP1\.SPF:2: G41: cutter compensation"):
        read(tmp_path, f"{HEAD}OP1\nM30\n")


REFUSED = {
    "G1 X=R7": (4, "R7, which has no value in the file"),
    "G1 X=$AA_IM[X]": (4, "known only at run time"),
    "IF $AC_TIME>5\nG1 X1\nENDIF": (4, "what runs depends on"),
    "IF $AC_TIME>5 GOTOF NEXT\nNEXT: G1 X1": (4, "what runs depends on"),
    "G1 X=1/0": (4, "1 / 0 has no value"),
    "G1 X=(5": (4, ""),
    "G1 X=5 5": (4, ""),
    "FOR R1=1 TO 3\nG1 X1": (4, "FOR: its end is missing"),
    "ENDFOR": (4, "ENDFOR without its begin"),
    "R1=1\nFOR R1=1 TO 9999999\nR2=1\nENDFOR": (6, "runs too many lines"),
    "L99": (4, "a subprogram that is not in the file"),
    "OTHER(5)": (4, "OTHER(...): a cycle or subprogram that is not in the file"),
    "A_1: G1 X1\nREPEAT A_1 P=-1": (5, "a whole number"),
    "GOTOS": (4, "without end"),
    "CASE R1 OF 1 GOTOF A": (4, "CASE: a jump by a table"),
    "DEF FRAME F_1\nF_1=CTRANS(X,5)": (5, "CTRANS(...) is no function"),
    "R1=5 R2=R1*2": (4, "R1 is set and used in one block"),
    "FOO=5": (4, "FOO=...: no address that is read, and no variable of DEF"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_refused(tmp_path: Path, text: str) -> None:
    line, told = REFUSED[text]
    with pytest.raises(ReadError) as caught:
        read(tmp_path, f"{HEAD}{text}\nM30\n")
    assert caught.value.line == line and told in str(caught.value)


def test_a_program_that_calls_itself(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="more than 20 deep"):
        run(tmp_path, archive("%_N_L1_SPF\nL1\nM17", main="L1"))


SKIPPED = {
    "/M8": True,
    '/1 MSG("A")': True,
    "/M30": True,
    "N5 /M1": True,
    "/ G1 X1": False,
    "/M6": False,
    "/R1=5": False,
}


@pytest.mark.parametrize("text", SKIPPED)
def test_block_skip(tmp_path: Path, text: str) -> None:
    """Let pass where it makes no difference whether the block counts."""
    end = "" if text == "/M30" else "M30\n"
    if SKIPPED[text]:
        assert text.strip() in [e.word for e in read(tmp_path, f"{HEAD}{text}\n{end}").events]
    else:
        with pytest.raises(ReadError, match="whether the block counts is chosen at the machine"):
            read(tmp_path, f"{HEAD}{text}\n{end}")
