"""Time left: what share of a run is done, from how long its stages took before."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

Seconds = dict[str, float]

#: Seconds of the stages of a verb, by the first word of what is said, where the machine has no record of its own.
USUAL: dict[str, Seconds] = {
    "compensate": {"reading": 0.5, "solving": 8.0, "writing": 0.5, "verifying": 1.0, "drawing": 2.0},
    "preview": {"reading": 0.5, "predicting": 4.0, "drawing": 2.0},
    "check": {"reading": 0.5, "following": 0.5, "predicting": 3.0, "solving": 6.0, "looking": 4.0},
    "verify": {"reading": 1.0, "solving": 8.0},
    "identify": {"reading": 0.5, "fitting": 6.0, "writing": 1.0},
    "diagnose": {"reading": 0.5, "diagnosing": 30.0, "writing": 1.0},
    "evaluate": {"reading": 0.5, "predicting": 3.0},
    "plan": {"reading": 0.5, "looking": 1.0, "following": 2.0, "choosing": 4.0, "writing": 0.2},
    "stiffness-map": {"reading": 0.5, "postures": 4.0, "drawing": 1.0},
}
OTHER: Seconds = {"working": 2.0}
SLOWEST, FASTEST = 20.0, 0.05  # times that a machine may differ from the record
LEAST = 0.05  # share of a stage that is left however long it takes
LARGEST = 0.99  # that is shown before the end


class TimeLeft:
    """The clock of one run.

    Args:
        verb: of the command line. size: bytes of its inputs. clock: s.
    """

    def __init__(self, verb: str, size: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._verb, self._size, self._clock = verb, max(size, 1), clock
        self._expected = _scaled(_recorded().get(verb, {}), self._size) or dict(USUAL.get(verb, OTHER))
        self._begun = self._stage_begun = clock()
        self._stage = ""
        self._rest: float | None = None  # s, of the loop that tells its steps
        self._done: Seconds = {}
        self._shown = 0.0

    def __repr__(self) -> str:
        return f"TimeLeft({self._verb!r}, {self._stage!r})"

    @property
    def elapsed(self) -> float:
        """s since the run began."""
        return self._clock() - self._begun

    def stage(self, text: str) -> None:
        """Another stage begins."""
        now = self._clock()
        if self._stage:
            self._done[self._stage] = self._done.get(self._stage, 0.0) + now - self._stage_begun
        self._stage, self._stage_begun, self._rest = (text.split() or [""])[0], now, None

    def step(self, done: int, of: int) -> None:
        """A loop of the stage at hand is so far; what it will take is better known by that than by any record."""
        within = self._clock() - self._stage_begun
        self._rest = within * (of - done) / done if 0 < done < of else None

    def now(self) -> tuple[float, float]:
        """Share done, which never falls, and s left."""
        within = self._clock() - self._stage_begun
        gone = {name: s for name, s in self._done.items() if name != self._stage}
        known = sum(self._expected.get(name, 0.0) for name in gone)
        pace = min(max(sum(gone.values()) / known, FASTEST), SLOWEST) if known > 0.2 else 1.0
        own = pace * self._expected.get(self._stage, 0.0)
        names = list(self._expected)
        at = names.index(self._stage) if self._stage in names else -1
        later = pace * sum(self._expected[name] for name in names[at + 1 :] if name not in gone)
        rest = own - within if self._rest is None else self._rest
        left = max(rest, LEAST * max(own, within)) + later
        elapsed = max(self.elapsed, 1e-9)
        self._shown = min(max(self._shown, elapsed / (elapsed + left)), LARGEST)
        return self._shown, left

    def keep(self) -> None:
        """Keep how long the stages of a run that ended well took, for the next one."""
        self.stage("")
        with suppress(OSError, ValueError):
            known = _recorded() | {self._verb: {"size": float(self._size), **self._done}}
            file = _file()
            file.parent.mkdir(parents=True, exist_ok=True)
            beside = file.with_suffix(f".{os.getpid()}")
            beside.write_text(json.dumps(known))
            beside.replace(file)


def left_words(seconds: float) -> str:
    """In words, coarse as the guess is."""
    if seconds < 1.0:
        return "almost done"
    if seconds < 90.0:
        return f"about {seconds:.0f} s left"
    return f"about {seconds / 60:.0f} min left"


def size_of(paths: Sequence[Path]) -> int:
    """Bytes of the files that are there."""
    total = 0
    for path in paths:
        with suppress(OSError):
            total += path.stat().st_size
    return total


def _scaled(record: Seconds, size: int) -> Seconds:
    """The record of a run for inputs of another size."""
    before = record.get("size", 0.0)
    if before <= 0.0:
        return {}
    scale = min(max(size / before, FASTEST), SLOWEST)
    return {name: s * scale for name, s in record.items() if name != "size"}


def _file() -> Path:
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or Path.home() / ".cache"
    return Path(home) / "toolpath-compensator" / "durations.json"


def _recorded() -> dict[str, Seconds]:
    """What this machine keeps; nothing where it cannot be read or is something else."""
    try:
        found = json.loads(_file().read_text())
        return {
            str(verb): {str(k): float(v) for k, v in stages.items() if 0.0 <= float(v) < 1e12}
            for verb, stages in found.items()
        }
    except (OSError, ValueError, AttributeError, TypeError):
        return {}
