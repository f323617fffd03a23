"""A new user with the README alone: its commands, one after the other, in a folder with nothing but a CAM file."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from compensator.cli import main
from stiffness.robot.load import builtin_robots
from tests.compensator.api.test_python_page import PART

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
#: Where a small part is in reach: zero of the CAM file in the base, mm.
PLACE = {"ur10": "600 -100 200"}


def commands() -> list[list[str]]:
    """Those of the README, in their order."""
    return [shlex.split(line)[1:] for line in re.findall(r"^compensator .*$", README, re.M)]


@pytest.mark.parametrize("robot", builtin_robots())
def test_the_readme_from_a_mesh_to_a_verified_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, robot: str
) -> None:
    """init, check, preview, compensate, verify: with each built-in robot, its name and place put in."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(PART)
    verbs = [words[0] for words in commands()]
    assert verbs == ["init", "check", "preview", "compensate", "verify"]
    for words in commands():
        if words[0] == "init":
            words[words.index("--robot") + 1] = robot
            words[words.index("--part") + 1] = PLACE.get(robot, "1500 -100 800")
            words[words.index("--tool") + 1] = "0 0 250 5" if robot == "ur10" else "0 0 250 35"
        done = CliRunner().invoke(main, words)
        assert done.exit_code == 0, (words, done.output)
    assert done.stdout.startswith("part.mod: confirmed")
    error = json.loads(Path("part.json").read_text())["predicted_error_mm"]
    assert error["after"]["max"] < 0.1 * error["before"]["max"] and error["before"]["max"] > 0.05
    assert "sha256" in Path("part.mod").read_text() and Path("part.html").stat().st_size > 10_000


def test_the_head_of_the_cell_tells_the_next_commands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers typed in; then what stands in the cell is run as it stands."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(PART)
    answers = "abb-irb6600-175-255\n0 0 250 35\n1500 -100 800\npart.nc\nunknown\nkrl\n"
    done = CliRunner().invoke(main, ["init"], input=answers)
    assert done.exit_code == 0, done.output
    told = re.findall(r"^#   compensator (.*)$", Path("cell.toml").read_text(), re.M)
    assert [shlex.split(line)[0] for line in told] == ["check", "compensate", "verify"]
    for line in told:
        done = CliRunner().invoke(main, shlex.split(line))
        assert done.exit_code == 0, (line, done.output)
    assert done.stdout.startswith("part.src: confirmed")
