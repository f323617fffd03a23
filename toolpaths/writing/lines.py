"""Lines of a written program: their ends, what stands in front of a move, and all of them read again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from toolpaths.writing.program import Program


def with_crlf(pieces: Iterator[str]) -> Iterator[str]:
    """Line ends as the makers' tools on Windows write them."""
    for piece in pieces:
        yield piece.replace("\n", "\r\n")


def lines_before(
    program: Program, comment: Callable[[str], str], mount: Callable[[int], str], block: slice | None = None
) -> dict[int, str]:
    """Pose -> the lines in front of its move, of those that have some.

    Args:
        comment: the lines of a comment.
        mount: the lines where the tool changes to this number: the operator has to mount it before the arm moves on.
        block: the poses asked for; None: all.
    """
    poses = range(len(program)) if block is None else range(block.start, block.stop)
    before: dict[int, str] = {}
    for pose, text in program.comments:
        if pose in poses:
            before[pose] = before.get(pose, "") + comment(text)
    for pose in (np.flatnonzero(np.diff(program.tool)) + 1).tolist():
        if pose in poses:
            before[pose] = before.get(pose, "") + mount(int(program.tool[pose]))
    return before


def text_of(path: Path) -> str:
    """The text of a written program, line ends as they are."""
    with open(path, encoding="ascii", newline="") as stream:
        return stream.read()
