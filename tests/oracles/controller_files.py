"""What the second readers of robot programs share: how a file ends its lines, lists in brackets, turns about axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def crlf_text(path: Path) -> str:
    """The text of an ASCII file in which every line ends with CR LF; here with LF."""
    raw = path.read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n") == raw.count(b"\r"), "line ends"
    assert raw.endswith(b"\r\n")
    return raw.decode("ascii").replace("\r\n", "\n")


def at_commas(text: str, brackets: str) -> list[str]:
    """The parts between commas that stand outside brackets (opening ones first: ``"[(])"``) and strings."""
    half = len(brackets) // 2
    parts, depth, quoted, start = [], 0, False, 0
    for i, c in enumerate(text):
        quoted ^= c == '"'
        depth += (c in brackets[:half]) - (c in brackets[half:])
        if c == "," and depth == 0 and not quoted:
            parts.append(text[start:i].strip())
            start = i + 1
    return [*parts, text[start:].strip()]


def about_axes(rx: float, ry: float, rz: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(3, 3) each of a turn about x, y, z; deg."""
    (a, b, c), (d, e, f) = np.cos(np.radians([rx, ry, rz])), np.sin(np.radians([rx, ry, rz]))
    return (
        np.array([[1, 0, 0], [0, a, -d], [0, d, a]]),
        np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]]),
        np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]]),
    )
