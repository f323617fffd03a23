"""Lines of a toolpath as they stand in its file, for a reader who wants to see where a number comes from."""

from __future__ import annotations

from pathlib import Path

from toolpaths.toolpath import Toolpath

LONGEST = 120  # characters of a line
LARGEST = 40_000_000  # bytes of a file


def source_lines(toolpath: Toolpath) -> dict[int, str]:
    """Number of the line -> its text; nothing for a program of several files, or a file that is not there any more."""
    path = Path(toolpath.source)
    try:
        if toolpath.file is not None or path.stat().st_size > LARGEST:
            return {}
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    wanted = set(toolpath.line.tolist())
    return {k: _shown(line) for k, line in enumerate(text.split("\n"), 1) if k in wanted}


def _shown(line: str) -> str:
    plain = "".join(c if c.isprintable() else " " for c in line).strip()
    return plain if len(plain) <= LONGEST else f"{plain[: LONGEST - 1]}…"
