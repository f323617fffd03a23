"""What a file asks of the machine, in every robot language: where the lines stand, the halt, the tool, the list."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.contracts.samples import to_write
from tests.oracles.sample_programs import SPINDLE, changed, small
from toolpaths.files import read_back, write_program
from toolpaths.languages.table import WRITTEN
from toolpaths.toolpath import MachineCommand
from toolpaths.writing.blending import stops
from toolpaths.writing.program import Order, Program

#: Language -> a joint move, a straight move, what halts the arm, and the tool of the second half.
MOVES = {
    "rapid": (r"MoveAbsJ", r"MoveL", r"Stop;", r"PART1_t2"),
    "krl": (r"PTP", r"LIN", r"HALT", r"\$TOOL="),
    "fanuc": (r"\d:J P", r"\d:L P", r"PAUSE", r"UTOOL\[9\]="),
    "urscript": (r"movej\(", r"movel\(", r"popup\(", r"set_tcp\("),
    "val3": (r"movej\(", r"movel\(", r"get\(\)", r"tTool2\[0\]"),
    "inform": (r"MOVJ C", r"MOVL C", r"PAUSE", None),
}
ROBOTS = [language.name for language in WRITTEN if language.name in MOVES]


def program(*orders: Order) -> Program:
    """Tool 1 for four poses, tool 2 for four more; every order has its comment."""
    return changed(
        small(), tool=np.array([1] * 4 + [2] * 4, dtype=np.int32), tools={1: SPINDLE, 2: SPINDLE}, orders=orders,
        comments=tuple((o.pose, o.text) for o in orders),
    )  # fmt: skip


def order(pose: int, word: str, *lines: str, given: bool = True, **values: float) -> Order:
    return Order(pose, MachineCommand(word, values), 10 + pose, f"{word} of {pose}", lines if given else None)


JOB = (
    order(0, "M3", "ON 1", "ON 2"), order(2, "M8", given=False), order(4, "M5", "OFF 1"),
    order(4, "M6", given=False, T=2.0), order(4, "M3", "ON 3"), order(6, "M0", given=False), order(8, "M5", "OFF 2"),
)  # fmt: skip


def said(path: Path) -> str:
    text = path.read_text()
    return text[text.index("/MN") : text.index("/POS")] if path.suffix == ".ls" else text


def test_all_robot_languages_are_here() -> None:
    assert set(ROBOTS) == set(MOVES) == {lang.name for lang in WRITTEN if lang.name not in ("csv", "gcode")}


@pytest.mark.parametrize("name", ROBOTS)
def test_lines_stand_where_the_file_has_them(tmp_path: Path, name: str) -> None:
    """Before the way to the start, in the file's order around a tool change, behind the last move."""
    joint, line, halt, tool = MOVES[name]
    path = to_write(tmp_path, name)
    written = write_program(program(*JOB), path)
    text = said(path)
    words = rf"ON \d|OFF \d|{halt}|mount tool 2|{joint}|{line}" + (rf"|{tool}" if tool and name != "val3" else "")
    found = [m[0] for m in re.finditer(words, text)]
    found = found[found.index("ON 1") :]
    kinds = ["J" if re.fullmatch(joint, f) else "L" if re.fullmatch(line, f) else f for f in found]
    if name == "rapid":
        kinds = [k for k in kinds if k != "PART1_t2"]  # the tool is an argument of the moves
    change = ["mount tool 2", re.sub(r"\\", "", halt)][:: -1 if name == "urscript" else 1]
    change += [re.sub(r"\\", "", tool)] if tool and name not in ("rapid", "val3") else []
    starts = ["J"] * (1 if name == "inform" else 2)  # a job has no [start]
    begin, end = ["ON 1", "ON 2", *starts, "L", "L", "L", "L", "OFF 1"], ["ON 3", "J", "L", "L"]
    assert kinds == [*begin, *change, *end, re.sub(r"\\", "", halt), "L", "L", "OFF 2"]
    np.testing.assert_allclose(read_back(path).position, program().position, atol=1e-6)
    assert len(written.findings) and text.count("M8 of 2") == 1


@pytest.mark.parametrize("name", ROBOTS)
def test_a_mounted_tool_is_reached_by_a_joint_move(tmp_path: Path, name: str) -> None:
    """Lines for M6 take the place of the halt, also where the number of the tool stays."""
    joint, line, halt, _ = MOVES[name]
    path = to_write(tmp_path, name)
    write_program(program(order(4, "M6", "CHANGE", T=2.0), order(6, "M6", "AGAIN", T=2.0)), path)
    found = [m[0] for m in re.finditer(rf"CHANGE|AGAIN|{halt}|{joint}|{line}", said(path))]
    kinds = ["J" if re.fullmatch(joint, f) else "L" if re.fullmatch(line, f) else f for f in found]
    at = kinds.index("CHANGE")
    assert kinds[at:] == ["CHANGE", "J", "L", "L", "AGAIN", "J", "L", "L"]
    assert not [k for k in kinds if re.fullmatch(halt, k)]


def test_the_arm_stands_before_what_is_done() -> None:
    """Nothing is switched on the fly; what has no lines halts nobody."""
    assert np.flatnonzero(stops(program(*JOB))).tolist() == [0, 3, 4, 5, 7]
    assert np.flatnonzero(stops(program(order(2, "M8", given=False), order(6, "M9")))).tolist() == [0, 3, 4, 7]


@pytest.mark.parametrize("language", [language for language in WRITTEN], ids=lambda language: language.name)
def test_what_a_language_cannot_say_is_listed(tmp_path: Path, language: object) -> None:
    """By line, once; what has lines, if only none, is not; a halt and the tool are the language's own."""
    name = language.name  # type: ignore[attr-defined]
    asked = [
        order(1, "M3", given=False, S=900.0), order(2, "CLAMP", given=False), order(3, "M0", given=False),
        order(4, "M6", given=False, T=2.0), order(5, "M3", given=False), order(6, "M9"),
        order(7, "T", given=False, T=3.0),
    ]  # fmt: skip
    found = write_program(program(*asked), to_write(tmp_path, name)).findings
    listed = [f for f in found if "no words of its own" in f.what]
    if name == "csv":
        assert listed == []
        return
    (finding,) = listed
    words, lines = ("CLAMP", (12,)) if name == "gcode" else ("M3, CLAMP", (11, 12, 15))
    assert f"for {words}:" in finding.what and finding.lines == lines and finding.count == len(lines)
    assert finding.level == "warning" and "[program.events]" in finding.remedy


def test_gcode_says_them_as_words(tmp_path: Path) -> None:
    """In the order of the file: a tool change stops the spindle, so M3 comes behind it."""
    asked = [
        order(0, "M6", given=False, T=1.0), order(0, "M3", given=False, S=9000.0), order(2, "M8", given=False),
        order(4, "M6", given=False, T=2.0), order(4, "M4", given=False, S=700.5), order(5, "G4", given=False, P=1.5),
        order(6, "M1", given=False), order(8, "M5", given=False),
    ]  # fmt: skip
    path = to_write(tmp_path, "gcode")
    write_program(program(*asked), path)
    lines = path.read_text().split("\n")
    words = [s for s in lines if re.fullmatch(r"(?:S\S+ )?M\d+|T\d M6|G43\.4 H\d|G4 P.*|G49", s)]
    assert words == ["T1 M6", "S9000 M3", "G43.4 H1", "M8", "G49", "T2 M6", "G43.4 H2", "S700.5 M4", "G4 P1.5", "M1",
                     "M5", "G49", "M30"]  # fmt: skip
