"""Lines by which a program on the disk differs from the one that is written now, whatever their heads tell."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from compensator.program.provenance import without_head


@dataclass(frozen=True)
class ChangedLine:
    """A line of a file, counted from 1 as it stands; ``written`` and ``stands``: without it, an empty text."""

    file: str
    line: int
    written: str
    stands: str


def changed_lines(written: Path, standing: Path) -> Iterator[ChangedLine]:
    """Compare two files line by line; where lines came or went, by the longest common run."""
    a, b = _lines(written), _lines(standing)
    if len(a) == len(b):
        blocks = [("replace", k, k + 1, k, k + 1) for k, (x, y) in enumerate(zip(a, b, strict=True)) if x != y]
    else:
        first = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
        last = _alike_at_the_end(a[first:], b[first:])
        matcher = difflib.SequenceMatcher(None, a[first : len(a) - last], b[first : len(b) - last], autojunk=True)
        found = [op for op in matcher.get_opcodes() if op[0] != "equal"]
        blocks = [(kind, i + first, j + first, m + first, n + first) for kind, i, j, m, n in found]
    for _, i, j, m, n in blocks:
        for k in range(max(j - i, n - m)):
            old, new = (a[i + k] if i + k < j else ""), (b[m + k] if m + k < n else "")
            yield ChangedLine(standing.name, min(m + k, max(len(b) - 1, 0)) + 1, old, new)


def _lines(file: Path) -> list[str]:
    return without_head(file.read_bytes()).decode("latin-1").splitlines()


def _alike_at_the_end(a: list[str], b: list[str]) -> int:
    count = 0
    while count < min(len(a), len(b)) and a[-1 - count] == b[-1 - count]:
        count += 1
    return count
