"""`check`: everything wrong at once, and what assumptions are worth, against previews of the other way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from compensator.tasks.check import check_files
from compensator.tasks.compensate import preview_file
from tests.compensator.small_job import MODEL, STIFFNESS, WORN, columns, files, merged

SD = [0.1 * k for k in STIFFNESS]
KNOWN = merged(MODEL, {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS, "sd_nm_per_rad": SD}}})


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, ["check", *(str(a) for a in arguments)])


def worth(report: dict[str, Any], words: str) -> float:
    """mm, of the one finding with these words."""
    (found,) = [f for f in report["findings"] if words in f["what"] and f["worth_mm"] is not None]
    return float(found["worth_mm"])


def seen(folder: Path, cell: dict[str, Any], model: dict[str, Any]) -> np.ndarray:
    """Predicted deflection at the cuts, mm."""
    folder.mkdir()
    job = files(folder, cell, model)
    preview_file(job.toolpath, job.cell, csv=job.out / "a.csv")
    cut = np.array(["cut" in line for line in (job.out / "a.csv").read_text().splitlines()[1:]])
    return columns(job.out / "a.csv", "dx_mm", "dy_mm", "dz_mm")[cut]


def moved(tmp_path: Path, one: tuple[Any, Any], other: tuple[Any, Any]) -> float:
    """mm, largest move from one cell and model to another."""
    a, b = seen(tmp_path / "one", *one), seen(tmp_path / "other", *other)
    return float(np.linalg.norm(a - b, axis=1).max())


def test_worth_of_a_stiffness(tmp_path: Path) -> None:
    """Of joint 2, one standard deviation softer: the difference of two previews; and all of them together."""
    job = files(tmp_path, None, KNOWN)
    report = check_files(job.cell, [job.toolpath]).report
    softer = [k - (j == 1) * 0.1 * k for j, k in enumerate(STIFFNESS)]
    other = {"effects": {"joint-stiffness": {"k_nm_per_rad": softer}}}
    assert worth(report, "joint 2:") == pytest.approx(moved(tmp_path, ({}, KNOWN), ({}, other)), abs=2e-6)
    each = [worth(report, f"joint {j}:") for j in range(1, 7)]
    assert worth(report, "stiffness of all joints") == pytest.approx(np.linalg.norm(each), rel=1e-9)
    assert report["n_errors"] == 0 and report["schema"] == "check/1"


def test_worth_of_gravity(tmp_path: Path) -> None:
    """The controller knows the sag, or does not."""
    job = files(tmp_path)
    report = check_files(job.cell, [job.toolpath]).report
    expected = moved(tmp_path, ({}, {}), ({"gravity": "uncompensated"}, {}))
    assert worth(report, "were it 'uncompensated'") == pytest.approx(expected, abs=2e-6) and expected > 1


def test_worth_of_a_tenth(tmp_path: Path) -> None:
    """Of the wrench, and of a stiffness without standard deviation: about a tenth of the deflection each."""
    job = files(tmp_path)
    report = check_files(job.cell, [job.toolpath]).report
    whole = float(np.linalg.norm(seen(tmp_path / "one", {}, {}), axis=1).max())
    assert worth(report, "the wrench of the process") == pytest.approx(0.1 * whole, rel=0.02)
    assert worth(report, "no standard deviations") == pytest.approx(whole / 9, rel=0.02)


def test_worth_of_touching_off(tmp_path: Path) -> None:
    """Where the arm sags: about the sag itself. Nothing where the controller knows it, and it is left out."""
    job = files(tmp_path, {"gravity": "uncompensated"})
    report = check_files(job.cell, [job.toolpath]).report
    assert worth(report, "had this tool touched it off") > 1
    job = files(tmp_path)
    report = check_files(job.cell, [job.toolpath]).report
    assert not [f for f in report["findings"] if "touched it off" in f["what"]]


def test_worth_of_the_start(tmp_path: Path) -> None:
    """Flanks that nobody knows, as preview says it; none where the start is given."""
    job = files(tmp_path, None, WORN)
    report = check_files(job.cell, [job.toolpath]).report
    shown = preview_file(job.toolpath, job.cell).report["unknown_state"]["max_spread_mm"]
    assert worth(report, "where the arm starts from") == pytest.approx(shown, rel=1e-6) and shown > 0.01


def test_everything_wrong_at_once(tmp_path: Path) -> None:
    """Three errors of three files, each with its file and key; exit status 1 and the same in JSON."""
    job = files(tmp_path, {"robot": "ur11", "tool": {"xyz": [0.0, 0.0, 0.25]}}, {"gravity": "maybe"})
    job.toolpath.write_text(job.toolpath.read_text().replace("100,0,-2", "nan,0,-2"))
    done = run(job.cell, job.toolpath, "--json", job.out / "c.json")
    assert done.exit_code == 1
    wrong = ("tool.xyz is 0.25 mm long", "'ur11' is no robot", "gravity = 'maybe'", "path.csv:5: column x_mm: nan")
    for words in wrong:
        assert words in done.stdout, done.stdout
    assert done.stdout.splitlines()[-1].startswith("4 errors, ")
    report = json.loads((job.out / "c.json").read_text())
    assert report["n_errors"] == 4 and [f["level"] for f in report["findings"]][:4] == ["error"] * 4
    assert "compensator: 4 errors" in done.stderr


def test_out_of_reach_is_an_error(tmp_path: Path) -> None:
    """The cell's own findings are still there."""
    job = files(tmp_path, {"workobject": {"xyz": [3500.0, 0.0, 800.0]}})
    done = run(job.cell, job.toolpath)
    assert done.exit_code == 1 and "error: " in done.stdout and "note: " in done.stdout
    assert done.stdout.splitlines()[-1].startswith("1 errors, ")


def test_a_correction_that_is_refused(tmp_path: Path) -> None:
    """Found by the solve, which preview never reaches."""
    job = files(tmp_path, {"solve": {"max_correction": 0.1}})
    done = run(job.cell, job.toolpath)
    assert done.exit_code == 1 and "max_correction" in done.stdout
    assert "the wrench of the process" in done.stdout


def test_the_cell_alone(tmp_path: Path) -> None:
    """Notes, no worth; exit status 0; what is missing for a CAM file is an error."""
    job = files(tmp_path)
    done = run(job.cell)
    assert done.exit_code == 0 and "mm]" not in done.stdout and "0 errors" in done.stdout
    job = files(tmp_path, {"workobject": None})
    done = run(job.cell)
    assert done.exit_code == 1 and "workobject is missing" in done.stdout
    assert run(tmp_path / "lost.toml").exit_code == 1


def test_ranked(tmp_path: Path) -> None:
    """Worst level first; in a level by what it is worth."""
    job = files(tmp_path, {"tool": {"mass": None, "com": None}}, KNOWN)
    rows = check_files(job.cell, [job.toolpath]).report["findings"]
    order = [("error", "warning", "note").index(r["level"]) for r in rows]
    assert order == sorted(order)
    for level in ("warning", "note"):
        sizes = [r["worth_mm"] or 0.0 for r in rows if r["level"] == level]
        assert sizes == sorted(sizes, reverse=True)
