"""identify and evaluate as commands: files in, files out, the JSON of the contract."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from compensator.cli import main
from stiffness.model.model import load_model
from tests.plant.paper_experiment import table_3
from tests.stiffness.bench_lab import Lab


def run(*arguments: object) -> str:
    done = CliRunner().invoke(main, [str(a) for a in arguments])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lab")
    Lab().session(folder, 71, setups=12)
    return folder / "session.toml"


def test_global(session: Path, tmp_path: Path) -> None:
    model, report = tmp_path / "m.toml", tmp_path / "m.json"
    assert run("identify", session, "-o", model, "--effects", "joint-stiffness", "--json", report) == ""
    told = json.loads(report.read_text())
    assert {"effects", "stiffness_nm_per_rad", "stiffness_sd_nm_per_rad", "identifiable", "rms_mm"} <= set(told)
    assert told["effects"] == ["joint-stiffness"]
    assert told["identifiable"] == [True] * 6
    assert told["stiffness_nm_per_rad"][:3] == pytest.approx(Lab().stiffness[:3], rel=0.03)
    rms = told["rms_mm"]["displacement"]
    assert rms["rigid"] > 5 * rms["fitted"]
    assert rms["fitted"] == pytest.approx(rms["noise_floor"], rel=0.05)
    assert told["n_readings"] == len((session.parent / "samples.csv").read_text().splitlines()) - 1
    written = load_model(model)
    assert written.values["joint-stiffness"]["k_nm_per_rad"].tolist() == told["stiffness_nm_per_rad"]
    assert "sha256" in written.provenance["source"][0]
    again, page = tmp_path / "again.toml", tmp_path / "fit.html"
    run("identify", session, "-o", again, "--effects", "joint-stiffness", "--report", page)
    assert f"{told['stiffness_nm_per_rad'][0]:.3g}"[:3] in page.read_text()
    assert again.read_bytes() == model.read_bytes()


def test_evaluate(session: Path, tmp_path: Path) -> None:
    model, report = tmp_path / "m.toml", tmp_path / "e.json"
    run("identify", session, "-o", model, "--effects", "joint-stiffness")
    run("evaluate", session, "--model", model, "--json", report)
    told = json.loads(report.read_text())
    assert set(told["displacement"]) == {"rms_mm", "p95_mm", "max_mm", "noise_floor_mm", "by_reflector"}
    assert told["displacement"]["rms_mm"] == pytest.approx(told["displacement"]["noise_floor_mm"], rel=0.05)
    assert set(told["absolute"]["by_reflector"]) == {"tcp", "side", "elbow"}
    other = tmp_path / "other.toml"
    other.write_text(model.read_text().replace('gravity = "uncompensated"', 'gravity = "calibrated-out"'))
    done = CliRunner().invoke(main, ["evaluate", str(session), "--model", str(other)])
    assert done.exit_code == 1
    assert "calibrated-out" in done.output


def test_a_rough_reflector_that_nothing_placed_is_told(session: Path, tmp_path: Path) -> None:
    model, report, rough = tmp_path / "m.toml", tmp_path / "e.json", tmp_path / "rough.toml"
    run("identify", session, "-o", model, "--effects", "joint-stiffness")
    (tmp_path / "samples.csv").write_bytes((session.parent / "samples.csv").read_bytes())
    before, elbow = session.read_text().split("[reflectors.elbow]")
    assert "exact = true" in elbow
    rough.write_text(before + "[reflectors.elbow]" + elbow.replace("exact = true", "exact = false", 1))
    said = run("evaluate", rough, "--model", model, "--json", report)
    told = json.loads(report.read_text())
    (found,) = (f for f in told["findings"] if "roughly known" in f["what"])
    own = told["absolute"]["by_reflector"]["elbow"]
    assert f"elbow ({own:.3f} mm RMS)" in found["what"] and found["level"] == "warning" and told["n_placing"] == 0
    assert found["what"] in " ".join(said.split())
    placed = run("evaluate", rough, "--model", model, "--json", report, "--register", "25")
    told = json.loads(report.read_text())
    assert told["n_placing"] == 25 * 3 and "roughly known" not in placed


def test_a_frame_that_misses_is_said_first_in_every_output(session: Path, tmp_path: Path) -> None:
    rows = [line.split(",") for line in (session.parent / "samples.csv").read_text().splitlines()]
    at = rows[0].index("x")
    for row in rows[1:]:
        row[at] = str(float(row[at]) + 0.25)
    (tmp_path / "samples.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    missed, model = tmp_path / "session.toml", tmp_path / "m.toml"
    missed.write_bytes(session.read_bytes())
    for verb, *more in (("identify", "-o", model), ("diagnose", "--model", model, "-o", tmp_path / "r.toml")):
        report, page = tmp_path / f"{verb}.json", tmp_path / f"{verb}.html"
        said = run(verb, missed, *more, "--json", report, "--report", page)
        (found,) = (f for f in json.loads(report.read_text())["findings"] if "Register anew" in f["what"])
        assert found["level"] == "warning" and " 0.25 mm" in found["what"]
        assert "Register anew" in said and "Register anew" in page.read_text()


def test_local_method(tmp_path: Path) -> None:
    """The paper's experiment through the command; ratios of its Table 3 (few repeats here: 5 %)."""
    session = table_3(repeats=[150] * 6, seed=5).write(tmp_path, "abb-irb6600-175-255")
    model, report = tmp_path / "m.toml", tmp_path / "m.json"
    run("identify", session, "-o", model, "--method", "local", "--json", report)
    k = np.array(json.loads(report.read_text())["stiffness_nm_per_rad"])
    assert k / k[0] == pytest.approx([1, 0.887, 0.6892, 0.141, 0.048, 0.0187], rel=0.05)
    asked = ["identify", str(session), "-o", str(model), "--method", "local", "--prior", "x.toml"]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 1
    assert "no --prior" in done.output


def test_findings_of_the_local_method_reach_terminal_and_json(tmp_path: Path) -> None:
    """A wrench a thousand times too large, said as by the global method; --strict refuses it."""
    session = table_3(repeats=[20] * 6, seed=5).write(tmp_path, "abb-irb6600-175-255")
    rows = [line.split(",") for line in (tmp_path / "samples.csv").read_text().splitlines()]
    wrench = [rows[0].index(name) for name in ("fx", "fy", "fz", "mx", "my", "mz")]
    for row in rows[1:]:
        for k in wrench:
            row[k] = repr(float(row[k]) * 1e3)
    (tmp_path / "samples.csv").write_text("\n".join(",".join(row) for row in rows) + "\n")
    model, report = tmp_path / "m.toml", tmp_path / "m.json"
    asked = ["identify", str(session), "-o", str(model), "--method", "local", "--json", str(report)]
    done = CliRunner().invoke(main, asked)
    assert done.exit_code == 0, done.output
    found = [f["what"] for f in json.loads(report.read_text())["findings"]]
    assert any("a thousand times too large" in what for what in found) and all(what in done.output for what in found)
    model.unlink()
    done = CliRunner().invoke(main, [*asked, "--strict"])
    assert done.exit_code == 1 and "a thousand times" in done.output and not model.exists()


def test_refusals_leave_nothing(session: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.toml"
    for arguments, words in (
        (["identify", str(session), "-o", str(out), "--effects", "joint-stifness"], "unknown effect joint-stifness"),
        (["identify", str(tmp_path / "none.toml"), "-o", str(out)], "none.toml"),
        (["identify", str(session), "-o", str(tmp_path / "no" / "m.toml")], "cannot write"),
    ):
        done = subprocess.run(
            [sys.executable, "-m", "compensator.cli", *arguments], capture_output=True, text=True, check=False
        )
        assert done.returncode == 1
        assert words in done.stderr
        assert list(tmp_path.iterdir()) == []
