"""The terminal that a command writes to; nothing is shown when its output is piped."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table
from rich.text import Text

from compensator.report.words.findings import finding_sentences
from compensator.tasks.run_files import STDOUT
from compensator.tasks.say import Say
from toolpaths.finding import NOTE, WARNING


@contextmanager
def progress(verbose: bool) -> Iterator[Say]:
    """Shows what is being done: a spinner on a terminal, lines with ``verbose``, nothing when piped."""
    console = Console(stderr=True, markup=False)
    if verbose:
        yield lambda text: console.print(text, highlight=False)
    elif console.is_terminal:
        with console.status("starting") as status:
            yield lambda text: status.update(Text(text))
    else:
        yield lambda text: None


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
    made = Table(title=title)
    for k, head in enumerate(heads):
        made.add_column(head, justify="right" if k in right else "left")
    return made


def print_findings(report: Mapping[str, Any], warnings: Iterable[str] = ()) -> None:
    """What every stage of a run found, and warnings about its files, to standard error, piped or not."""
    console = Console(stderr=True, markup=False, soft_wrap=True)
    for line in (*finding_sentences(dict(report)), *(f"{WARNING}: {w}" for w in warnings)):
        console.print(line, highlight=False, style="dim" if line.startswith(NOTE) else "")
