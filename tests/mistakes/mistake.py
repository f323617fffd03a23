"""Mistake: a command in a folder where something is wrong, and what comes of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from click.testing import CliRunner

from compensator.cli import main
from tests.oracles.patience import not_hanging

Spoil = Callable[[Path], None]
HIDDEN = ".compensator-"


@dataclass(frozen=True)
class Mistake:
    """What a user does wrong.

    Attributes:
        what: in his words.
        command: what he types behind ``compensator``, in the folder of the inputs.
        spoil: what is wrong there; it is given the folder.
        outputs: files that the command may write, because it does what was asked.
    """

    what: str
    command: str
    spoil: Spoil = field(default=lambda folder: None)
    outputs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What came of it.

    Attributes:
        status: exit status.
        said: on standard error, see ``joined``.
        left: files that were not there before, sorted.
    """

    status: int
    said: str
    left: tuple[str, ...]


def made(mistake: Mistake, folder: Path) -> Outcome:
    """Makes the mistake in ``folder``, which holds the inputs.

    Raises:
        AssertionError: a traceback, a hang, or a file that was there before has changed.
    """
    mistake.spoil(folder)
    before = contents(folder)
    with working_in(folder), not_hanging(60.0):
        done = CliRunner().invoke(main, mistake.command.split(), prog_name="compensator")
    after = contents(folder)
    lost = [name for name, content in before.items() if after.get(name) != content and name not in mistake.outputs]
    assert lost == [], f"{mistake.what}: {lost} changed"
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exc_info
    assert "Traceback" not in done.stderr, done.stderr
    assert not any(HIDDEN in name for name in after), after.keys()
    left = tuple(sorted(after.keys() - before.keys()))
    assert done.exit_code == 0 or left == (), f"{mistake.what}: refused, and {left} left behind"
    return Outcome(done.exit_code, joined(done.stderr).replace(f"{folder}{os.sep}", ""), left)


def joined(stderr: str) -> str:
    """Lines of standard error as one; notes, which every run of the small job has, are left out."""
    return " ⏎ ".join(line.strip() for line in stderr.splitlines() if line.strip() and not line.startswith("note: "))


def contents(folder: Path) -> dict[str, bytes | str]:
    """Name -> bytes of every file, links as where they lead to."""
    found = (p for p in sorted(folder.rglob("*")) if p.is_symlink() or p.is_file())
    return {str(p.relative_to(folder)): os.readlink(p) if p.is_symlink() else p.read_bytes() for p in found}


@contextmanager
def working_in(folder: Path) -> Iterator[None]:
    """The working folder, for a while."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def edit(name: str, old: str, new: str, count: int = 1) -> Spoil:
    """Some of the text of a file replaced."""

    def spoil(folder: Path) -> None:
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text, f"{name} has no {old!r}"
        (folder / name).write_text(text.replace(old, new, count), encoding="utf-8")

    return spoil


def write(name: str, content: str | bytes) -> Spoil:
    """A file with other content, or one more."""

    def spoil(folder: Path) -> None:
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())

    return spoil


def both(*spoils: Spoil) -> Spoil:
    """One after the other."""

    def spoil(folder: Path) -> None:
        for each in spoils:
            each(folder)

    return spoil
