"""The commands of the pages in docs/: as a reader copies them into a shell, and as words."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from compensator.cli import main
from tests import verb_jobs

DOCS = Path(__file__).parents[2] / "docs"


def shell_lines(page: str, *programs: str) -> list[str]:
    """Every line of a page that starts one of these programs, else the compensator; continued lines are one."""
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8").replace("\\\n", " ")
    return re.findall(rf"^ *((?:{'|'.join(programs or ('compensator',))}) +[a-z-][^\n]*)$", text, re.M)


def steps(page: str) -> list[list[str]]:
    """Words of every command of a page, and of every folder that is made for one, in their order; what may be left out
    is given, but for "more of the same"."""
    lines = (line for line in shell_lines(page, "compensator", "mkdir") if " && " not in line)
    plain = (re.sub(r"\[more [^\]]*\]", "", re.split(r" [|>#] ?", line)[0]) for line in lines)
    return [shlex.split(re.sub(r"\[([^\]]*)\]", r"\1", line)) for line in plain]


def commands(page: str) -> list[list[str]]:
    """Those of the steps that are of the compensator, without its name."""
    return [words for program, *words in steps(page) if program == "compensator"]


def outputs(verb: str, words: list[str]) -> list[Path]:
    """The files that a command says it writes; where it does not say, those that its verb always writes."""
    options = {p.opts[0]: p.default for p in main.commands[verb].params if p.opts[0] in verb_jobs.outputs(verb)}
    said = [Path(words[k + 1]) for k, word in enumerate(words) if word in options]
    usual = [file for option, file in options.items() if isinstance(file, Path) and option not in words]
    return said + usual


PAGES = sorted(p.stem for p in DOCS.glob("*.md") if commands(p.stem))
