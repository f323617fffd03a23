"""`init`: what its six answers become, that it runs, and what is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from compensator.cell.cell_file import load_cell
from compensator.cli import main
from compensator.tasks.compensate import preview_file
from tests.compensator.small_job import files

ANSWERS = {
    "--robot": "abb-irb6600-175-255",
    "--tool": "30 -20 240 30",
    "--part": "1500, -150, 800, 0, 0, 20",
    "--cam": "path.csv",
    "--stiffness": "unknown",
    "--controller": "rapid",
}


def init(*more: str, stdin: str = "", leave_out: tuple[str, ...] = (), **changed: str) -> Result:
    """In the working folder."""
    answers = {**ANSWERS, **{f"--{key}": value for key, value in changed.items()}}
    words = [word for key, value in answers.items() if key not in leave_out for word in (key, value)]
    return CliRunner().invoke(main, ["init", *words, *more], input=stdin)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With a CAM file, a cell and a model of other names."""
    files(tmp_path)
    (tmp_path / "cell.toml").rename(tmp_path / "old.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_is_written(folder: Path) -> None:
    """Values as answered; the model has a band; the cell runs."""
    done = init()
    assert done.exit_code == 0 and done.stdout == ""
    cell = tomllib.loads((folder / "cell.toml").read_text())
    assert cell["robot"] == "abb-irb6600-175-255" and cell["tip"] == "tool0" and cell["model"] == "stiffness.toml"
    assert cell["tool"] == {"xyz": [30.0, -20.0, 240.0], "mass": 30, "com": [15.0, -10.0, 120.0]}
    assert cell["workobject"] == {"xyz": [1500.0, -150.0, 800.0], "rpy": [0.0, 0.0, 20.0]}
    assert cell["process"]["wrench"] == [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]
    assert "sd_nm_per_rad" in tomllib.loads((folder / "stiffness.toml").read_text())["effects"]["joint-stiffness"]
    shown = preview_file(folder / "path.csv", folder / "cell.toml")
    assert 0.01 < shown.report["predicted_error_mm"]["before"]["max"] < 2
    for words in ("the wrench is an assumption", "stiffness of this robot is not measured"):
        assert words in done.stderr


def test_asked_for_what_options_do_not_give(folder: Path) -> None:
    """Questions go to standard error; the answers make the same cell."""
    assert init().exit_code == 0
    first = (folder / "cell.toml").read_bytes()
    (folder / "cell.toml").unlink()
    (folder / "stiffness.toml").unlink()
    done = init(stdin="30 -20 240 30\nunknown\n", leave_out=("--tool", "--stiffness"))
    assert done.exit_code == 0 and done.stdout == "" and "Which robot" not in done.stderr
    assert "tip of the cutter" in done.stderr and (folder / "cell.toml").read_bytes() == first


def test_no_answer(folder: Path) -> None:
    """Names what is missing; nothing is written."""
    done = init(stdin="", leave_out=("--part", "--controller"))
    assert done.exit_code == 1 and "not answered: --part, --controller" in done.stderr
    assert not (folder / "cell.toml").exists()


@pytest.mark.parametrize("standing", ["cell.toml", "stiffness.toml"])
def test_nothing_is_overwritten(folder: Path, standing: str) -> None:
    """Nor is the other file written."""
    (folder / standing).write_text("mine")
    done = init()
    assert done.exit_code == 1 and f"{standing}: stands there already" in done.stderr
    assert (folder / standing).read_text() == "mine"
    assert not {"cell.toml", "stiffness.toml"} - {standing} & {p.name for p in folder.iterdir()} - {standing}


@pytest.mark.parametrize(
    ("option", "answer", "words"),
    [
        ("robot", "ur11", "'ur11' is no robot"),
        ("tool", "long", "tool = 'long': expected 3 or 4 numbers"),
        ("tool", "0 0 0.25", "looks like metres"),
        ("part", "1 2", "part = '1 2': expected 3 or 6 numbers"),
        ("part", "nan 0 0", "expected 3 or 6 numbers"),
        ("cam", "lost.nc", "lost.nc: there is no such file"),
        ("stiffness", "lost.toml", "lost.toml"),
    ],
)
def test_refused_answers(folder: Path, option: str, answer: str, words: str) -> None:
    """One message; nothing is left behind."""
    before = sorted(p.name for p in folder.iterdir())
    done = init(**{option: answer})
    assert done.exit_code == 1 and words in done.stderr, done.stderr
    assert sorted(p.name for p in folder.iterdir()) == before


def test_a_model_that_is_known(folder: Path) -> None:
    """A file, seen from the cell in another folder; a built-in set by name. No model is written."""
    (folder / "cells").mkdir()
    assert init("-o", "cells/a.toml", stiffness="model.toml").exit_code == 0
    assert load_cell("cells/a.toml").model == "../model.toml"
    assert "compensator check a.toml ../path.csv" in (folder / "cells" / "a.toml").read_text()
    assert init("-o", "b.toml", stiffness="abb-irb6600-175-255").exit_code == 0
    assert load_cell("b.toml").model == "abb-irb6600-175-255"
    assert not (folder / "stiffness.toml").exists() and not (folder / "cells" / "stiffness.toml").exists()
    done = init("-o", "c.toml", "--new-model", "d.toml", stiffness="model.toml")
    assert done.exit_code == 1 and "leave --new-model out" in done.stderr


def test_a_file_that_needs_more(folder: Path) -> None:
    """The cell is written, and the refusal of the reader is passed on as a warning."""
    (folder / "five.nc").write_text("%\nG21 G90\nG0 X0 Y0 Z80 A0 C0\nG1 X10 A5 F100\nM30\n%\n")
    done = init(cam="five.nc")
    assert done.exit_code == 0 and "warning: five.nc: is refused with this cell" in done.stderr
    assert (folder / "cell.toml").exists()


def test_a_light_arm_gets_a_light_cut(folder: Path) -> None:
    """A tenth of the weight that it moves: 28.0 kg of a UR10 are 27.5 N."""
    assert init(robot="ur10", part="600 -100 200").exit_code == 0
    wrench = tomllib.loads((folder / "cell.toml").read_text())["process"]["wrench"]
    assert sum(f**2 for f in wrench) ** 0.5 == pytest.approx(27.5, abs=0.8) and wrench[3:] == [0, 0, 0]


def test_names_with_quotes_and_spaces(folder: Path) -> None:
    """Comments and commands stay what they are."""
    (folder / 'my "part" 1.csv').write_bytes((folder / "path.csv").read_bytes())
    assert init(cam='my "part" 1.csv').exit_code == 0
    assert """compensator check cell.toml 'my "part" 1.csv'""" in (folder / "cell.toml").read_text()
