"""Over every language that is written: names and remarks cannot break a program; findings are listed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.contracts.samples import WRITTEN, to_write
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small
from tests.oracles.vendor_moves import OTHER, READERS, moves_of
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.finding import ERROR, WARNING, Finding, merged
from toolpaths.languages.table import LANGUAGES

# --- names and characters ---------------------------------------------------------------------------------

NAMES = [
    "1110_wall", "a-b", "a b", "größe", "a" * 40, "a" * 300, "", "_", "if", "LIN", "MoveL", "END", "main", "tool",
    "a;b", 'a"b', "a'b", "a\nb", "a\\b", "a/b", "]]>", "名前", "a" * 24, "A.B",
]  # fmt: skip


@pytest.mark.parametrize("language", READERS)
@pytest.mark.parametrize("name", NAMES)
def test_program_names_become_legal_or_are_refused(language, name, tmp_path):
    """The reader of the language takes what is written, or the finding says which name and what to do."""
    p = changed(small(), name=name)
    try:
        assert len(moves_of(p, to_write(tmp_path, language))) == 8
    except WriteError as e:
        assert "name" in str(e) and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("language", READERS)
@pytest.mark.parametrize("stem", [n for n in NAMES if n and "/" not in n and "\n" not in n and len(n) < 200])
def test_file_names_are_legal_or_are_refused(language, stem, tmp_path):
    try:
        written = write_program(small(), to_write(tmp_path, language, stem))
    except WriteError as e:
        assert f"{stem}{LANGUAGES[language].writes}" in str(e) and "name" in str(e) and list(tmp_path.iterdir()) == []
    else:
        assert len(READERS[language](list(written.files))) == 8


@pytest.mark.parametrize(
    ("language", "stem"), [(name, stem) for name, sample in WRITTEN.items() for stem in sample.no_names]
)
def test_file_names_that_are_no_names_of_the_language(language, stem, tmp_path):
    with pytest.raises(WriteError, match=WRITTEN[language].no_name):
        write_program(small(), to_write(tmp_path, language, stem))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("language", [name for name, sample in WRITTEN.items() if sample.longest[0]])
def test_longest_names(language, tmp_path):
    """A program that is split needs room for the numbers of its parts."""
    alone, split = WRITTEN[language].longest
    files = write_program(small(), to_write(tmp_path, language, "a" * alone)).files
    assert len(READERS[language](list(files))) == 8
    with pytest.raises(WriteError, match=f"at most {split} characters"):
        write_program(random_program(5001, 1), to_write(tmp_path, language, "a" * (split + 1)))


@pytest.mark.parametrize("language", READERS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(max_size=120), other=st.text(max_size=60))
def test_texts_cannot_become_instructions(language, text, other, tmp_path):
    """Whatever stands in a comment, a source's, a robot's or a tool's name: the moves are the same eight."""
    program = changed(
        small(), comments=((0, text), (4, other)), source=other, robot=text, tools={1: replace(SPINDLE, name=text)}
    )
    assert len(moves_of(program, to_write(tmp_path, language))) == 8


HOSTILE = [
    "x\r\nHALT\r\nEND", 'x"); movel(p', "]]></Code>", "'\r\nPAUSE", "! x\nStop;", "; x\nLIN {X 0}", "end\nmovel(",
    "\x00\x1a", ";\n   1:L P[1] 10mm/sec FINE", "%s %d {0}", "\\", "\u2028END", "*/", "-->", 'x\r\n  EXIT; ! "',
    "x ;\r\n  CALL BAD ; and some more words " + "y" * 60, "a\n;PAUSE", "a\nget()", "x\r\nresetMotion() ]]></Code>",
    "x\r\nPAUSE\r\nEND", "N\r\nEND", "a\npopup()",
]  # fmt: skip


@pytest.mark.parametrize("language", READERS)
@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts(language, text, tmp_path):
    program = changed(
        small(), comments=((0, text), (4, text)), source=text, robot=text, tools={1: replace(SPINDLE, name=text)}
    )
    written = write_program(program, to_write(tmp_path, language))
    files = list(written.files)
    assert len(READERS[language](files)) == 8
    (tmp_path / "plain").mkdir()
    plain = write_program(small(), to_write(tmp_path / "plain", language))
    assert OTHER[language](files) == OTHER[language](list(plain.files))


# --- findings ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", WRITTEN)
def test_one_error_refuses_the_whole_program(language, tmp_path):
    """Everything is listed: errors first, each with level, place and remedy, repeats as one."""
    said = (
        Finding(WARNING, "pose 1 (a.nc:2)", "close to a limit", "move the part"),
        Finding(ERROR, "pose 3 (a.nc:4)", "not reached", "move the part"),
        Finding(ERROR, "pose 5 (a.nc:6)", "not reached", "move the part", 2),
        Finding(ERROR, "tool 1", "not mounted"),
    )
    old = to_write(tmp_path, language)
    old.write_bytes(b"what was there")
    with pytest.raises(WriteError) as caught:
        write_program(changed(small(), findings=said), old)
    lines = str(caught.value).split("\n  ")
    assert lines[0].endswith("the program is refused:")
    assert lines[1] == "error: pose 3 (a.nc:4) (and 2 more places): not reached. move the part"
    assert lines[2] == "error: tool 1: not mounted"
    assert lines[3] == "warning: pose 1 (a.nc:2): close to a limit. move the part"
    assert {f.name: f.read_bytes() for f in tmp_path.iterdir()} == {old.name: b"what was there"}


@pytest.mark.parametrize("language", WRITTEN)
def test_warnings_do_not_refuse_and_come_back(language, tmp_path):
    said = (Finding(WARNING, "pose 1", "close", "look"), Finding(WARNING, "pose 2", "close", "look"))
    found = write_program(changed(small(), findings=said), to_write(tmp_path, language)).findings
    assert Finding(WARNING, "pose 1", "close", "look", 2) in found
    assert all(f.level == WARNING and f.place and f.what for f in found)


@pytest.mark.parametrize("language", READERS)
def test_a_language_s_own_errors_are_listed_with_a_remedy(language, tmp_path):
    with pytest.raises(WriteError, match=r"error: a robot: 7 joints: .*\. write CSV for this arm"):
        write_program(changed(small(), joints=np.zeros((8, 7)), start_joints=None), to_write(tmp_path, language))
    assert list(tmp_path.iterdir()) == []


def test_merging_keeps_levels_and_remedies_apart():
    a, b = Finding(ERROR, "pose 9", "x", "do"), Finding(WARNING, "pose 2", "x", "do")
    c = Finding(ERROR, "pose 4", "x", "do otherwise")
    assert merged([b, a, c, a, b, a]) == (replace(a, count=3), c, replace(b, count=2))
    far = merged([*merged([a, replace(a, place="pose 3")]), a, replace(a, place="pose 20")])
    assert far == (replace(a, count=4),) and far[0].places == ("pose 9", "pose 3", "pose 20")
