"""`plan --program`: the program drives to the planned postures, and its session is taken by `identify` once filled."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from compensator.tasks.identify import identify_files
from stiffness.errors import StiffnessError
from stiffness.session.session import load_session
from tests.compensator.filled_session import fill_in, rows_of
from tests.compensator.small_job import STIFFNESS, files

WIDE = {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS, "sd_nm_per_rad": [0.5 * k for k in STIFFNESS]}}}
TRUE = [1.3 * k for k in STIFFNESS]


def plan(tmp_path: Path, name: str, *more: str) -> tuple[Path, Result]:
    """The folder of the plan, with a tool as in the cell."""
    job = files(tmp_path, {"gravity": None, "tip": None}, WIDE)
    day = tmp_path / "day"
    day.mkdir()
    words = ["plan", tmp_path / "model.toml", "--cell", job.cell, "-o", day / "setups.csv", "--program", day / name]
    return day, CliRunner().invoke(main, [str(w) for w in (*words, "--count", 5, "--force", 600, *more)])


def test_filled_in_it_is_identified(tmp_path: Path) -> None:
    """Readings of the plant, 30 % stiffer than the model, put into the empty csv: every joint within 5 %."""
    day, done = plan(tmp_path, "drive.mod")
    assert done.exit_code == 0, done.output
    with pytest.raises(StiffnessError, match=r"samples\.csv"):
        load_session(day / "session.toml")  # nothing was measured yet
    fill_in(day, TRUE)
    found = identify_files([day / "session.toml"], tmp_path / "found.toml", effects=["joint-stiffness"]).report
    assert found["stiffness_nm_per_rad"] == pytest.approx(TRUE, rel=0.05)


@pytest.mark.parametrize(
    ("name", "posture", "stop", "scale"),
    [
        ("drive.mod", r"MoveAbsJ \[\[([^]]+)\]", r"^    Stop;\r?$", 1.0),
        ("drive.src", r"PTP \{AXIS: ([^}]+)\}", r"^  HALT\r?$", 1.0),
        ("drive.script", r"movej\(\[([^]]+)\]", r"popup\(", 180 / np.pi),
        ("drive.ls", r"(J1= [^}]+?)\s*\}", r": {2}PAUSE ;", 1.0),
    ],
)
def test_it_drives_to_the_postures(tmp_path: Path, name: str, posture: str, stop: str, scale: float) -> None:
    """Each one from the side that it is planned from, and a stop there; Fanuc counts joint 3 from the horizon."""
    day, done = plan(tmp_path, name)
    assert done.exit_code == 0, done.output
    text = (day / name).read_bytes().decode("ascii")
    angles = [re.findall(r"-?\d+\.\d+", a) for a in re.findall(posture, text, re.S)]
    driven = scale * np.array(angles, dtype=float).reshape(-1, 2, 6)
    if name.endswith(".ls"):
        driven[..., 2] += driven[..., 1]
    rows = [r for r in rows_of(day / "setups.csv") if r["state"] == "0"]
    wanted = np.array([[float(r[f"q{k}_deg"]) for k in range(1, 7)] for r in rows])
    side = np.array([[float(r[f"approach{k}"]) for k in range(1, 7)] for r in rows])
    assert driven[:, 1] == pytest.approx(wanted, abs=2e-4) and len(wanted) == 5
    assert driven[:, 1] - driven[:, 0] == pytest.approx(3.0 * side, abs=1e-5)
    assert len(re.findall(stop, text, re.M)) == 5 and all(f"set-up {k}:" in text for k in range(1, 6))


@pytest.mark.parametrize("name", ["session.toml", "samples.csv"])
def test_what_is_filled_in_is_never_written_anew(tmp_path: Path, name: str) -> None:
    day, done = plan(tmp_path, "drive.mod")
    assert done.exit_code == 0
    (day / name).write_text("a day of readings")
    other = next(day / n for n in ("session.toml", "samples.csv") if n != name)
    before = {file.name: file.read_bytes() for file in day.iterdir()}
    model, cell = tmp_path / "model.toml", tmp_path / "cell.toml"
    words = ["plan", model, "--cell", cell, "-o", day / "setups.csv", "--program", day / "drive.mod"]
    other.unlink()
    del before[other.name]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 1 and f"{name}: stands there and may hold readings" in done.stderr
    assert {file.name: file.read_bytes() for file in day.iterdir()} == before


def test_refusals(tmp_path: Path) -> None:
    """A language without such programs; standard output; a plan of circles."""
    (tmp_path / "a").mkdir()
    day, done = plan(tmp_path / "a", "drive.jbi")
    assert done.exit_code == 1 and "is not written as inform; known: rapid, krl, fanuc, urscript" in done.stderr
    assert list(day.iterdir()) == []
    words = ["plan", "--cell", str(tmp_path / "a" / "cell.toml"), "--ballbar", "-o", str(day / "c.mod")]
    done = CliRunner().invoke(main, [*words, "--program", str(day / "d.mod")])
    assert done.exit_code == 1 and "--program: belongs to a plan of set-ups" in done.stderr
