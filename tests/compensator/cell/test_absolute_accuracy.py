"""[controller] absolute_accuracy: unknown is told by head and findings; at odds with gravity."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from compensator.errors import CellError
from compensator.tasks.compensate import compensate_file
from compensator.tasks.verify import verify_file
from tests.compensator.small_job import files


def run(folder: Path, cell: dict[str, Any], name: str = "part.mod") -> tuple[str, dict[str, Any]]:
    """Head of the program, and the report."""
    job = files(folder, cell)
    done = compensate_file(job.toolpath, job.cell, job.out / name)
    return (job.out / name).read_text(), done.report


def found(report: dict[str, Any]) -> list[tuple[str, str]]:
    return [(f["level"], f["what"]) for f in report["findings"] if f["where"] == "controller"]


@pytest.mark.parametrize(("gravity", "level"), [("calibrated-out", "note"), (None, "warning")])
def test_not_known(tmp_path: Path, gravity: str | None, level: str) -> None:
    """A warning where nothing tells who corrects the sag; the program still verifies."""
    head, report = run(tmp_path, {"gravity": gravity})
    assert "! WARNING: absolute accuracy ?" in head and report["controller"] == {"absolute_accuracy": None}
    ((is_, what),) = found(report)
    assert is_ == level and what.startswith("whether absolute accuracy")
    assert verify_file(tmp_path / "out" / "part.mod", tmp_path / "cell.toml").report["verdict"] == "confirmed"


@pytest.mark.parametrize(
    ("on", "gravity", "words"),
    [
        (True, "calibrated-out", None),
        (True, "uncompensated", "corrected twice"),
        (False, "uncompensated", None),
        (False, "calibrated-out", "what else corrects the sag"),
    ],
)
def test_known(tmp_path: Path, on: bool, gravity: str, words: str | None) -> None:
    """The head tells it; a contradiction to gravity is a warning."""
    cell = {"gravity": gravity, "controller": {"absolute_accuracy": on}}
    head, report = run(tmp_path, cell, "part.src")
    assert f"; absolute accuracy {'on' if on else 'off'}" in head and "WARNING" not in head
    assert report["controller"] == {"absolute_accuracy": on}
    assert [level for level, what in found(report) if words and words in what] == (["warning"] if words else [])
    assert bool(found(report)) == bool(words)


def test_refused(tmp_path: Path) -> None:
    """A word is no truth value."""
    job = files(tmp_path, {"controller": {"absolute_accuracy": "yes"}})
    with pytest.raises(CellError, match=r"controller\.absolute_accuracy = 'yes'"):
        compensate_file(job.toolpath, job.cell, job.out / "a.mod")
