"""Findings of every stage stand in every output alike, and --strict makes their warnings refusals."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from compensator.report.json.findings import findings_report
from compensator.report.words.findings import finding_sentences
from compensator.tasks import compensate as task
from stiffness.model.model import builtin_model
from tests.compensator.report.page_reader import Walk
from tests.compensator.small_job import AXIS, ROWS, STIFFNESS, Files, files
from tests.stiffness.model.test_clamped import HEADER, cycle, lines, written
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.program_files import ProgramFiles

# a warning of each stage: no feed (program), no start (solve), another tool's bracket (cell), a part from below (path)
ODD: dict[str, Any] = {"workobject": {"xyz": [1300.0, -150.0, 1500.0], "rpy": [180.0, 0.0, 20.0]}}
BRACKET = {"tool": "other", "linear_m_per_n": [1e-8] * 3, "angular_rad_per_nm": [1e-8] * 3}
GAPS = {"gap_rad": [6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4], "breakaway_nm": [1e4] * 6}  # nothing holds a flank
WORN = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}, "backlash": GAPS, "tool-compliance": BRACKET}
NO_FEED = {"rows": [[*r[:6], r[7]] for r in ROWS[2:]], "header": tuple(a for a in AXIS if a != "feed_mm_min")}
KINDS = {"toolpath", "cell", "path", "solve", "program"}


@pytest.fixture
def job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Files:
    """A job with a warning of every stage; that of the reader is about two lines."""
    made = files(tmp_path, ODD, {"effects": WORN}, **NO_FEED)
    read = task.read_program

    def warned(given: ProgramFiles, **how: Any) -> Any:
        found = [Finding(WARNING, f"{given.main.name}:{line}", "an odd <word>", "take it out") for line in (3, 5)]
        return replace(read(given, **how), findings=tuple(found))

    monkeypatch.setattr(task, "read_program", warned)
    return made


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


def asked(job: Files, verb: str) -> list[object]:
    out = ["-o", job.out / "a.mod"] if verb == "compensate" else ["--csv", job.out / "a.csv"]
    return [verb, job.toolpath, "--cell", job.cell, *out, "--json", job.out / "a.json", "--report", job.out / "a.html"]


@pytest.mark.parametrize("verb", ["compensate", "preview"])
def test_every_stage_in_every_output(job: Files, verb: str) -> None:
    """JSON, standard error and page have the same list, warnings first; repeats are one with a count."""
    done = run(*asked(job, verb))
    assert (done.exit_code, done.stdout) == (0, "")
    report = json.loads((job.out / "a.json").read_text())
    found = report["findings"]
    assert {f["kind"] for f in found if f["level"] == WARNING} == KINDS
    assert [f["level"] for f in found] == sorted((f["level"] for f in found), reverse=True)  # warning, note
    (odd,) = (f for f in found if f["kind"] == "toolpath")
    assert (odd["where"], odd["source_line"], odd["count"]) == ("path.csv:3", 3, 2)
    assert done.stderr.splitlines() == finding_sentences(report)
    assert "warning: path.csv:3 (and 1 more place): an odd <word>. take it out" in done.stderr
    said = " ".join(Walk((job.out / "a.html").read_text()).said.split())
    for f in found:
        assert " ".join(f["what"].split()) in said, f
    assert said.index("an odd <word>") < said.index("misses the path by")  # warnings stand before the text
    words = " ".join(f["what"] for f in found)
    for part in ("no feed in the toolpath", "flank", "measured with tool 'other'", "below the work"):
        assert part in words


@pytest.mark.parametrize("verb", ["compensate", "preview"])
def test_strict_refuses_with_all_warnings_and_leaves_nothing(job: Files, verb: str) -> None:
    done = run(*asked(job, verb), "--strict")
    assert (done.exit_code, done.stdout) == (1, "") and job.left() == []
    first, *rest = done.stderr.splitlines()
    assert first.startswith("compensator: --strict: ") and "warnings refuse this run. Nothing was written" in first
    assert len(rest) == len(KINDS) and all(line.startswith("  warning: ") for line in rest)


def test_strict_lets_notes_pass(tmp_path: Path) -> None:
    job = files(tmp_path)
    done = run("compensate", job.toolpath, "--cell", job.cell, "-o", job.out / "a.mod", "--strict")
    assert done.exit_code == 0 and "note: " in done.stderr and job.left() == ["a.mod"]


def test_strict_of_a_verb_that_makes_a_model(tmp_path: Path) -> None:
    """A gap that is too small by what friction holds: a warning, on standard error and in JSON; or a refusal."""
    readings = written(tmp_path, lines(cycle(branches=("loading",)), cycle()), HEADER)
    out = ["--robot", "abb-irb6600-175-255", "-o", tmp_path / "m.toml", "--json", tmp_path / "m.json"]
    done = run("clamped", readings, *out)
    assert done.exit_code == 0 and "joint 1: no unloading branch" in done.stderr
    assert [f["level"] for f in json.loads((tmp_path / "m.json").read_text())["findings"]] == [WARNING]
    for name in ("m.toml", "m.json"):
        (tmp_path / name).unlink()
    done = run("clamped", readings, *out, "--strict")
    assert done.exit_code == 1 and "a warning refuses this run" in done.stderr
    assert not (tmp_path / "m.toml").exists() and not (tmp_path / "m.json").exists()


@pytest.mark.parametrize("verb", ["compensate", "preview", "identify", "diagnose", "evaluate", "clamped", "plan"])
def test_strict_is_offered(verb: str) -> None:
    assert "--strict" in run(verb, "--help").stdout


def test_the_source_of_the_stiffness_is_told(tmp_path: Path) -> None:
    """What the model file says of its values stands in the notes of a result: kind, source, load range."""
    job = files(tmp_path, {"robot": "kuka-kr210-r2700", "model": str(builtin_model("kuka-kr210-r2700"))})
    done = task.preview_file(job.toolpath, job.cell)
    (told,) = (f for f in done.findings if "stiffness values" in f.what)
    assert told.level == NOTE and "from modal tests: " in told.what and "generation before" in told.what
    assert "load range: small amplitudes" in told.what


def test_a_finding_of_a_report_has_its_line() -> None:
    """From its place, or given beside it."""
    rows = Finding(NOTE, "samples.csv", "y", line=12)
    found = [Finding(WARNING, "a.nc:7 (pose 3)", "x"), rows, Finding(NOTE, "", "z")]
    assert [f["source_line"] for f in findings_report(found)] == [7, 12, None]
