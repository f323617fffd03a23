"""The page of the words is that of the readers' tables, and the readers do with the words what it says."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from docs.make_words import PAGE, page
from tests.contracts.languages.inform import CUT, GO, job
from tests.contracts.languages.val3 import SET, program
from tests.contracts.samples import to_read
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.interpreting.vocabulary import HONOURED, REFUSED, REMARK, SETTING, Vocabulary
from toolpaths.languages import table


def test_the_page_is_current() -> None:
    """Else: python -m docs.make_words."""
    assert PAGE.read_text(encoding="utf-8") == page()


def test_a_word_stands_once() -> None:
    with pytest.raises(ValueError, match="'A' stands twice: honoured, refused"):
        Vocabulary({HONOURED: "A B", REFUSED: "C A"})
    assert all(language.vocabulary for language in table.READ)


def klartext(line: str) -> str:
    return f"BEGIN PGM A MM\nL X+0 Y+0 Z+5 R0 FMAX\nL Z-1 F300\n{line}\nL X+12.5 Y-3 F600\nEND PGM A MM\n"


DOWN, UPSIDE = "Y -3,Z 5,A 0,B 0,C 180", "-0.003,0.05,3.14159,0,0"
#: A line between two moves.
PROGRAMS: dict[str, Callable[[str], str]] = {
    "gcode": lambda line: f"G21 G90 G94\nG0 X0 Y0 Z5\nG1 Z-1 F300\n{line}\nG1 X12.5 Y-3\nG0 Z5\nM30\n",
    "apt": lambda line: f"UNITS/MM\nFEDRAT/MMPM,300\nGOTO/0,0,5\nGOTO/0,0,-1\n{line}\nGOTO/12.5,-3,-1\nFINI\n",
    "siemens": lambda line: f"G710 G90\nG0 X0 Y0 Z5\nG1 Z-1 F300\n{line}\nG1 X12.5 Y-3\nM30\n",
    "heidenhain": klartext,
    "inform": lambda line: job(GO, CUT, line, "MOVL C00002 V=7.5"),
    "val3": lambda line: program(*SET, line, "movel(pa,t,m)"),
    "krl": lambda line: f"DEF P()\n$VEL.CP=0.02\nPTP {{X 0,{DOWN}}}\n{line}\nLIN {{X 12.5,{DOWN}}}\nEND\n",
    "urscript": lambda line: f"def p():\n  movej(p[0,{UPSIDE}])\n  {line}\n  movel(p[0.0125,{UPSIDE}],v=0.02)\nend\n",
}
#: How a word stands in a line; those that are not here stand alone.
SPELLED: dict[str, Callable[[str, str], str]] = {
    "gcode": lambda word, done: {
        "G5": "G5 P10000", "G5.1": "G5.1 Q1", "G10": "G10 L2 P1 X0 Y0 Z0", "G43": "G43 H1", "G187": "G187 P3 E0.01",
        "G4": "G4 P1",
        "G28": "", "G30": "", "G53": "",
    }.get(word, word),
    "apt": lambda word, done: {
        "$$": "$$ remark", "GOHOME": "", "PARTNO": "", "SETUP": "", "CALSUB": "CALSUB/START_PROG",
    }.get(word, f"{word}/1" if word in ("INTOL", "OUTTOL", "SEQNO", "DELAY") else word),
    "siemens": lambda word, done: {"G4": "G4 F1", "G53": "", "G74": "", "G75": "", "G153": ""}.get(
        word, f"{word}1" if word.endswith("=") else f"{word}(1)" if done == REMARK else word),
    "inform": lambda word, done: word + {"CALL": " JOB:A"}.get(word, " 1" if word[0].isalpha() else ""),
    "val3": lambda word, done: "" if "=" in word or word in NESTED else f"{word}()" if word[0].isalpha() else word,
    "heidenhain": lambda word, done: "" if word in PLACES or word[:3] in ("CYC", "FN ") else word,
    "krl": lambda word, done: {
        "$OUT=": "$OUT[1]=TRUE", "$ANOUT=": "$ANOUT[1]=0.5", ";": "; remark", "&": "",
    }.get(word, f"{word} 1"),
    "urscript": lambda word, done: f"{word}()" if re.fullmatch(r"\w+", word) and word not in STATEMENTS else "",
}  # fmt: skip
_NESTED = "if elseIf else endIf while endWhile for endFor do until switch case default break endSwitch appro begin end"
NESTED, STATEMENTS = _NESTED.split(), ("while", "if", "thread", "run", "kill", "join")
PLACES = ("any other", "M91", "M92", "M140", ";")


def lines() -> list[tuple[str, str, str]]:
    """Language, what is done, line."""
    return [
        (name, done, line)
        for name in PROGRAMS
        for vocabulary in table.LANGUAGES[name].vocabulary.values()
        for word, done in vocabulary.items()
        if done != HONOURED and (line := SPELLED[name](word, done))
    ]


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_readers_do_what_it_says(tmp_path: Path, name: str) -> None:
    """Settings and remarks change no pose, and remarks are there; what is refused is refused in its line."""
    plain = PROGRAMS[name]("")
    expected, at = read_toolpath(to_read(tmp_path, name, plain)), 0
    wrong = []
    for language, done, line in lines():
        if language != name:
            continue
        text = PROGRAMS[name](line)
        at = next(k for k, (a, b) in enumerate(zip(text.split("\n"), plain.split("\n"), strict=False), 1) if a != b)
        try:
            path = read_toolpath(to_read(tmp_path, name, text))
        except ReadError as refusal:
            if done != REFUSED or refusal.line not in (at, None):
                wrong.append((line, done, str(refusal)[-120:]))
            continue
        same = path.position.shape == expected.position.shape and np.array_equal(path.position, expected.position)
        said = [e for e in path.events if e.line == at]
        if done == REFUSED or not same or (done == REMARK and not said):
            wrong.append((line, done, f"read; {len(path)} poses, {said}"))
    assert wrong == []


def test_the_test_has_words_of_every_kind() -> None:
    kinds = {(name, done) for name, done, _ in lines()}
    assert {name for name, done in kinds if done == REMARK} == set(PROGRAMS)
    assert len({name for name, done in kinds if done == SETTING}) >= 4
