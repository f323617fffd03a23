"""Filter in place for G-code: new coordinates for the cutting moves of a file, everything else as it is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from toolpaths.finding import merged
from toolpaths.languages.gcode.block_rewriter import BlockRewriter
from toolpaths.languages.gcode.filter_checks import LINE, check, says_turns
from toolpaths.languages.gcode.reader import parse
from toolpaths.machine import Machine
from toolpaths.rewriting.filter import Filter, Rewritten
from toolpaths.writing.marker import marked, refuse_compensated
from toolpaths.writing.program import Floats, Program


def rewrite(source: bytes, program: Program, row: Floats, path: Path, machine: Machine | None = None) -> Rewritten:
    """The file with the poses of ``program``.

    Args:
        source: the bytes of the file.
        program: commanded poses in the file's coordinate system, in the order of execution.
        row: (N,) of each pose in ``Toolpath.row``.
        path: the file, for messages.
        machine: with which the file was read: where its coordinate systems lie.

    Raises:
        ReadError: the file cannot be read, or is compensated already.
        WriteError: a pose cannot be put in place; names the line.
    """
    refuse_compensated(source, str(path))
    check(source, path)
    pairs = [(m[1], m[2]) for m in LINE.finditer(source.decode("latin-1"))]
    if len(pairs) > 1 and pairs[-1] == ("", ""):
        pairs.pop()
    texts = [text for text, _ in pairs]
    texts[0] = texts[0].removeprefix("\xef\xbb\xbf")
    tail = [""] if pairs[-1][1] else []
    blocks = parse([t.rstrip("\x1a") for t in texts] + tail, str(path), machine, trace=True)
    writer = BlockRewriter(
        texts=texts, program=program, row=np.asarray(row, dtype=np.float64), path=path, blocks=blocks
    )
    changed = writer.run()
    end = next((e for _, e in pairs if e), "\n")
    out = ["\xef\xbb\xbf"] if pairs[0][0] != texts[0] else []
    at = _marker_line(texts)
    for k, (text, ending) in enumerate(pairs):
        if k == at:
            out.append(f"({marked(program.stamp)}){end}")
        lines = changed.get(k + 1, [texts[k] if k == 0 else text])
        out += [line + (ending or end) for line in lines[:-1]] + [lines[-1] + ending]
    return Rewritten("".join(out).encode("latin-1"), merged(writer.changes))


def _marker_line(texts: Sequence[str]) -> int:
    """Index of the line in front of which the marker goes: behind the % and the program number."""
    at = 0
    while at < min(len(texts) - 1, 5) and (not texts[at].strip() or re.match(r"\s*(%|[Oo:]\d+)", texts[at])):
        at += 1
    return at


FILTER = Filter(rewrite=rewrite, check=check, says_turns=says_turns)
