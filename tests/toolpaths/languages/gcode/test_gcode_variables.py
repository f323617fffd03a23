"""Variables and expressions of G-code: numbers where they are constant, refused where only the machine knows them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.linuxcnc import check, installed, reference
from tests.oracles.random_variables import RandomFormulas
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.gcode.variables import Variables
from toolpaths.toolpath import Toolpath

HEAD = "G21 G90 G17\nF600\nG0 X0 Y0 Z0\n"


def read(tmp_path: Path, text: str) -> Toolpath:
    file = tmp_path / "part.nc"
    file.write_text(HEAD + text + "\nM30\n")
    return read_toolpath(file)


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1.5+2*3", 7.5), ("2**3**2", 64), ("-2**2", 4), ("7 MOD 4", 3), ("-1 MOD 4", 3), ("ATAN[1]/[-1]", 135),
        ("ATAN[1]", 45), ("ROUND[-2.5]", -3), ("FIX[-1.2]", -2), ("FUP[-1.2]", -1), ("[[2]]", 2), ("6/4/3", 0.5),
        ("SQRT[16]-ABS[-1]", 3), ("LN[EXP[1.25]]", 1.25), ("#1", 2.5), ("-#1", -2.5), ("#[1+1]", -4), ("#<a b>", 9),
        ("ACOS[0]", 90), ("ASIN[1]", 90), ("COS[60]", 0.5), ("TAN[45]", 1), ("SIN[30]", 0.5), ("#-#3", 2.5),
    ],
)  # fmt: skip
def test_expressions(expression: str, value: float) -> None:
    variables = Variables()
    assert variables.block("#1=2.5 #2 = -4").strip() == ""
    variables.block("#3=-1 #<A B>=9")
    assert float(variables.block(f"X[{expression.upper()}]")[1:]) == pytest.approx(value, abs=1e-11)


def test_a_block_sees_the_values_of_before(tmp_path: Path) -> None:
    path = read(tmp_path, "#1=1\n#1=5 #2=#1\nG1 X#1 Y#2")
    np.testing.assert_allclose(path.position[-1] * 1e3, (5, 1, 0))


def test_parameters_with_r(tmp_path: Path) -> None:
    path = read(tmp_path, "R1=10 R2=-1.5\nG1 X=R1+1 Z=R2\nY=2*R1")
    np.testing.assert_allclose(path.position[-1] * 1e3, (11, 20, -1.5))
    np.testing.assert_allclose(read(tmp_path, "G2 X10 R5").position[-1] * 1e3, (10, 0, 0), atol=1e-9)


def test_words_that_are_computed(tmp_path: Path) -> None:
    path = read(tmp_path, "#1=600 #2=1\nG#2 X10 F#1\nT[#2+2]\nG0 Z5")
    assert path.feed[1] == pytest.approx(0.01)
    assert path.tool[-1] == 3


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("G1 X#101", 4, "#101: a variable that no line before it sets"),
        ("G1 X#<depth>", 4, "#<depth>: a variable that no line before it sets"),
        ("#1=#5021", 4, "#5021: a variable of the controller"),
        ("#3000=1", 4, "a variable of the controller is set"),
        ("#1=5\n#1", 5, "without a letter"),
        ("G1 X[1+]", 4, "']' where a number"),
        ("G1 X[1 2]", 4, "where ']' is expected"),
        ("G1 X[1/0]", 4, "division by zero"),
        ("G1 X[1 MOD 0]", 4, "division by zero"),
        ("G1 X[SQRT[-1]]", 4, "no value"),
        ("G1 X[0**-1]", 4, "no value"),
        ("G1 X[9**9**9]", 4, "beyond"),
        ("G1 X[#1 EQ 2]", 4, "no line before it sets"),
        ("#1=1\nG1 X[#1 EQ 2]", 5, "'EQ 2]' where ']' is expected"),
        ("G1 X" + "[" * 40 + "1" + "]" * 40, 4, "brackets more than 30 deep"),
        ("#1=1\nG1 X" + "#" * 40 + "1", 5, "brackets more than 30 deep"),
        ("#1.5=2", 4, "a whole number from 1 on"),
        ("#<>=2", 4, "without a name"),
        ("WHILE [#1 LT 5] DO1", 4, "macro statement"),
        ("R1=R2", 4, "R2: a variable that no line"),
    ],
)
def test_what_is_not_constant_is_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(ReadError, match=re.escape(words)) as caught:
        read(tmp_path, text)
    assert caught.value.line == line


@installed
@pytest.mark.parametrize("first", [0, 20, 40])
def test_random_formulas_agree(tmp_path: Path, first: int) -> None:
    agreed = 0
    for seed in range(first, first + 20):
        file = tmp_path / f"{seed}.ngc"
        file.write_text(RandomFormulas(seed).text)
        try:
            ref = reference(file)
        except ReadError:
            with pytest.raises(ReadError):
                read_toolpath(file)
            continue
        check(read_toolpath(file), ref, 1.5e-4)
        agreed += 1
    assert agreed >= 18
