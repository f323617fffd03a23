"""docs/mistakes.md: a row per mistake, with what happens."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from tests.mistakes import cells, command_lines, sessions, shell, toolpaths
from tests.mistakes.mistake import Mistake, Outcome, made
from tests.mistakes.shell import Mishap, happened

PAGE = Path(__file__).parents[2] / "docs" / "mistakes.md"
CHAPTERS: dict[str, tuple[Mistake, ...] | tuple[Mishap, ...]] = {
    "The command line": command_lines.NAMES,
    "Outputs": command_lines.OUTPUTS,
    "The cell as a file": cells.FILES,
    "Keys of the cell": cells.KEYS,
    "Numbers of the cell": cells.NUMBERS,
    "The model": cells.MODELS,
    "The wrench table": cells.TABLES,
    "G-code": toolpaths.GCODE,
    "Poses as csv": toolpaths.POSES,
    "session.toml": sessions.HEADERS,
    "samples.csv": sessions.ROWS,
    "Signals, disks and pipes": shell.MISHAPS,
}
HEAD = """# {count} mistakes, and what happens

Made by `python -m tests.mistakes`, which makes every one of them in a folder of its own, where nothing else is wrong,
and looks afterwards: no traceback, no hang, no file that was there before has changed, and nothing new stands there
unless the command did what was asked. The test suite makes them again and compares (`tests/mistakes/test_mistakes.py`).

Exit status: 0 done, 1 refused or failed, 2 wrong usage, 130 interrupted (Ctrl-C), 128 and its number after another
signal. What is said goes to standard error; `⏎` is the end of a line. After `kill -9` a hidden folder
`.compensator-...` stays beside the output; it holds nothing that is missed and can be removed.
`python -m tests.kill_writers` kills every verb that writes at random moments, and before each of its file operations:
inputs stay what they are, an output is the old one or the new one, whole.
"""


def outcome(mistake: Mistake | Mishap, inputs: Path, folder: Path) -> Outcome:
    """What comes of it in ``folder``, which is made as a copy of ``inputs``."""
    shutil.copytree(inputs, folder, symlinks=True)
    return happened(mistake, folder) if isinstance(mistake, Mishap) else made(mistake, folder)


def row(mistake: Mistake | Mishap, found: Outcome) -> str:
    """A row of the page."""
    left = ", ".join(f"`{name}`" if "." in name else name for name in found.left) or "nothing"
    cells = (mistake.what, f"`{mistake.command}`", str(found.status), found.said, left)
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page(rows: Callable[[Mistake | Mishap], str]) -> str:
    """The page, with the row of every mistake."""
    count = sum(map(len, CHAPTERS.values()))
    return "\n".join([HEAD.format(count=count), *_lines(rows)]) + "\n"


def _lines(rows: Callable[[Mistake | Mishap], str]) -> Iterator[str]:
    for title, mistakes in CHAPTERS.items():
        yield f"## {title}\n"
        yield "| mistake | command, after `compensator` | exit | what is said | what is left |"
        yield "| --- | --- | ---: | --- | --- |"
        yield from map(rows, mistakes)
        yield ""
