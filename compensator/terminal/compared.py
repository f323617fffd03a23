"""Two summaries side by side; shown when piped, too: it is the result."""

from __future__ import annotations

import click
from rich.console import Console
from rich.text import Text

from compensator.tasks.compare import Comparison, Value
from compensator.tasks.run_files import STDOUT
from compensator.terminal.screen import print_lines, table

WIDTH = 110


def show_compared(done: Comparison) -> None:
    """A row per key that differs, then findings that only one has."""
    ctx = click.get_current_context(silent=True)
    console = Console(width=WIDTH, markup=False, stderr=ctx is not None and STDOUT in ctx.params.values())
    if not (done.rows or done.only_one or done.only_other):
        console.print(f"{done.schema}: no difference", highlight=False)
        return
    print_lines(console, (f"{head}: {name}" for head, name in zip(("one", "other"), done.names, strict=True)))
    if done.rows:
        rows = table(done.schema, "one", "other", "other - one", right=(1, 2, 3))
        for d in done.rows:
            by = "" if d.by is None else f"{d.by:+.6g}"
            rows.add_row(*(Text(word) for word in (d.key, _shown(d.one), _shown(d.other), by)))
        console.print(rows)
    for name, sentences in zip(("one", "other"), (done.only_one, done.only_other), strict=True):
        print_lines(console, (f"only {name}: {sentence}" for sentence in sentences))


def _shown(value: Value) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return "-" if value is None else str(value)
