"""`compare`: what differs between summaries of two runs, and what is no summary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.tasks.compare import compare_files
from compensator.tasks.compensate import preview_file
from tests.compensator.small_job import files


def test_two_previews(tmp_path: Path) -> None:
    """Twice the wrench: every error doubles, poses are the same, and the cell's path is not compared."""
    job = files(tmp_path, {"process": {"kind": "constant", "frame": "workobject", "wrench": [-100, 0, 50, 0, 0, 0]}})
    one = preview_file(job.toolpath, job.cell, json=job.out / "one.json").report
    files(tmp_path, {"process": {"kind": "constant", "frame": "workobject", "wrench": [-200, 0, 100, 0, 0, 0]}})
    other = preview_file(job.toolpath, job.cell, json=job.out / "other.json").report
    found = compare_files(job.out / "one.json", job.out / "other.json", json=job.out / "c.json")
    rows = {d.key: d for d in found.rows}
    key = "predicted_error_mm.before.max"
    assert (rows[key].one, rows[key].other) == tuple(r["predicted_error_mm"]["before"]["max"] for r in (one, other))
    assert rows[key].by == pytest.approx(one["predicted_error_mm"]["before"]["max"], rel=0.02)
    assert "n_poses" not in rows and "seconds" not in rows
    report = json.loads((job.out / "c.json").read_text())
    assert report["schema"] == "comparison/1" and report["compared"] == "path-summary/1"
    assert {d["key"] for d in report["differences"]} == set(rows)
    done = CliRunner().invoke(main, ["compare", str(job.out / "one.json"), str(job.out / "other.json")])
    assert done.exit_code == 0 and key in done.stdout


def test_the_same(tmp_path: Path) -> None:
    """But for the time that they took."""
    job = files(tmp_path)
    for name in ("a", "b"):
        preview_file(job.toolpath, job.cell, json=job.out / f"{name}.json")
    done = CliRunner().invoke(main, ["compare", str(job.out / "a.json"), str(job.out / "b.json")])
    assert done.exit_code == 0 and done.stdout == "path-summary/1: no difference\n"


def summary(file: Path, **keys: object) -> Path:
    file.write_text(json.dumps({"schema": "fit-summary/1", "findings": [], **keys}))
    return file


def test_lists_findings_and_null(tmp_path: Path) -> None:
    """Numbers of a short list one by one, of a long one their count; findings by their sentences."""
    finding = {"level": "note", "kind": "model", "what": "odd", "remedy": "", "where": "x", "count": 1}
    a = summary(tmp_path / "a.json", k=[1.0, 2.0], long=list(range(20)), lacks=None, same=[1, 2])
    b = summary(tmp_path / "b.json", k=[1.0, 2.5], long=list(range(30)), lacks="much", same=[1, 2], findings=[finding])
    found = compare_files(a, b)
    assert [(d.key, d.one, d.other, d.by) for d in found.rows] == [
        ("k[2]", 2.0, 2.5, 0.5), ("long: entries", 20, 30, 10.0), ("lacks", None, "much", None)
    ]  # fmt: skip
    assert found.only_one == () and found.only_other == ("note: x: odd",)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("no", "is no JSON"),
        ("[1]", "schema = None: expected one of path-summary/1"),
        ('{"schema": "session/1", "findings": []}', "schema = 'session/1'"),
        ('{"schema": "fit-summary/2", "findings": []}', "schema = 'fit-summary/2'"),
        ('{"schema": "path-summary/1", "findings": []}', "expected two summaries of the same verb"),
        ('{"schema": "fit-summary/1"}', "give what --json wrote"),
    ],
)
def test_refused(tmp_path: Path, text: str, words: str) -> None:
    """One message that names the file."""
    good = summary(tmp_path / "good.json")
    (tmp_path / "bad.json").write_text(text)
    done = CliRunner().invoke(main, ["compare", str(good), str(tmp_path / "bad.json")])
    assert done.exit_code == 1 and words in done.stderr and "bad.json" in done.stderr
    assert CliRunner().invoke(main, ["compare", str(good), str(tmp_path / "lost.json")]).exit_code == 1
