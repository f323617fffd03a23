"""Filter: how a language changes a finished program in place. It comes back byte by byte, but for its cutting moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from toolpaths.finding import WARNING, Finding

#: A correction below these, m and rad, is none: the numbers stay as they are printed.
SAME_PLACE = 5e-8
SAME_TURN = 2e-8


@dataclass(frozen=True, repr=False)
class Rewritten:
    """A program with other poses.

    Attributes:
        text: the whole file; of several, the main one.
        changes: what else than pose numbers changed (poses put in, targets split, arcs made lines), as warnings.
        beside: the other files of the program: those that share its name by suffix (``.dat`` of KRL), else by name.
        kept: files of the program that hold neither moves nor what changed: they stay where they are.
    """

    text: bytes
    changes: tuple[Finding, ...] = ()
    beside: Sequence[tuple[str, bytes]] = ()
    kept: tuple[Path, ...] = ()

    def __repr__(self) -> str:
        return f"Rewritten({len(self.text)} bytes, {len(self.changes)} changes)"


def _keeps_everything(source: bytes, path: Path) -> None:
    return None


def _says_every_turn(source: bytes) -> bool:
    return True


@dataclass(frozen=True, kw_only=True)
class Filter:
    """What ``languages/NAME/filter.py`` offers as FILTER.

    Attributes:
        rewrite: (source, program, row, path) -> Rewritten: the file ``source`` (read from ``path``) with the poses of
            ``program``; ``row`` is theirs in Toolpath.row. Where the language is on a machine, that comes last; where
            its programs have several files, the paths of the others (None: those beside). A
            WriteError names the line where a pose cannot be put in place.
        check: (source, path): WriteError, before anything is solved, where the file holds what cannot be kept.
        says_turns: (source) -> whether the file has words for the orientation of the tool.
    """

    rewrite: Callable[..., Rewritten]
    check: Callable[[bytes, Path], None] = _keeps_everything
    says_turns: Callable[[bytes], bool] = _says_every_turn


def calls_elsewhere(elsewhere: Mapping[str, int]) -> Iterator[Finding]:
    """Warnings for calls (name -> line) of what is not in the file."""
    for name, line in elsewhere.items():
        what = f"{name} is not in this file: it is taken to leave the arm where it is"
        yield Finding(WARNING, f"line {line}", what, "its moves are not compensated, if it has any")
