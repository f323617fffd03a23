"""Spellings of real posts and hand-written programs, and values that something beside the moves may change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

MOVEJ, MOVEL = "movej(p[0,0,0.05,3.14159265,0,0])", "movel(P,v=0.02)"
CUT = "def cut():\n  movel(p[0,0,0,3.1,0,0],v=0.02)\n  return 1\nend\n"
SETS = "P=p[0.001,0.002,0.003,3.14159265,0,0]\ndef foo():\n  global P=p[0,0,0.5,3.1,0,0]\n  return 1\nend\n"
TARGET = "[[1,2,3],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
KRL_START = "$VEL.CP=0.02\nP={X 1,Y 2,Z 3,A 0,B 0,C 180}\nI=1\nPTP {X 0,Y 0,Z 50,A 0,B 0,C 180}\n"


def read(tmp_path: Path, suffix: str, text: str):
    path = tmp_path / f"part{suffix}"
    path.write_text(text)
    return read_toolpath(path)


def script(*lines: str, before: str = "") -> str:
    return before + "def part():\n" + "".join(f"  {line}\n" for line in lines) + "end\npart()\n"


def module(*lines: str, rest: str = "") -> str:
    body = "\n".join([f"MoveJ {TARGET},v1000,fine,tool0;", *lines, "MoveL Offs(p,x,0,0),v20,z1,tool0;"])
    data = f"VAR robtarget p:={TARGET};\nVAR num x:=1;\nCONST num c:=1;\nVAR num y;\n"
    return f"MODULE M\n{data}PROC main()\n{body}\nENDPROC\n{rest}ENDMODULE\n"


def source(*lines: str, declared: str = "FRAME P\nINT I", rest: str = "") -> str:
    return f"DEF PART()\n{declared}\n{KRL_START}" + "".join(f"{line}\n" for line in lines) + f"LIN P\nEND\n{rest}"


REFUSED = [
    (".script", script("P=p[0,0,0,3.1,0,0]", MOVEJ, "if get_digital_in(1):", "  P[2]=0.5", "end", MOVEL), 7, "line 5"),
    (".script", script(MOVEJ, "if get_digital_in(1):", "  foo()", "end", MOVEL, before=SETS), 11, "line 3"),
    (".script", script(MOVEJ, "x=foo()", MOVEL, before=SETS), 9, "line 3"),
    (".script", script(MOVEJ, "textmsg(foo())", MOVEL, before=SETS), 9, "line 3"),
    (".script", script(MOVEJ, "t=run go()", MOVEL, before=SETS + "thread go():\n  foo()\nend\n"), 12, "line 3"),
    (".script", script(MOVEJ, "x=cut()", before=CUT), 7, "calls a function that moves the arm"),
    (".script", script(MOVEJ, "textmsg(cut())", before=CUT), 7, "calls a function that moves the arm"),
    (".script", script(MOVEJ, "if x==1:", "  sync()", "elif cut()==1:", "  sync()", "end", before=CUT), 7, "decides"),
    (".script", script(MOVEJ, "while cut()==1:", "  sync()", "end", before=CUT), 7, "decides"),
    (".script", script(MOVEJ, "go()", before=CUT + "def go():\n  return cut()\nend\n"), 6, "moves the arm"),
    (".script", script(MOVEJ) * 2, 5, "Two programs in one file"),
    (".script", script("P=p[0,0,0,3.1,0,0]", "movel(p[P[6],0,0,0,0,0])"), 3, "P has no element 6"),
    (".mod", module("Add x,4;"), 9, "Add may set"),
    (".mod", module("Clear x;"), 9, "Clear may set"),
    (".mod", module('TPReadNum x,"how far";'), 9, "TPReadNum may set"),
    (".mod", module("Foo\\Far:=x,2;"), 9, "Foo may set"),
    (".mod", module("y:=f(2);", rest=f"FUNC num f(num a)\nMoveL {TARGET},v20,z1,tool0;\nRETURN a;\nENDFUNC\n"), 12,
     "the function f moves"),
    (".src", source("FOO(I)", "P.X=I"), 10, "FOO may set"),
    (".src", source("I=F(2)", rest="DEFFCT INT F(X:IN)\nINT X\nLIN {X 9}\nRETURN X\nENDFCT\n"), 13, "moves the arm"),
    (".src", "DEF PART()\n$VEL.CP=20\nPTP {X 0,Y 0,Z 5,A 0,B 0,C 180}\nEND\n", 2, "it is in m/s"),
    (".nc", "G21 G90\nG0 X0 Y0 Z5\nG5 X1 Y1 P2\nM30\n", 3, "spline"),
    (".nc", "G21 G90\nG0 X0 Y0 Z5\nG50.1 X0\nM30\n", 3, "with coordinates"),
]  # fmt: skip


@pytest.mark.parametrize(("suffix", "text", "line", "word"), REFUSED)
def test_refused_by_line(tmp_path, suffix, text, line, word):
    """A pose that is not known any more, moves that would be lost, a number in the wrong unit."""
    with pytest.raises(ReadError, match=word) as bad:
        read(tmp_path, suffix, text)
    assert bad.value.line == line


READ = [
    (".script", script("P=p[0.001,0.002,0.003,3.14159265,0,0]", "L=[P,P]", MOVEJ, "movel(L[1])"), [1, 2, 3]),
    (".script", script("P=p[0.001,0.002,0.003,3.1,0,0]", MOVEJ, "movel(p[P[0],P[1],P[2]+0.05,P[3],P[4],0])"),
     [1, 2, 53]),
    (".script", script("P=p[0,0,0,3.1,0,0]", MOVEJ, "go()", MOVEL, before="def go():\n  local P=p[0,0,1,0,0,0]\nend\n"),
     [0, 0, 0]),
    (".mod", module("SpindleOn y;", "Spin c;", "x:=c;", "PDispOff;", "EOffsOff;", "IDelete i1;", "WorldAccLim\\Off;"),
     [2, 2, 3]),
    (".src", source("Q=P", declared="DECL INT I,J\nDECL FRAME P,Q\nREAL A[2,3], B"), [1, 2, 3]),
    (".src", source("FOO(I)", "FOO(I)"), [1, 2, 3]),
    (".apt", "UNITS/MM\nRAPID\nGOTO/0,0,$ a comment\n50\nFEDRAT/9,MMPM\nGOTO/1,2,3\nPPRINT/A, $ 5\nFINI\n", [1, 2, 3]),
    (".nc", "%\n:1001 (ISO)\nG21 G90 G15 G50 G50.1 G67 G13.1\nG0 X0 Y0 Z5\nG05 P10000\nG08 P1\nG187 P3\nM19\nM88\n"
     "G09 G01 X1 Y2 Z3 F99\nG5 P0\nG187\nM89\nM30\n%\n", [1, 2, 3]),
    (".nc", "%\nO2001\nG21 G90\nG0 X0 Y0 Z5\nG1 X1 Y2 Z3 F99\nM99\n%\n", [1, 2, 3]),
]  # fmt: skip


@pytest.mark.parametrize(("suffix", "text", "last"), READ)
def test_read(tmp_path, suffix, text, last):
    path = read(tmp_path, suffix, text)
    assert len(path) == 2
    np.testing.assert_allclose(path.position[-1] * 1e3, last, atol=1e-9)
