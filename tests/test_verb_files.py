"""No verb writes over what it reads, nor one output over another: over every verb and option that click knows."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from compensator.cli import main
from compensator.command_line import INPUT, OUTPUT
from compensator.tasks import run_files
from tests.verb_jobs import JOBS, files_of, outputs, write_inputs

WRITING = sorted(verb for verb, command in main.commands.items() if any(p.type is OUTPUT for p in command.params))
WORKING = re.compile(r"^(solving|predicting|fitting|choosing|writing|looking|following|\d)", re.M)  # of --verbose
CASES = [(verb, option) for verb in WRITING for option in outputs(verb)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The inputs of all jobs."""
    folder = tmp_path_factory.mktemp("inputs")
    write_inputs(folder)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A copy of them, the working folder; afterwards it holds what it held."""
    here = tmp_path / "job"
    shutil.copytree(made, here)
    monkeypatch.chdir(here)
    yield here
    for file in made.iterdir():
        if file.is_file():
            assert (here / file.name).read_bytes() == file.read_bytes(), f"{file.name} was changed"
    assert sorted(p.name for p in here.iterdir()) == sorted(p.name for p in made.iterdir())


def run(verb: str, over: dict[str, str]) -> Result:
    """The job of a verb with its outputs, some of them in other places."""
    job = JOBS[verb]
    must = [p.opts[0] for p in main.commands[verb].params if p.required and p.type is OUTPUT]
    needed = {option: f"out/{job.writes[option]}" for option in must}
    asked = [word for pair in {**needed, **over}.items() for word in pair]
    return CliRunner().invoke(main, [verb, *job.arguments, *asked, "--verbose"])


def refused(done: Result, words: str) -> None:
    """One message, before anything is computed."""
    assert done.exit_code == 1, done.output
    last = done.stderr.splitlines()[-1]
    assert last.startswith("compensator: ") and words in last, done.stderr
    assert done.stdout == "" and not WORKING.search(done.stderr), done.stderr


def test_every_file_of_a_verb_is_an_input_or_an_output() -> None:
    """A file option of another kind would be outside of what is tested here."""
    files = [(verb, p) for verb, command in main.commands.items() for p in files_of(command)]
    assert [f"{verb} {p.opts[0]}" for verb, p in files if p.type not in (INPUT, OUTPUT)] == []


def test_every_verb_that_writes_has_a_job() -> None:
    """With all of its outputs: add it to tests/verb_jobs.py."""
    assert {verb: set(outputs(verb)) for verb in WRITING} == {verb: set(job.writes) for verb, job in JOBS.items()}


@pytest.mark.parametrize(("verb", "option"), CASES)
def test_no_output_over_an_input(folder: Path, verb: str, option: str) -> None:
    """Whatever its spelling."""
    spellings: list[Callable[[Path], str]] = [_as_is, _the_long_way, _symbolic_link, _hard_link]
    for k, name in enumerate(JOBS[verb].reads):
        for spelling in (spellings if option == CASES[0][1] or k == 0 else spellings[-1:]):
            target = spelling(folder / name)
            refused(run(verb, {option: target}), f"{target}: is an input of this run")
            (folder / "out" / "link.toml").unlink(missing_ok=True)


def _as_is(file: Path) -> str:
    return file.name


def _the_long_way(file: Path) -> str:
    return f"out/../{file.name}"


def _symbolic_link(file: Path) -> str:
    (file.parent / "out" / "link.toml").symlink_to(f"../{file.name}")
    return "out/link.toml"


def _hard_link(file: Path) -> str:
    os.link(file, file.parent / "out" / "link.toml")
    return "out/link.toml"


@pytest.mark.parametrize("verb", [verb for verb in WRITING if len(outputs(verb)) > 1])
def test_no_two_outputs_in_one_file(folder: Path, verb: str) -> None:
    """A file that is there already, or is not, under two spellings."""
    one, other, *_ = outputs(verb)
    refused(run(verb, {one: "out/a.toml", other: str(folder / "out" / "a.toml")}), "is asked for twice")
    (folder / "out" / "real.toml").write_text("")
    (folder / "out" / "link.toml").symlink_to("real.toml")
    refused(run(verb, {one: "out/real.toml", other: "out/link.toml"}), "is asked for twice")
    refused(run(verb, {one: "-", other: "-"}), "is asked for twice")
    for file in (folder / "out").iterdir():
        file.unlink()


@pytest.mark.parametrize("verb", WRITING)
def test_no_output_among_the_files_of_the_program(folder: Path, verb: str) -> None:
    """The data of built-in robots, read or not."""
    data = Path(run_files.__file__).parents[2] / "stiffness" / "robot" / "data" / "ur10.toml"
    before = data.read_bytes()
    refused(run(verb, {outputs(verb)[0]: str(data)}), "lies among the files of this program")
    assert data.read_bytes() == before


def test_the_second_file_of_a_program_is_no_input(tmp_path: Path) -> None:
    """Only its writer knows the name: it is looked at before anything is put in place."""
    @run_files.writes("target")
    def task(target: Path) -> None:
        from compensator.tasks.outputs import Outputs

        (tmp_path / "a.dat").read_text()
        with Outputs() as outs, outs.writing(target) as staged:
            staged.write_text("new")
            staged.with_suffix(".dat").write_text("new")
            outs.add(staged, target, (staged.with_suffix(".dat"),))
            outs.commit()

    (tmp_path / "a.dat").write_text("old")
    with pytest.raises(Exception, match=r"a\.dat: is an input of this run"):
        task(tmp_path / "a.SRC")
    assert [p.name for p in tmp_path.iterdir()] == ["a.dat"] and (tmp_path / "a.dat").read_text() == "old"


def test_an_output_that_no_task_declares_is_not_written(tmp_path: Path) -> None:
    """So that a new output cannot be forgotten."""
    from compensator.tasks.outputs import Outputs

    @run_files.writes("target")
    def task(target: Path) -> None:
        with Outputs() as outs:
            outs.text(tmp_path / "other.txt", "new")

    with pytest.raises(RuntimeError, match="not among the outputs"):
        task(tmp_path / "a.txt")
