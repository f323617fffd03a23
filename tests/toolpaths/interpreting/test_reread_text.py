"""A text of many files, of which some are let go and read again: the same as one that is held whole."""

from __future__ import annotations

from pathlib import Path

import pytest

import toolpaths.interpreting.reread_text as reread_text
from toolpaths.errors import ReadError
from toolpaths.interpreting.program_text import LinkedText, ProgramText
from toolpaths.interpreting.reread_text import RereadText

TEXTS = ["MODULE Main\r\n  run_1;\r\nENDMODULE", "", "one two\n three\n", "Fo\xfcr;\nfive\n", "last"]


def linked(kind: type[LinkedText], folder: Path) -> LinkedText:
    """The texts as files of one program."""
    parts = []
    for k, text in enumerate(TEXTS):
        file = folder / f"part{k}.mod"
        file.write_bytes(text.encode("latin-1"))
        parts.append(ProgramText(text, str(file)))
    whole = kind(parts[0])
    for part in parts[1:]:
        whole.add(part)
        part.forget_text()
    return whole


def test_places_mean_the_same_whatever_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reread_text, "HELD", 50)
    whole, some = linked(LinkedText, tmp_path), linked(RereadText, tmp_path)
    assert some.length == whole.length == len("\n".join(TEXTS)) and some.begins == whole.begins
    for at in (*range(whole.length + 1), *range(whole.length, -1, -7)):
        k = whole.part(at)
        end = whole.begins[k] + len(TEXTS[k])
        assert some.piece(at, end) == whole.piece(at, end)
        text, begin = some.around(at)
        assert (text, begin) == (TEXTS[k], whole.begins[k])
        assert some.line_before(at) == whole.line_before(at)
        assert some.line_end(at) == whole.line_end(at)
        assert (some.line(at), some.file(at)) == (whole.line(at), whole.file(at))
        assert list(some.words(at, whole.length)) == list(whole.words(at, whole.length))
    assert "".join(some.pieces(3, some.length - 2)).replace("\n", "") == whole.text[3:-2].replace("\n", "")
    assert [some.text_of(k) for k in (3, 1, 4, 0, 2)] == [TEXTS[k] for k in (3, 1, 4, 0, 2)]


def test_a_file_that_was_changed_meanwhile_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reread_text, "HELD", 10)
    some = linked(RereadText, tmp_path)
    assert some.text_of(4) == "last" and some.text_of(2) == TEXTS[2]
    (tmp_path / "part4.mod").write_text("lost")
    with pytest.raises(ReadError, match=r"part4\.mod: the file was changed while it was read"):
        some.around(some.length)
    (tmp_path / "part3.mod").unlink()
    with pytest.raises(ReadError, match=r"part3\.mod: cannot be read again: No such file"):
        some.text_of(3)
    (tmp_path / "part0.mod").unlink()  # the main one is held: it may have come from anywhere
    assert some.text_of(0) == TEXTS[0]
