"""Findings: what any stage has to tell about a program or a run, one at a time, repeats merged."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from toolpaths.errors import WriteError

#: Levels: an error refuses, a warning is to be looked at, a note is good to know.
ERROR, WARNING, NOTE = LEVELS = "error", "warning", "note"
_LINE = re.compile(r"(?:^line |:)(\d+)(?: \(pose .*\))?\)?$")  # of file:12, line 12, pose 3 (file:12), file:12 (pose 3)


@dataclass(frozen=True)
class Finding:
    """Something wrong or noteworthy about a program or a run; one of level ``error`` refuses it.

    Attributes:
        level: ``error``, ``warning`` or ``note``.
        place: where, in words of the user: ``pose 12 (line 40)``, ``tool 2``, ``name``; empty: the whole run.
        what: what is wrong there, with the value and the bound.
        remedy: what to do about it.
        count: how many places had the same; ``place`` is the first.
        places: all of them, where they were merged, in their order; empty where ``place`` is the only one.
        kind: the stage that found it: ``toolpath``, ``cell``, ``model``, ``path``, ``process``, ``solve``, ``program``,
            ``device``, ``plan``, ``collision``.
        line: of the source, where ``place`` does not end in it.
    """

    level: str
    place: str
    what: str
    remedy: str = ""
    count: int = 1
    places: tuple[str, ...] = field(default=(), compare=False)
    kind: str = ""
    line: int | None = None

    def __str__(self) -> str:
        more = f" (and {self.count - 1} more places)" if self.count > 1 else ""
        level = "" if self.level == NOTE else f"{self.level}: "
        place = f"{self.place}{more}: " if self.place else ""
        return f"{level}{place}{self.what}" + (f". {self.remedy}" if self.remedy else "")

    @property
    def lines(self) -> tuple[int, ...]:
        """Lines of the source that it is about, ascending."""
        found = [_LINE.search(place) for place in self.places or (self.place,)]
        return tuple(sorted({int(m[1]) for m in found if m}))

    @property
    def source_line(self) -> int | None:
        """The line of the source that it is about first; None where it is about none."""
        found = _LINE.search(self.place) if self.line is None else None
        return int(found[1]) if found else self.line


def merged(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings with the same level, kind, words and remedy as one, at the first place; errors first, notes last."""
    same: dict[tuple[str, str, str, str], list[Finding]] = {}
    for f in findings:
        same.setdefault((f.level, f.kind, f.what, f.remedy), []).append(f)
    out = []
    for all_ in same.values():
        places = tuple(dict.fromkeys(p for f in all_ for p in (f.places or (f.place,))))
        count = sum(f.count for f in all_)
        out.append(replace(all_[0], place=places[0], count=count, places=places if len(places) > 1 else ()))
    return tuple(sorted(out, key=lambda f: LEVELS.index(f.level)))


def of_kind(kind: str, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """The findings of a stage, with its name where they have none."""
    return tuple(f if f.kind else replace(f, kind=kind) for f in findings)


def refuse_errors(path: str, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """The findings, merged; WriteError listing them all when one is an error."""
    found = merged(findings)
    if any(f.level == ERROR for f in found):
        listed = "\n".join(f"  {f}" for f in found)
        raise WriteError(f"{path}: the program is refused:\n{listed}")
    return found
