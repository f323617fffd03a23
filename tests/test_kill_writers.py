"""kill -9 at a few moments, and before every file operation, of a verb with two outputs and of one with three."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kill_writers import left_over

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the runs are forked")
def test_killed_at_any_moment() -> None:
    """All of them: `python -m tests.kill_writers`."""
    command = [sys.executable, "-m", "tests.kill_writers", "--kills", "4", "--verbs", "datasheet", "trace"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for verb, line in zip(("datasheet", "trace"), done.stdout.splitlines(), strict=True):
        assert line.startswith(f"{verb}: ") and line.count("all old") == line.count("all new") == 2, line


def test_a_half_written_file_is_seen(tmp_path: Path) -> None:
    """And one that is missing, and an input that has changed."""
    texts = {"given": {"a.toml": b"a"}, "old": {"o.csv": b"old"}, "new": {"o.csv": b"new", "p.csv": b"more"}}

    def seen() -> str:
        return left_over(tmp_path, **texts, place="killed")  # type: ignore[arg-type]

    (tmp_path / "a.toml").write_text("a")
    (tmp_path / "o.csv").write_text("old")
    assert seen() == "all old"
    (tmp_path / "p.csv").write_text("more")
    assert seen() == "some new"
    for name, text, words in (
        ("o.csv", "ne", "neither the old nor the new"),
        ("o.csv", None, "neither the old nor the new"),
        ("a.toml", "", r"a\.toml is not what it was"),
    ):
        before = (tmp_path / name).read_bytes()
        (tmp_path / name).unlink() if text is None else (tmp_path / name).write_text(text)
        with pytest.raises(AssertionError, match=words):
            seen()
        (tmp_path / name).write_bytes(before)
    (tmp_path / "q.csv").write_text("")
    with pytest.raises(AssertionError, match=r"\['q\.csv'\] is left over"):
        seen()
