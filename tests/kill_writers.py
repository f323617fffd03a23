"""kill -9 at any moment of every verb that writes: inputs stay, an output is the old one or the new one, whole.

    python -m tests.kill_writers --kills 200 --seed 1

A verb is killed at random moments, half of them in its last fifth, where it writes, and right before each of its file
operations. Afterwards every input has to be what it was, every output the one that stood there (or none, where none
stood there) or the one that an undisturbed run writes, byte by byte; only hidden folders `.compensator-...` may be
left over, and the next run has to succeed beside them. The processes are forked from one that has imported everything.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from click.testing import CliRunner

from compensator.cli import main
from tests.mistakes.mistake import HIDDEN, contents, working_in
from tests.verb_jobs import JOBS, VerbJob, write_inputs

EVENTS = {"open", "os.rename", "os.link", "os.mkdir", "os.remove", "os.rmdir", "shutil.rmtree"}
LATE = 0.8  # of a run; behind that it writes
Files = dict[str, bytes | str]


def forked(verb: str, job: VerbJob, folder: Path, begin: Callable[[], object] = lambda: None) -> int:
    """Starts the verb in ``folder``; ``begin`` is called first, in the new process."""
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        time.monotonic = lambda: 0.0  # reports say how many seconds they took
        outputs = [word for option, name in job.writes.items() for word in (option, f"out/{name}")]
        with working_in(folder):
            begin()
            main([verb, *job.arguments, *outputs], prog_name="compensator")
    except SystemExit as end:
        status = int(end.code or 0)
    finally:
        os._exit(status)


def finished(child: int) -> int:
    """Its exit status; -9 where it was killed."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def killing_before(operation: int) -> Callable[[], object]:
    """Kills its own process before it does its file operation of that number."""
    left = [operation]

    def count(event: str, args: tuple[object, ...]) -> None:
        if event not in EVENTS or (event == "open" and not int(str(args[2])) & (os.O_WRONLY | os.O_RDWR)):
            return
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1

    return lambda: sys.addaudithook(count)


class KilledVerb:
    """A verb that is killed again and again.

    Args:
        old: whether outputs stand there from before.
    """

    def __init__(self, verb: str, inputs: Path, room: Path, *, old: bool) -> None:
        self.verb, self.job, self.inputs, self.room = verb, JOBS[verb], inputs, room
        self.runs, self.seen = 0, Counter[str]()
        self.old: Files = {f"out/{name}": f"old {name}".encode() for name in self.job.writes.values()} if old else {}
        folder = self._folder()
        began = time.perf_counter()
        status = finished(forked(verb, self.job, folder))
        self.seconds = time.perf_counter() - began
        self.new = {name: text for name, text in contents(folder).items() if name.startswith("out/")}
        self.given = contents(inputs)
        count = len(self.job.writes) + len(self.job.beside)
        assert status == 0 and len(self.new) == count, (verb, status, sorted(self.new))

    def _folder(self) -> Path:
        self.runs += 1
        folder = self.room / f"{self.verb}-{self.runs}{'-old' if self.old else ''}"
        shutil.copytree(self.inputs, folder)
        for name, text in self.old.items():
            (folder / name).write_bytes(bytes(text))
        return folder

    def kill_after(self, seconds: float) -> None:
        folder = self._folder()
        child = forked(self.verb, self.job, folder)
        time.sleep(seconds)
        os.kill(child, signal.SIGKILL)
        finished(child)
        self._check(folder, f"killed after {seconds:.4f} s")
        shutil.rmtree(folder)

    def kill_before_operation(self, number: int) -> bool:
        """Whether there was such an operation."""
        folder = self._folder()
        status = finished(forked(self.verb, self.job, folder, killing_before(number)))
        self._check(folder, f"killed before file operation {number}")
        if status == 0:
            return False
        assert status == -signal.SIGKILL, status
        outputs = contents(folder).keys() & self.new.keys()
        if number % 4 == 0 and (self.job.overwrites or not outputs):
            assert finished(forked(self.verb, self.job, folder)) == 0, f"{self.verb}: the next run fails in {folder}"
            said = self.job.writes.get("--json") if self.job.keeps else None  # it says how much was there
            wanted = {name: text for name, text in self.new.items() if name != f"out/{said}"}
            assert wanted.items() <= contents(folder).items()
        shutil.rmtree(folder)
        return True

    def _check(self, folder: Path, when: str) -> None:
        place, keeps = f"{self.verb} {when}", self.job.keeps
        self.seen[left_over(folder, given=self.given, old=self.old, new=self.new, place=place, keeps=keeps)] += 1


def left_over(
    folder: Path, *, given: Files, old: Files, new: Files, place: str, keeps: tuple[str, ...] = ()
) -> str:
    """What stands in a folder after a kill: all outputs old, all new, or some of them new.

    Raises:
        AssertionError: an input has changed, an output is neither the old one nor the new one, or there is more.
    """
    found, states = contents(folder), set()
    for name, text in given.items():
        assert found.pop(name, None) == text, f"{place}: {name} is not what it was, see {folder}"
    for name, text in new.items():
        there = found.pop(name, None)
        assert there in (text, old.get(name)), f"{place}: {name} is neither the old nor the new one, see {folder}"
        states.add("new" if there == text else "old")
    kept = tuple(f"out/{name}/" for name in keeps)
    found = {name: text for name, text in found.items() if HIDDEN not in name and not name.startswith(kept)}
    assert not found, f"{place}: {sorted(found)} is left over in {folder}"
    return "some new" if len(states) == 2 else f"all {states.pop()}"


def import_all(verb: str, inputs: Path, room: Path) -> None:
    """Runs a verb in this process, so that those that are forked from it begin with its work."""
    folder = room / "first"
    shutil.copytree(inputs, folder)
    asked = [word for option, name in JOBS[verb].writes.items() for word in (option, f"out/{name}")]
    with working_in(folder):
        done = CliRunner().invoke(main, [verb, *JOBS[verb].arguments, *asked])
    assert done.exit_code == 0, done.output
    shutil.rmtree(folder)


def kill(verb: str, kills: int, inputs: Path, room: Path, chance: random.Random) -> str:
    """Kills a verb; what was seen."""
    told = []
    cases = (True, False) if JOBS[verb].overwrites else (False,)
    for old in cases:
        victim = KilledVerb(verb, inputs, room, old=old)
        for k in range(kills // len(cases)):
            begin = LATE if k % 2 else 0.0
            victim.kill_after(victim.seconds * chance.uniform(begin, 1.05))
        operation = 0
        while victim.kill_before_operation(operation):
            operation += 1
        before = "over old outputs" if old else "without old outputs"
        states = ", ".join(f"{count} {state}" for state, count in sorted(victim.seen.items()))
        where = f"{kills // len(cases)} random moments in {victim.seconds:.2f} s, before {operation} file operations"
        told.append(f"{before}: {where}: {states}")
    return "; ".join(told)


def run() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="random moments for each verb")
    parser.add_argument("--verbs", nargs="*", default=sorted(JOBS), choices=sorted(JOBS))
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        inputs, room = Path(folder) / "inputs", Path(folder) / "room"
        inputs.mkdir()
        room.mkdir()
        write_inputs(inputs)
        for verb in asked.verbs:
            import_all(verb, inputs, room)
            print(f"{verb}: {kill(verb, asked.kills, inputs, room, random.Random(asked.seed))}", flush=True)


if __name__ == "__main__":
    run()
