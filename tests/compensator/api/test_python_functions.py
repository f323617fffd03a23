"""The functions of `import compensator`: the same numbers as the command line, and what they refuse."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import compensator as comp
from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.identify import identify_files
from tests.compensator import small_job
from tests.stiffness.bench_lab import STIFFNESS, Lab

ROOT = Path(__file__).parents[3]


def without_time(summary: object) -> dict[str, object]:
    """A summary as JSON has it, without the seconds."""
    out: dict[str, object] = json.loads(json.dumps(summary))
    return {key: value for key, value in out.items() if key not in ("seconds", "provenance")}


@pytest.mark.parametrize("kind", [str, Path])
def test_a_program_is_that_of_the_command_line(tmp_path: Path, kind: type) -> None:
    """Byte by byte, and its summary; paths as str and as Path."""
    job = small_job.files(tmp_path)
    task = compensate_file(job.toolpath, job.cell, job.out / "a.mod")
    (job.out / "b").mkdir()
    done = comp.compensate(kind(job.toolpath), kind(job.cell))
    written = comp.write(done, kind(job.out / "b" / "a.mod"))
    assert written.files == (job.out / "b" / "a.mod",)
    assert written.files[0].read_bytes() == (job.out / "a.mod").read_bytes()
    assert without_time(written.summary) == without_time(task.report)


def test_a_preview_is_that_of_the_command_line(tmp_path: Path) -> None:
    """Summary and csv; objects that are loaded already give the same."""
    job = small_job.files(tmp_path)
    task = preview_file(job.toolpath, job.cell, csv=job.out / "a.csv")
    cell = comp.load_cell(job.cell)
    for given in (job.toolpath, comp.read_toolpath(job.toolpath, cell)):
        shown = comp.preview(given, cell)
        assert without_time(shown.summary) == without_time(task.report)
    comp.write(shown, job.out / "b.csv")
    assert (job.out / "b.csv").read_bytes() == (job.out / "a.csv").read_bytes()
    with pytest.raises(CompensatorError, match="written as csv"):
        comp.write(shown, job.out / "b.mod")


def test_tables(tmp_path: Path) -> None:
    """A row per pose, with units in the names: sizes are those of the summary."""
    job = small_job.files(tmp_path)
    done = comp.compensate(job.toolpath, job.cell)
    table = done.to_pandas()
    assert len(table) == done.summary["n_poses"]
    cut = table[table["kind"] == "cut"]
    size = np.sqrt(sum(table[f"correction_{axis}_mm"] ** 2 for axis in "xyz"))
    assert float(size.max()) == pytest.approx(done.summary["max_correction_mm"], abs=1e-12)
    before = np.sqrt(sum(cut[f"error_before_{axis}_mm"] ** 2 for axis in "xyz"))
    assert float(before.max()) == pytest.approx(done.summary["predicted_error_mm"]["before"]["max"], rel=0.01)
    assert np.allclose(np.sqrt(sum(cut[f"f{a}_n"] ** 2 for a in "xyz")), np.linalg.norm([-300, 200, 250]))
    assert np.degrees(done.result.command.q[:, 2]).tolist() == table["q3_deg"].tolist()


def test_without_pandas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One message with the remedy; `columns` needs nothing."""
    job = small_job.files(tmp_path)
    shown = comp.preview(job.toolpath, job.cell)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(CompensatorError, match=r"pip install 'toolpath-compensator\[pandas\]'"):
        shown.to_pandas()
    assert len(shown.columns()["x_mm"]) == shown.summary["n_poses"]


def test_results_are_frozen_and_shown_in_one_line(tmp_path: Path) -> None:
    """Markup of a hostile name is escaped in a notebook."""
    job = small_job.files(tmp_path)
    bad = job.toolpath.rename(tmp_path / "<script>alert(1)<.csv")
    shown = comp.preview(bad, job.cell)
    assert "\n" not in repr(shown) and repr(shown).startswith("PathResult(")
    assert "<script>" not in shown._repr_html_() and "&lt;script&gt;" in shown._repr_html_()
    with pytest.raises(dataclasses.FrozenInstanceError):
        shown.summary = {}  # type: ignore[misc]


def test_a_session(tmp_path: Path) -> None:
    """identify and write give the file of the command line; diagnose and evaluate take it; inputs stay."""
    Lab().session(tmp_path, 7, setups=8)
    session = tmp_path / "session.toml"
    task = identify_files([session], tmp_path / "a.toml", effects=["joint-stiffness"])
    fit = comp.identify(session, effects=["joint-stiffness"])
    (tmp_path / "b").mkdir()
    comp.write(fit, tmp_path / "b" / "a.toml")
    assert (tmp_path / "b" / "a.toml").read_bytes() == (tmp_path / "a.toml").read_bytes()
    assert without_time(fit.summary) == without_time(task.report)
    known = STIFFNESS["abb-irb6600-175-255"]
    assert fit.columns()["stiffness_nm_per_rad"][:3] == pytest.approx(known[:3], rel=0.05)
    model = comp.load_model(str(tmp_path / "a.toml"))
    found = comp.diagnose([session], model)
    assert found.summary["verdict"] == found.diagnosis.verdict
    refined = comp.write(found, tmp_path / "refined.toml")
    assert comp.load_model(refined.files[0]).robot == "abb-irb6600-175-255"
    assert comp.evaluate(session, model).columns()["rms_mm"][0] < 0.05
    for file in (session, tmp_path / "samples.csv"):
        with pytest.raises(CompensatorError, match="is an input of this run"):
            comp.write(fit, file)
    with pytest.raises(CompensatorError, match="is an input of this run"):
        comp.write(found, tmp_path / "a.toml")
    with pytest.raises(CompensatorError, match="EvaluateResult has no file"):
        comp.write(comp.evaluate(session, model), tmp_path / "c.toml")


def test_in_place(tmp_path: Path) -> None:
    """A program in the language of its source is asked for when it is solved."""
    job = small_job.files(tmp_path)
    part = tmp_path / "part.nc"
    part.write_text("%\nG21 G90\nG0 X0 Y0 Z80\nG0 Z5\nG1 Z-2 F300\nG1 X100 F1200\nG0 Z80\nM30\n%\n")
    with pytest.raises(CompensatorError, match="language='gcode'"):
        comp.write(comp.compensate(part, job.cell), job.out / "part.nc")
    filtered = comp.compensate(part, job.cell, language="gcode")
    comp.write(filtered, job.out / "part.nc")
    compensate_file(part, job.cell, job.out / "task.nc")
    assert (job.out / "part.nc").read_bytes() == (job.out / "task.nc").read_bytes()
    with pytest.raises(CompensatorError, match="not 'rapid'"):
        comp.write(filtered, job.out / "part.mod")
    with pytest.raises(CompensatorError, match="give its path"):
        comp.compensate(comp.read_toolpath(part), job.cell, language="gcode")


def test_the_package_is_light_and_says_what_it_has() -> None:
    """Nothing heavy before a name is used; unknown names are told what there is."""
    code = "import compensator as c, sys\nprint(c.__version__, 'numpy' in sys.modules, 'write' in dir(c))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split()[1:] == ["False", "True"]
    with pytest.raises(AttributeError, match="it has __version__, compensate"):
        comp.fly  # noqa: B018
    done = subprocess.run(
        [sys.executable, "-m", "compensator", "--help"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("Usage: compensator ")
