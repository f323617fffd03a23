"""Mutated and senseless APT/CL: only refusals, no hang, no memory that the file does not pay for; and the speed."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.oracles.patience import not_hanging
from tests.oracles.random_apt import RandomApt
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.apt import motion
from toolpaths.languages.apt.reader import AptReader
from toolpaths.languages.apt.words import EVENTS, PASSED, REFUSED

QUIET = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
ACTS = tuple(AptReader("").acts)
HEADS = (*ACTS, *sorted(EVENTS | PASSED)[:6], *sorted(REFUSED)[:6], "DRILL", "é", "")
MINOR = (
    *(
        "0",
        "1",
        "-2.5",
        "1D1",
        "1E999",
        "nan",
        "",
        "1e-300",
        "9" * 400,
        "OFF",
        "ON",
        "TOOL",
        "MM",
        "MMPM",
        "IPR",
        "RPM",
    ),
    *(
        "DRILL",
        "DEEP",
        "BORE",
        "FEDTO",
        "RAPTO",
        "RTRCTO",
        "AUTO",
        "INCR",
        "DWELL",
        "REV",
        "TIMES",
        "LEFT",
        "WORLD",
        "$",
    ),
    *("1,2,3", "0,0,1", "1,0,0,0,1,0", "0,0,0,0,0,1,1,1,1,1,1", "FEDTO,5,RAPTO,2", "INIT", "XYPLAN", "DEPTH,1,CLEAR,2"),
    *("(CIRCLE/0,2,3,1),ON,(LINE/0,2,3,0,3,3)", "(CIRCLE/0,2,3,1),ON,2,INTOF,(LINE/0,2,3,1,2,3)", "(", "),ON"),
)


def attempt(file: Path, text: str) -> bool:
    """Whether it is read; a refusal names the file, what is read is sound."""
    file.write_text(text, encoding="utf-8", errors="replace")
    try:
        path = read_toolpath(file, chord=1e-3)
    except ReadError as refusal:
        assert str(file) in str(refusal) and len(str(refusal)) < 1000
        assert refusal.line is None or 1 <= refusal.line <= text.count("\n") + 1
        return False
    assert np.isfinite(path.position).all() and (np.diff(path.row) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(path.axis, axis=1), 1, atol=1e-12)
    assert not (path.feed <= 0).any() and all(0 <= e.pose <= len(path) for e in path.events)
    return True


@QUIET
@given(seed=st.integers(0, 10**6), data=st.data())
def test_mutated_programs(tmp_path: Path, seed: int, data: st.DataObject) -> None:
    """Characters lost, doubled or changed, lines swapped or dropped, the end cut off."""
    text = RandomApt(seed).text()
    for _ in range(data.draw(st.integers(1, 5))):
        at, to = (data.draw(st.integers(0, len(text) - 1)) for _ in range(2))
        how = data.draw(st.integers(0, 4))
        if how == 0:
            text = text[:at] + text[at + 1 :]
        elif how == 1:
            text = text[:at] + data.draw(st.sampled_from("0-.,/$\n ED9")) + text[at + 1 :]
        elif how == 2:
            text = text[: max(at, 20)]
        else:
            lines = text.split("\n")
            a, b = at % len(lines), to % len(lines)
            lines[a], lines[b] = lines[b], lines[a] if how == 3 else lines[b]
            text = "\n".join(lines)
    attempt(tmp_path / "part.cls", text)


@QUIET
@given(data=st.data())
def test_words_in_senseless_order(tmp_path: Path, data: st.DataObject) -> None:
    statement = st.tuples(st.sampled_from(HEADS), st.lists(st.sampled_from(MINOR), max_size=6))
    lines = [f"{head}/{','.join(minor)}" for head, minor in data.draw(st.lists(statement, max_size=25))]
    good = ["UNITS/MM", "CUTTER/5,0", "RAPID", "GOTO/1,2,3", "FEDRAT/60,MMPM"]
    attempt(tmp_path / "part.apt", "\n".join([*good, *lines, "FINI", ""]))


@QUIET
@given(head=st.sampled_from(ACTS), minor=st.lists(st.sampled_from(MINOR) | st.text(max_size=8), max_size=8))
def test_every_word_with_senseless_minors(tmp_path: Path, head: str, minor: list[str]) -> None:
    text = f"UNITS/MM\nGOTO/1,2,3\nSPINDL/RPM,100\n{head}/{','.join(minor)}\nGOTO/4,5,6\nFINI\n"
    attempt(tmp_path / "part.apt", text)


def test_some_mutations_are_still_read(tmp_path: Path) -> None:
    """Else the tests above would see refusals only."""
    assert all(attempt(tmp_path / "p.cls", RandomApt(seed).text()) for seed in range(10))


def peak(file: Path) -> int:
    tracemalloc.start()
    try:
        read_toolpath(file)
    except ReadError:
        pass
    finally:
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    return most


@pytest.mark.parametrize(
    "text",
    [
        "UNITS/MM\n" + "GOTO/1,$\n" * 100_000,
        "UNITS/MM\nGOTO/" + "1" * 1_000_000 + ",2,3\nFINI\n",
        "UNITS/MM\nGOTO/" + "1," * 500_000 + "3\nFINI\n",
        "TOOL" + " " * 1_000_000 + "X\n",
        "$$-> CSYS / $\n" + "1,$\n" * 100_000,
        "(" * 1_000_000,
        "UNITS/MM\nCYCLE/DRILL," + "FEDTO,1," * 100_000 + "\n",
        "UNITS/MM\n" + "TOOL PATH/A\nEND-OF-PATH\n" * 10_000,
        "UNITS/MM\n" + "CYCLE/DRILL,FEDTO,1,RAPTO,1\n" * 5_000,
    ],
    ids=["continued", "digits", "numbers", "blanks", "comment", "brackets", "pairs", "paths", "cycles"],
)
def test_no_file_takes_long_or_much_memory(tmp_path: Path, text: str) -> None:
    (tmp_path / "part.cls").write_text(text)
    with not_hanging():
        assert peak(tmp_path / "part.cls") < 40e6 + 60 * len(text)


def test_pecks_of_many_holes_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion, "MOST_DRILLED", 5000)
    holes = "".join(f"GOTO/{x},0,0\n" for x in range(100))
    (tmp_path / "part.apt").write_text(f"UNITS/MM\nCYCLE/DEEP,FEDTO,300,RAPTO,0,INCR,2,MMPM,60\n{holes}FINI\n")
    with pytest.raises(ReadError, match="the cycles make more than 5000 poses") as caught:
        read_toolpath(tmp_path / "part.apt")
    assert 10 < caught.value.line < 20
