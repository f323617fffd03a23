"""M98 and M99 in one file: the blocks in the order in which they run, as LinuxCNC has it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.linuxcnc import check, installed, reference
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

MAIN = "%\nO1 (MAIN)\nG21 G90 G17\nF600\nG0 X0 Y0 Z5\nM98 P100 L3\nG90 G0 Z5\nM30\n"
SUB = "O100\nG91 G1 X1 Z-1\nM98 P200\nM99\nO200\nY2\nM99\n%\n"


def test_calls_run_in_order(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text(MAIN + SUB)
    path = read_toolpath(tmp_path / "a.nc")
    assert path.line.tolist() == [5, *([10, 14] * 3), 7]
    np.testing.assert_allclose(path.position[-2] * 1e3, (3, 6, 2))
    assert [e.word for e in path.events if "M98" in e.word] == ["M98 P100 L3", *["M98 P200"] * 3]


@pytest.mark.parametrize("call", ["M98 P100 L3", "M98 P30100", "M98 P0100 L3", "G91 M98 P100 L3"])
def test_spellings_of_a_call(tmp_path: Path, call: str) -> None:
    (tmp_path / "a.nc").write_text((MAIN + SUB).replace("M98 P100 L3", call))
    assert len(read_toolpath(tmp_path / "a.nc")) == 8


def test_a_move_in_the_block_comes_before_the_call(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_text((MAIN + SUB).replace("M98 P100 L3", "G1 X7 M98 P100"))
    path = read_toolpath(tmp_path / "a.nc")
    np.testing.assert_allclose(path.position[:3, 0] * 1e3, (0, 7, 8))


@installed
def test_linuxcnc_agrees(tmp_path: Path) -> None:
    (tmp_path / "a.ngc").write_text(MAIN + SUB)
    check(read_toolpath(tmp_path / "a.ngc"), reference(tmp_path / "a.ngc"), 1e-4)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (MAIN + SUB.replace("P200", "P300"), 11, "O300 is not in this file"),
        (MAIN + SUB.replace("P200", "P100"), 11, "more than 10 deep"),
        (MAIN + SUB.replace("Y2\nM99", "Y2\nM30"), 15, "M30 in a program that another one calls"),
        (MAIN + SUB.replace("Y2\nM99\n", "Y2\n"), 14, "O200 ends without M99"),
        (MAIN + SUB.replace("Y2\nM99", "Y2\nM99\nX5"), 16, "words after the end"),
        (MAIN + SUB.replace("Y2\nM99", "Y2\nM99 P5"), 15, "P5: read only with"),
        (MAIN + SUB.replace("O200", "O100"), 13, "O100 stands twice, first in line 9"),
        (MAIN + SUB + "O300\nM99\n", 17, "O300: a second program, which the first does not call"),
        (MAIN.replace("L3", "L0") + SUB, 6, "L0: a whole number"),
        (MAIN.replace("P100 L3", "") + SUB, 6, "M98 without P"),
        (MAIN.replace("P100", "P1.5") + SUB, 6, "P1.5: the number of a program"),
        (MAIN.replace("M30", "M30\nX1") + SUB, 9, "words after the end"),
        (MAIN.replace("M98", "M97") + SUB, 6, "M97: a subprogram in another file, or from a line number on"),
        (MAIN.replace("L3", "L9999") + SUB.replace("Y2", "M98 P300").replace("%", "O300\n" + "Y2\n" * 99 + "M99"),
         24, "too many blocks"),
    ],
)  # fmt: skip
def test_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    (tmp_path / "a.nc").write_text(text)
    with pytest.raises(ReadError, match=re.escape(words)) as caught:
        read_toolpath(tmp_path / "a.nc")
    assert caught.value.line == line
