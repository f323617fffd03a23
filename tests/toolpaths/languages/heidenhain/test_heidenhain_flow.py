"""Q parameters, labels, repeats, jumps and programs beside of Klartext."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.read_text import ends, read_text
from toolpaths.errors import ReadError
from toolpaths.toolpath import Toolpath

read = partial(read_text, "part.h")


def program(text: str) -> str:
    return f"BEGIN PGM A MM\nL X+0 Y+0 Z+0 R0 FMAX\nL F600\n{text}\nEND PGM A MM\n"


def x_of(path: Toolpath) -> list[float]:
    """Where X goes behind the first pose, mm."""
    return np.round(ends(path)[1:, 0], 9).tolist()  # type: ignore[no-any-return]


VALUES = {
    "FN 0: Q1 = +5\nL X+Q1": 5,
    "FN 0: Q1 = +5\nL X-Q1": -5,
    "FN 1: Q1 = +5 + -2\nL X+Q1": 3,
    "FN 2: Q1 = +10 - +5\nL X+Q1": 5,
    "FN 3: Q2 = +3 * +3\nL X+Q2": 9,
    "FN 4: Q4 = +8 DIV +2\nL X+Q4": 4,
    "FN 5: Q20 = SQRT +4\nL X+Q20": 2,
    "FN 6: Q20 = SIN +30\nL X+Q20": 0.5,
    "FN 7: Q20 = COS +60\nL X+Q20": 0.5,
    "FN 8: Q10 = +3 LEN +4\nL X+Q10": 5,
    "FN 13: Q20 = +10 ANG +10\nL X+Q20": 45,
    "FN0:Q01=5\nL X+Q1": 5,
    "Q1 = 5 * ( 2 + 3 ) - 4 / 2\nL X+Q1": 23,
    "Q1 = 2 ^ 3 * 2\nL X+Q1": 16,
    "Q1 = SIN 30 * 10 + COS 60\nL X+Q1": 5.5,
    "Q2 = -4\nQ1 = ABS Q2 + NEG Q2 + SQRT 16 + SQ 3\nL X+Q1": 21,
    "Q1 = INT 2,7 + FRAC 2.75 + SGN -3\nL X+Q1": 1.75,
    "Q1 = ASIN 0.5 + ACOS 0.5 + ATAN 1\nL X+Q1": 135,
    "Q1 = LN EXP 2 + LOG 100\nL X+Q1": 4,
    "Q1 = 17 % 5\nL X+Q1": 2,
    "QL1 = 5\nQR2 = QL1 + 1\nL X+QR2": 6,
    "Q1 = PI\nL X+Q1": 3.141592654,
}


@pytest.mark.parametrize("text", VALUES)
def test_values(tmp_path: Path, text: str) -> None:
    assert x_of(read(tmp_path, program(text))) == [VALUES[text]]


FLOW = {
    "REP": "LBL 1\nL IX+1\nCALL LBL 1 REP 2\nL IX+10 : 1 2 3 13",
    "REP as older controls print it": "LBL 1\nL IX+1\nCALL LBL 1 REP 2/2 : 1 2 3",
    "REP 0": "LBL 1\nL IX+1\nCALL LBL 1 REP 0 : 1",
    "REP in REP": "LBL 1\nL IX+10\nLBL 2\nL IX+1\nCALL LBL 2 REP 1\nCALL LBL 1 REP 1 : 10 11 12 22 23 24",
    "a subprogram": 'L IX+1\nCALL LBL 5\nCALL LBL "Name"\nL IX+1 M30\nLBL 5\nL IX+10\nLBL 0\n'
    'LBL "Name"\nL IX+100\nLBL 0 : 1 11 111 112',
    "a subprogram in one": "CALL LBL 1\nL M30\nLBL 1\nL IX+1\nCALL LBL 2\nL IX+3\nLBL 0\nLBL 2\nL IX+2\nLBL 0 : 1 3 6",
    "a subprogram again": "LBL 1\nCALL LBL 2\nCALL LBL 1 REP 1\nL M2\nLBL 2\nL IX+1\nLBL 0 : 1 2",
    "a jump": "FN 9: IF +1 EQU +1 GOTO LBL 3\nL X+1\nLBL 3\nL X+2 : 2",
    "no jump": "FN 10: IF +1 NE +1 GOTO LBL 3\nL X+1\nLBL 3\nL X+2 : 1 2",
    "a loop": "Q1 = 0\nLBL 3\nQ1 = Q1 + 1\nL X+Q1\nFN 12: IF +Q1 LT +3 GOTO LBL 3 : 1 2 3",
    "greater": 'Q1 = 7\nFN 11: IF +Q1 GT +3 GOTO LBL "OUT"\nL X+1\nLBL "OUT"\nL X+2 : 2',
}


@pytest.mark.parametrize("name", FLOW)
def test_flow(tmp_path: Path, name: str) -> None:
    text, _, expected = FLOW[name].rpartition(" : ")
    assert x_of(read(tmp_path, program(text))) == [float(v) for v in expected.split()]


def test_a_label_that_is_not_called_is_named(tmp_path: Path) -> None:
    path = read(tmp_path, program("L X+1 M30\nLBL 5\nL X+99\nLBL 0"))
    assert ("LBL 5 is not called", 5) in [(e.word, e.line) for e in path.events]


def test_a_program_beside(tmp_path: Path) -> None:
    """Whatever folders its name has; poses carry the line of the call, its labels are its own, its parameters not."""
    (tmp_path / "Op1.H").write_text(
        "BEGIN PGM OP1 MM\nL X+1\nLBL 1\nL IX+Q5\nCALL LBL 1 REP 1\nCALL LBL 2\nFN 9: IF +0 EQU +0 GOTO LBL 9\n"
        "LBL 2\nL Y+7\nLBL 0\nLBL 9\nEND PGM OP1 MM\n"
    )
    path = read(tmp_path, program("Q5 = 3\nCALL PGM OP1\nLBL 1\nCALL PGM TNC:\\PARTS\\OP1.H\nL X+0"))
    assert x_of(path) == [1, 4, 7, 7, 1, 4, 7, 7, 0]
    assert path.line.tolist() == [2, *[5] * 4, *[7] * 4, 8]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("L X+1 RL", r"OP1\.H:2: RL: cutter compensation"),
        ("L X+1 M30", r"OP1\.H:2: M30 in a program that is called"),
        ("CALL PGM OP1", "call each other more than 20 deep"),
    ],
)
def test_what_a_program_beside_may_not(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "OP1.H").write_text(f"BEGIN PGM OP1 MM\n{text}\nEND PGM OP1 MM\n")
    with pytest.raises(ReadError, match=told):
        read(tmp_path, program("CALL PGM OP1"))


def test_a_program_beside_in_another_unit(tmp_path: Path) -> None:
    (tmp_path / "OP1.H").write_text("BEGIN PGM OP1 INCH\nL X+1\nEND PGM OP1 INCH\n")
    with pytest.raises(ReadError, match="a program in another unit"):
        read(tmp_path, program("CALL PGM OP1"))


REFUSED = {
    "L X+Q7": (4, "Q7, which has no value in the file"),
    "FN 18: SYSREAD Q7 = ID210 NR4 IDX3\nL X+Q7": (5, "Q7, which FN 18 (line 4) sets"),
    "FN 23: Q20 = CDATA Q30\nL X+Q22": (5, "Q22, which FN 23 (line 4) sets"),
    "FN 17: SYSWRITE ID 210 NR4 IDX3 = +5": (4, "FN 17: it writes into the control"),
    "FN 9: IF +Q7 EQU +1 GOTO LBL 1\nLBL 1": (4, "what runs depends on Q7"),
    "FN 9: IF +1 EQU +1 GOTO LBL 1": (4, "LBL 1: there is no such label"),
    "FN 4: Q1 = +1 DIV +0": (4, "has no value"),
    "FN 2: Q1 = +1 + +1": (4, "FN 2 with +"),
    "Q1 = ( 5": (4, ""),
    "Q1 = SQRT -1": (4, "SQRT of -1.0 has no value"),
    "Q1 = 5 5": (4, "is not expected here"),
    "CALL LBL 1": (4, "LBL 1: there is no such label"),
    "CALL LBL 1 REP X\nLBL 1": (4, "a number is expected"),
    "LBL 1\nCALL LBL 1 REP -1": (5, "a whole number"),
    "CALL LBL 1\nL X+1 M30\nLBL 1\nCALL LBL 1\nLBL 0": (7, "more than 20 deep"),
    "LBL 1\nL IX+0.001\nCALL LBL 1 REP 65534\nCALL LBL 1 REP 65534": (5, "runs too many blocks"),
    "CALL LBL 1\nM30\nLBL 1\nL X+1": (8, "its LBL 0 is missing"),
    "CALL PGM OTHER": (4, "there is no OTHER.H of Klartext beside"),
    "CALL PGM A.I": (4, "there is no A.I of Klartext beside"),
}


def test_a_loop_that_runs_twice_with_the_same_parameters_is_none_without_end(tmp_path: Path) -> None:
    """A subprogram with a loop, called twice: where it jumps, everything is as it was in the first call."""
    loop = "LBL 5\nQ1 = 0\nLBL 6\nQ1 = Q1 + 1\nL IX+2.5\nFN 12: IF +Q1 LT +3 GOTO LBL 6\nLBL 0"
    path = read(tmp_path, program(f"CALL LBL 5\nCALL LBL 5\nL X+1 M30\n{loop}"))
    assert x_of(path) == [2.5, 5, 7.5, 10, 12.5, 15, 1]
    with pytest.raises(ReadError, match="a loop that never ends"):
        read(tmp_path, program(f"CALL LBL 5\nL X+1 M30\n{loop.replace('Q1 + 1', '1')}"))


@pytest.mark.parametrize("text", REFUSED)
def test_refused(tmp_path: Path, text: str) -> None:
    line, told = REFUSED[text]
    with pytest.raises(ReadError) as caught:
        read(tmp_path, program(text))
    assert told in str(caught.value) and caught.value.line == line
