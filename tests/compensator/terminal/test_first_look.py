"""What a new user sees: examples, completion, man page, a screen of 80 x 24, percent and time left, NO_COLOR."""

from __future__ import annotations

import json
import os
import pty
import re
import shlex
import struct
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from compensator.cli import main
from compensator.terminal.time_left import TimeLeft, left_words
from compensator.verb_examples import EXAMPLES
from tests.compensator.small_job import files
from toolpaths.steps import heard_by, tell


@pytest.mark.parametrize("verb", sorted(main.commands))
def test_two_examples_that_the_verb_takes(verb: str) -> None:
    """Both stand in --help, and are parsed; those with a shell after them up to there."""
    command = main.commands[verb]
    assert len(EXAMPLES[verb]) == 2
    shown = CliRunner().invoke(main, [verb, "--help"]).stdout
    for example in EXAMPLES[verb]:
        assert f"compensator {example}" in shown
        name, *words = shlex.split(re.split(r" [|>] ", example)[0])
        assert name == verb
        with command.make_context(verb, list(words)) as context:
            assert context.command is command


def test_no_examples_of_other_verbs() -> None:
    assert set(EXAMPLES) == set(main.commands)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion(shell: str) -> None:
    """What the shell will ask the command, and that it answers."""
    script = CliRunner().invoke(main, ["completion", shell]).stdout
    assert f"_COMPENSATOR_COMPLETE={shell}_complete" in script
    asked = {"_COMPENSATOR_COMPLETE": "bash_complete", "COMP_WORDS": "compensator pre", "COMP_CWORD": "1"}
    run = [sys.executable, "-m", "compensator"]
    if shell == "bash":
        done = subprocess.run(run, env={**os.environ, **asked}, capture_output=True, text=True, check=False)
        assert "preview" in done.stdout


def test_the_man_page_has_every_verb_and_option() -> None:
    """Lines of roff; nothing of a text is taken for a macro."""
    page = CliRunner().invoke(main, ["man"]).stdout
    plain = page.replace("\\-", "-").replace("\\e", "\\").replace("\\&", "")
    for name, command in main.commands.items():
        assert f".SS {name}\n" in plain
        for option in (p for p in command.params if isinstance(p, click.Option)):
            assert f"{option.opts[-1]}" in plain
        assert all(f"compensator {' '.join(e.split())}" in plain for e in EXAMPLES[name])
    assert {line.split()[0] for line in page.splitlines() if line.startswith(".")} == {
        ".TH", ".SH", ".B", ".SS", ".PP", ".TP", ".nf", ".fi",
    }  # fmt: skip


def on_a_screen(folder: Path, *words: str, **environment: str) -> str:
    """What a terminal of 80 x 24 gets."""
    import fcntl
    import termios

    child, screen = pty.fork()
    if not child:
        os.chdir(folder)
        os.environ.update({"TERM": "xterm-256color", **environment})
        os.execv(sys.executable, [sys.executable, "-m", "compensator", *words])
    fcntl.ioctl(screen, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    seen = b""
    while True:
        try:
            more = os.read(screen, 65536)
        except OSError:  # the child has gone
            break
        if not more:
            break
        seen += more
    os.waitpid(child, 0)
    os.close(screen)
    return seen.decode()


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("screen")
    files(folder)
    root = str(Path(__file__).parents[3])
    words = ("compensate", "path.csv", "--cell", "cell.toml", "-o", "out/part.mod")
    return on_a_screen(folder, *words, NO_COLOR="1", PYTHONPATH=root, XDG_CACHE_HOME=str(folder / "cache"))


def test_eighty_by_twenty_four(seen: str) -> None:
    """The result first, then warnings, then notes; all within the screen; no colours."""
    last = seen.rpartition("\x1b[?25h")[2] if "\x1b[?25h" in seen else seen
    shown = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", line) for line in last.split("\r\n")]
    text = "\n".join(shown)
    assert text.index("predicted TCP error") < text.index("wrote out/part.mod") < text.index("note: ")
    assert sum(max(1, -(-len(line) // 80)) for line in shown if line.strip()) <= 23
    assert "more notes: --verbose shows all" in text
    assert re.findall(r"\x1b\[(?:\d+;)*(?:3[0-7]|9[0-7]|4[0-7]|38|48)[;m]", seen) == []


def test_percent_and_time_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By what this machine keeps of such a run, for inputs of twice the size; never backwards, never done too early."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    kept = tmp_path / "toolpath-compensator" / "durations.json"
    now = [0.0]
    first = TimeLeft("preview", 1000, lambda: now[0])
    for stage, seconds in (("reading it", 1.0), ("predicting", 7.0), ("drawing", 2.0)):
        first.stage(stage)
        now[0] += seconds
    first.keep()
    stages = {"reading": 1.0, "predicting": 7.0, "drawing": 2.0}
    assert json.loads(kept.read_text())["preview"] == {"size": 1000.0, **stages}
    again = TimeLeft("preview", 2000, lambda: now[0])
    begun, shares = now[0], []
    for stage, seconds in (("reading other", 2.0), ("predicting", 14.0), ("drawing", 4.0)):
        again.stage(stage)
        for _ in range(10):
            now[0] += seconds / 10
            share, left = again.now()
            shares.append(share)
            assert share == pytest.approx((now[0] - begun) / 20, abs=0.06)
            assert left == pytest.approx(20 - (now[0] - begun), abs=1.3)
    assert shares == sorted(shares) and shares[-1] <= 0.99
    now[0] += 100
    assert again.now()[0] <= 0.99
    words = [left_words(s) for s in (0.2, 30.0, 300.0)]
    assert words == ["almost done", "about 30 s left", "about 5 min left"]


def test_a_loop_that_tells_its_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a record the first run of a long stage is known by how far its loop is; the next stage forgets it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    now = [0.0]
    clock = TimeLeft("preview", 1000, lambda: now[0])
    clock.stage("predicting")
    with heard_by(clock.step):
        for done in (100, 250, 500):
            now[0] = 400.0 * done / 1000
            tell(done, 1000)
            assert clock.now()[1] == pytest.approx(400 - now[0], rel=0.05)
    tell(1, 2)  # nobody listens
    clock.stage("drawing")
    assert clock.now()[1] < 60


@pytest.mark.parametrize("text", ["", "[]", '{"preview": 3}', '{"preview": {"solving": "long"}}'])
def test_a_record_that_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """The usual figures serve."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (tmp_path / "toolpath-compensator").mkdir()
    (tmp_path / "toolpath-compensator" / "durations.json").write_text(text)
    clock = TimeLeft("preview", 10, lambda: 0.0)
    clock.stage("predicting")
    assert 0.0 <= clock.now()[0] < 0.2
