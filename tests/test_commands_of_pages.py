"""Commands of the pages: every line is one that the program takes, and those of most pages run on a small job."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path
from shutil import copytree

import pytest
from click.testing import CliRunner

from compensator.cli import main
from tests import verb_jobs
from tests.compensator import small_job
from tests.compensator.api.test_python_page import PART
from tests.oracles.robot_programs import RAPID

DOCS = Path(__file__).parents[1] / "docs"
ELSEWHERE = {
    "command-line": "tests/compensator/terminal",
    "first-part": "tests/test_first_part.py",
    "init": "tests/compensator/tasks/test_init_files.py",
    "own-effect": "tests/test_own_effect.py",
    "traces": "tests/compensator/trace",
    "traces-from-devices": "tests/compensator/devices",
    "toolpaths-in": "tests/toolpaths/languages/krl",
    "tutorial": "tests/test_blind_walk.py",
    "view": "tests/compensator/report/test_view_in_browser.py",
}
"""Pages whose commands need files of their own, or a minute; and the tests that run the like."""
MINUTES = {"measure-in-a-day", "place", "plan"}
"""Pages whose commands take minutes: plans of 20 set-ups, hundreds of placements; verb and options are looked at."""


@dataclass(frozen=True)
class PageJob:
    """What stands for the words of a page.

    Attributes:
        files: word of the page -> file of the small job.
        count: how many commands the page has.
    """

    count: int
    files: dict[str, str] = field(default_factory=dict)


PART_NC, MODEL = {"part.nc": "path.csv"}, {"stiffness.toml": "model.toml"}
JOBS = {
    "axis-map": PageJob(1, {"TOOLPATH": "path.csv", "CELL.toml": "cell.toml"}),
    "check": PageJob(2, PART_NC),
    "clamped": PageJob(1, {"READINGS.csv": "readings.csv", "ROBOT": "geared.toml"}),
    "compare": PageJob(2, {"before.json": "one.json", "after.json": "other.json"}),
    "compensate": PageJob(2, PART_NC),
    "cutting": PageJob(3, {**PART_NC, "cell.toml": "mill.toml"}),
    "datasheet": PageJob(1, {"ROBOT": "geared.toml"}),
    "diagnose": PageJob(1, MODEL),
    "filter": PageJob(1, {"PART.mod": "plain/part.mod", "cell.toml": "plain/cell.toml"}),
    "identify": PageJob(2, {"other.toml": "session.toml"}),
    "stiffness-map": PageJob(1, {"MODEL.toml": "model.toml"}),
    "verify": PageJob(2, {"part.mod": "program.mod", **PART_NC}),
}


def commands(page: str) -> list[list[str]]:
    """Words of every command of a page; what may be left out is given, but for "more of the same"."""
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8").replace("\\\n", " ")
    lines = re.findall(r"^ *compensator +([a-z-][^\n]*)$", text, re.M)
    plain = (re.sub(r"\[more [^\]]*\]", "", re.split(r" [|>#] ?", line)[0]) for line in lines)
    return [shlex.split(re.sub(r"\[([^\]]*)\]", r"\1", line)) for line in plain]


PAGES = sorted(p.stem for p in DOCS.glob("*.md") if commands(p.stem))


def test_every_page_with_commands_is_known() -> None:
    """A new page is run here, or it stands where its commands are run."""
    assert sorted({*JOBS, *ELSEWHERE, *MINUTES}) == PAGES
    assert [place for place in ELSEWHERE.values() if not (DOCS.parent / place).exists()] == []


@pytest.mark.parametrize("page", PAGES)
def test_the_program_takes_verb_and_options(page: str) -> None:
    for verb, *words in commands(page):
        if "--help" not in (verb, *words):
            with main.commands[verb].make_context(verb, words) as context:
                assert context.command.name == verb


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inputs")
    verb_jobs.write_inputs(folder)
    (folder / "part.nc").write_text(PART)
    (folder / "plain").mkdir()
    small_job.files(folder / "plain")
    (folder / "plain" / "part.mod").write_bytes(RAPID.replace("\n", "\r\n").encode())
    return folder


@pytest.mark.parametrize("page", sorted(JOBS))
def test_the_commands_of_a_page_run(
    page: str, inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One after the other, in a folder with the files that they name: each ends well and writes what it is told to."""
    folder, job = tmp_path / page, JOBS[page]
    copytree(inputs, folder)
    monkeypatch.chdir(folder)
    lines = commands(page)
    assert len(lines) == job.count
    for verb, *words in lines:
        given = [job.files.get(word, word) for word in words]
        done = CliRunner().invoke(main, [verb, *given])
        assert done.exit_code == 0, (verb, given, done.output)
        written = [given[k + 1] for k, word in enumerate(given) if word in verb_jobs.outputs(verb)]
        assert [name for name in written if not Path(name).stat().st_size] == []
