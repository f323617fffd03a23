"""The terminal that a command writes to; nothing is shown when its output is piped."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from compensator.command_line import INPUT
from compensator.report.words.findings import finding_sentences
from compensator.tasks.run_files import STDOUT
from compensator.tasks.say import Say
from compensator.terminal.time_left import TimeLeft, left_words, size_of
from toolpaths.finding import NOTE, WARNING
from toolpaths.steps import heard_by

SHORT = 2.0  # s: a run that is over by then needs no percent
MOST_NOTES = 2  # on a terminal, without --verbose


@contextmanager
def progress(verbose: bool) -> Iterator[Say]:
    """Shows what is being done: a spinner on a terminal, after two seconds with percent and time left; lines with
    ``verbose``; nothing when piped."""
    console = Console(stderr=True, markup=False)
    if verbose:
        yield lambda text: console.print(text, highlight=False)
    elif console.is_terminal:
        shown = _Doing(_clock_of_verb())
        with console.status(shown), heard_by(shown.clock.step):
            yield shown.say
        if shown.clock.elapsed > SHORT:
            shown.clock.keep()
    else:
        yield lambda text: None


class _Doing:
    """What stands beside the spinner; made anew at every turn of it."""

    def __init__(self, clock: TimeLeft) -> None:
        self.clock, self._text = clock, "starting"

    def say(self, text: str) -> None:
        """Another stage begins."""
        self.clock.stage(text)
        self._text = text

    def __rich__(self) -> Text:
        if self.clock.elapsed < SHORT:
            return Text(self._text)
        share, left = self.clock.now()
        return Text(f"{self._text}  {share:.0%}, {left_words(left)}")


def _clock_of_verb() -> TimeLeft:
    """The clock of the command that runs, with the size of its inputs."""
    ctx = click.get_current_context(silent=True)
    if ctx is None:
        return TimeLeft("", 0)
    read: list[Path] = []
    for parameter in ctx.command.params:
        value = ctx.params.get(parameter.name or "")
        if parameter.type is INPUT and value is not None:
            read += value if isinstance(value, tuple) else [value]
    return TimeLeft(ctx.command.name or "", size_of(read))


def screen() -> Console | None:
    """Standard output where it is a terminal; standard error, where an output of the run goes to standard output."""
    ctx = click.get_current_context(silent=True)
    console = Console(markup=False, stderr=ctx is not None and STDOUT in ctx.params.values())
    return console if console.is_terminal else None


def show_lines(lines: Sequence[str]) -> None:
    """Plain lines."""
    if console := screen():
        print_lines(console, lines)


def echo_lines(lines: Sequence[str]) -> None:
    """Plain lines that are the result itself: shown when piped, too, on standard error where a file goes to stdout."""
    ctx = click.get_current_context(silent=True)
    click.echo("\n".join(lines), err=ctx is not None and STDOUT in ctx.params.values())


def print_lines(console: Console, lines: Iterable[str]) -> None:
    """Plain lines."""
    for line in lines:
        console.print(line, highlight=False)


def print_notes(console: Console, notes: Iterable[str]) -> None:
    """What a result does not know, dim below its numbers."""
    for note in notes:
        console.print(f"  - {note}", highlight=False, style="dim")


def print_written(console: Console, files: Iterable[Path]) -> None:
    """The files that were written."""
    print_lines(console, (f"wrote {file}" for file in files if file != STDOUT))


def table(*heads: str, right: Collection[int] = (), title: str | None = None) -> Table:
    """An empty table; ``right``: columns of figures, which are set flush right."""
    made = Table(title=title, box=SIMPLE_HEAD)
    for k, head in enumerate(heads):
        made.add_column(head, justify="right" if k in right else "left")
    return made


def print_findings(report: Mapping[str, Any], warnings: Iterable[str] = ()) -> None:
    """What every stage of a run found, and warnings about its files, to standard error, piped or not.

    On a terminal notes are cut to a line each, and to a few, unless --verbose asks for all.
    """
    console = Console(stderr=True, markup=False, soft_wrap=True)
    found = [*finding_sentences(dict(report)), *(f"{WARNING}: {w}" for w in warnings)]
    notes = [line for line in found if line.startswith(NOTE)]
    for line in (line for line in found if not line.startswith(NOTE)):
        console.print(line, highlight=False)
    short = console.is_terminal and not asked_for_all()
    for line in notes[:MOST_NOTES] if short else notes:
        text = Text(line, "dim")
        if short:
            text.truncate(console.width, overflow="ellipsis")
        console.print(text, highlight=False)
    if short and len(notes) > MOST_NOTES:
        console.print(Text(f"{len(notes) - MOST_NOTES} more notes: --verbose shows all", "dim"))


def asked_for_all() -> bool:
    """Whether --verbose is given; outside of a command everything is shown."""
    ctx = click.get_current_context(silent=True)
    return ctx is None or bool(ctx.params.get("verbose"))
