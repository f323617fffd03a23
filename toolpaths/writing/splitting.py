"""Splitting a long program into parts that a controller can hold, away from the cut where that is possible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolpaths.finding import WARNING, Finding
from toolpaths.toolpath import CUT, RAPID
from toolpaths.writing.program import Program


def parts(program: Program, most: int) -> tuple[slice, ...]:
    """Ranges of at most ``most`` poses; a part ends behind a rapid where one is in its second half."""
    n, start, out = len(program), 0, []
    while n - start > most:
        half = start + most // 2
        rapids = np.flatnonzero(program.kind[half : start + most] == RAPID)
        end = half + int(rapids[-1]) + 1 if len(rapids) else start + most
        out.append(slice(start, end))
        start = end
    return (*out, slice(start, n))


def part_findings(program: Program, most: int, remedy: str) -> Iterator[Finding]:
    """A warning where the robot may stand in the cut because one part ends and the next begins."""
    ends = [p.stop for p in parts(program, most)[:-1]]
    inside = [e for e in ends if program.kind[e - 1] == CUT and program.kind[e] == CUT]
    if inside:
        what = "a part of the split program ends in the cut: the robot may stand there"
        yield Finding(level=WARNING, place=program.place(inside[0]), what=what, remedy=remedy, count=len(inside))
