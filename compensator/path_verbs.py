"""The verbs about where and how an arm follows a path. As in ``cli.py``: no logic, heavy imports wait."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from compensator.command_line import INPUT, OUTPUT, Verb, strict_verb
from toolpaths.languages.table import READ

_READ = click.Choice([language.name for language in READ])


@click.command("axis-map", cls=Verb)
@click.argument("toolpath", type=INPUT, nargs=-1, required=True)
@click.option("--cell", required=True, type=INPUT, help="cell/1 file: robot, tool, work object, process.")
@click.option("--from", "read_as", type=_READ, help="Language of TOOLPATH, where its suffix does not say it.")
@click.option("--poses", type=int, default=2000, show_default=True, help="At most so many, evenly along the path.")
@click.option("--turns", type=int, default=72, show_default=True, help="Turns at each of them.")
@click.option("--csv", type=OUTPUT, help="A row per pose and turn.")
@click.option("--png", type=OUTPUT, help="Picture.")
@click.option("--report", type=OUTPUT, help="HTML page.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def axis_map(toolpath: tuple[Path, ...], cell: Path, verbose: bool, **options: Any) -> None:
    """Show which turns about the tool axis TOOLPATH allows, what they cost, and the chosen one."""
    from compensator.tasks.axis_map import axis_map_file
    from compensator.terminal.axis_map import show_axis_map
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = axis_map_file(toolpath, cell, say=say, **options)
    show_axis_map(done)
    print_findings(done.report)


VERBS = (axis_map,)
