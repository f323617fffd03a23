"""Commands of the pages: every line is one that the program takes, and all of them run on a small job."""

from __future__ import annotations

import _thread
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import urllib.request
import webbrowser
from pathlib import Path

import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.tasks import plan
from tests.pages import page_folders as folders
from tests.pages.page_commands import DOCS, PAGES, commands, outputs, shell_lines, steps
from tests.pages.page_jobs import IN_A_SHELL, JOBS, POSTURES, PageJob


def test_every_page_with_commands_is_known() -> None:
    """A new page is run here, and no command hides behind another one in its line."""
    assert sorted({*JOBS, *IN_A_SHELL}) == PAGES
    hidden = re.compile(r"^[^`|>]*[;&|] *compensator [a-z]", re.M)
    assert [page.name for page in DOCS.glob("*.md") if hidden.search(page.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize("page", PAGES)
def test_the_program_takes_verb_and_options(page: str) -> None:
    for verb, *words in commands(page):
        if "--help" not in (verb, *words):
            with main.commands[verb].make_context(verb, words) as context:
                assert context.command.name == verb


@pytest.mark.parametrize("page", sorted(JOBS))
def test_what_stands_for_words_stands_for_words_of_the_page(page: str) -> None:
    lines = commands(page)
    job = JOBS[page]
    assert len(lines) == job.count
    assert {*job.files, *job.fewer} <= {word for line in lines for word in line}
    assert {*job.more} <= {line[0] for line in lines} and {*job.before} <= {*range(1, job.count)}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inputs") / "all"
    folders.everything(folder)
    return folder


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The pages that a browser was told to open; it reads them, and the user interrupts."""
    pages: list[str] = []

    def opened(url: str) -> None:
        try:
            with urllib.request.urlopen(url, timeout=60) as page:
                pages.append(page.read().decode())
        finally:
            _thread.interrupt_main()

    monkeypatch.setattr(webbrowser, "open", opened)
    return pages


def stamp(file: Path) -> tuple[int, int] | None:
    """What changes where a file is written."""
    return (file.stat().st_ino, file.stat().st_mtime_ns) if file.exists() else None


def holds_something(file: Path) -> bool:
    """Whether a file is not empty, and of the form that its name says."""
    content = file.read_bytes()
    if file.suffix in (".json", ".toml"):
        return bool({".json": json.loads, ".toml": tomllib.loads}[file.suffix](content.decode()))
    return bool(content)


def run(job: PageJob, verb: str, *words: str) -> None:
    """A command ends well, and everything that it names is there and new."""
    given = job.given(verb, words)
    named = outputs(verb, given)
    before = [stamp(file) for file in named]
    done = CliRunner().invoke(main, [verb, *given], input=job.typed)
    assert done.exit_code == 0, (verb, given, done.output)
    assert [file for file, old in zip(named, before, strict=True) if stamp(file) in (None, old)] == []
    assert [file for file in named if not holds_something(file)] == []


@pytest.mark.parametrize("page", sorted(JOBS))
def test_the_commands_of_a_page_run(
    page: str, inputs: Path, seen: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One after the other, in a folder with the files that they name: each ends well and writes what it is told to."""
    folder, job = tmp_path / page, JOBS[page]
    if job.folder is None:
        shutil.copytree(inputs, folder)
    else:
        job.folder(folder)
    monkeypatch.chdir(folder)
    monkeypatch.setattr(plan, "POSTURES", POSTURES)
    done = 0
    for program, *words in steps(page):
        if program == "mkdir":
            subprocess.run([program, *words], check=True)
            continue
        job.before.get(done, lambda _: None)(folder)
        run(job, *words)
        done += 1
    assert ["the cell at work" in text for text in seen] == [True] * (page == "view")


def shell(folder: Path) -> dict[str, str]:
    """The environment of a user whose home is a folder, with the program on the path."""
    program = folder / "bin" / "compensator"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m compensator "$@"\n')
    program.chmod(0o755)
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "PYTHON", "COV", "MAN"))}
    paths = {"PATH": f"{program.parent}:{env['PATH']}", "PYTHONPATH": f"{folder}:{DOCS.parent}"}
    return {**env, **paths, "HOME": str(folder), "OPENBLAS_NUM_THREADS": "1"}


@pytest.mark.parametrize("page", sorted(IN_A_SHELL))
def test_the_lines_of_a_page_run_in_a_shell(page: str, tmp_path: Path) -> None:
    """As they stand, pipes, home and comments included; man is stood for by cat where it is not installed."""
    folder = tmp_path / page
    IN_A_SHELL[page](folder)
    env = shell(folder)
    if shutil.which("man") is None:
        (folder / "bin" / "man").symlink_to(shutil.which("cat") or "")
    lines = shell_lines(page, "compensator", "mkdir")
    assert len(lines) >= 3
    for line in (one.replace("SESSION.toml", "session.toml") for one in lines):
        script = ["bash", "-e", "-o", "pipefail", "-c", line]
        done = subprocess.run(script, cwd=folder, env=env, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, (line, done.stderr)
        written = [folder / word.replace("~", str(folder)) for word in re.findall(r"(?: > | -o )(\S+)", line)]
        assert [file for file in written if not file.stat().st_size] == []
        assert done.stdout or written or line.startswith("mkdir"), line
