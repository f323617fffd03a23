"""Mistakes and mishaps that take a process of its own: signals, full disks, pipes that nobody reads."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.mistakes.mistake import HIDDEN, Outcome, contents, joined

ROOT = Path(__file__).parents[2]
SMALL = 2000  # bytes that a file may grow to where the disk is taken to be full


@dataclass(frozen=True)
class Mishap:
    """A command in a process of its own.

    Attributes:
        what, command: as of a Mistake.
        run: (command, folder) -> exit status and what it said.
    """

    what: str
    command: str
    run: Callable[[list[str], Path], tuple[int, str]]


def happened(mishap: Mishap, folder: Path) -> Outcome:
    """Makes it happen in ``folder``; what was there before must not have changed."""
    before = contents(folder)
    command = [sys.executable, "-m", "compensator.cli", *mishap.command.split()]
    status, said = mishap.run(command, folder)
    after = contents(folder)
    assert {name: after.get(name) for name in before} == before
    assert "Traceback" not in said, said
    hidden = any(folder.glob(f"{HIDDEN}*"))
    new = [name for name in after.keys() - before.keys() if HIDDEN not in name]
    left = (*sorted(new), *(["a hidden folder"] if hidden else []))
    return Outcome(status, joined(said), left)


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


def to_full_disk(command: list[str], folder: Path) -> tuple[int, str]:
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            command, cwd=folder, env=environment(), stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    return run.returncode, run.stderr


def to_nobody(command: list[str], folder: Path) -> tuple[int, str]:
    reading, writing = os.pipe()
    os.close(reading)
    run = subprocess.run(
        command, cwd=folder, env=environment(), stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    return run.returncode, run.stderr


def on_full_disk(command: list[str], folder: Path) -> tuple[int, str]:
    """No file may grow: a full disk, as the kernel says it."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL, SMALL))

    command = [command[0], "-B", *command[1:]]
    run = subprocess.run(
        command, cwd=folder, env=environment(), preexec_fn=limit, capture_output=True, text=True, check=False
    )
    return run.returncode, run.stderr


def signalled(number: signal.Signals, place: str) -> Callable[[list[str], Path], tuple[int, str]]:
    """A signal at a place: see tests/signal_itself.py."""

    def run(command: list[str], folder: Path) -> tuple[int, str]:
        python, arguments = command[0], command[3:]
        done = subprocess.run(
            [python, "-m", "tests.signal_itself", place, str(int(number)), *arguments, "--verbose"],
            cwd=folder, env=environment(), capture_output=True, text=True, check=False,
        )  # fmt: skip
        status = done.returncode if done.returncode >= 0 else 128 - done.returncode
        return status, "\n".join(line for line in done.stderr.splitlines() if line.startswith("compensator"))

    return run


COMPENSATE = "compensate part.nc --cell cell.toml -o part.csv --json part.json"
MISHAPS = (
    Mishap("the disk is full", COMPENSATE, on_full_disk),
    Mishap("standard output is a full disk", "robots", to_full_disk),
    Mishap("a program to a full standard output", COMPENSATE.replace("part.csv", "- --format rapid"), to_full_disk),
    Mishap("nobody reads the pipe", "effects", to_nobody),
    Mishap("Ctrl-C while it reads", COMPENSATE, signalled(signal.SIGINT, "reading part.nc")),
    Mishap("Ctrl-C while it solves", COMPENSATE, signalled(signal.SIGINT, "solving")),
    Mishap("kill while it solves", COMPENSATE, signalled(signal.SIGTERM, "solving")),
    Mishap("kill -9 while it puts the outputs in place", COMPENSATE, signalled(signal.SIGKILL, "os.rename")),
)
