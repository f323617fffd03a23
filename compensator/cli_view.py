"""The verb that shows a cell. As in ``cli.py``: no logic, and heavy imports wait until it runs."""

from __future__ import annotations

from pathlib import Path

import click

from compensator.command_line import INPUT, Verb
from toolpaths.languages.table import READ

_READ = click.Choice([language.name for language in READ])


@click.command(cls=Verb)
@click.argument("cell", type=INPUT)
@click.argument("toolpath", type=INPUT, nargs=-1)
@click.option("--from", "read_as", type=_READ, help="Language of TOOLPATH, where its suffix does not say it.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of 127.0.0.1.  [default: a free one]")
@click.option("--browser/--no-browser", default=True, help="Whether the page is opened.")
@click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
def view(
    cell: Path, toolpath: tuple[Path, ...], read_as: str | None, port: int, browser: bool, verbose: bool
) -> None:
    """Show CELL at work on TOOLPATH in a page of this machine, to look at, to edit and to save; Ctrl-C ends it."""
    from compensator.tasks.view import serve, view_server
    from compensator.terminal.screen import progress

    with progress(verbose) as say:
        server = view_server(cell, toolpath, read_as=read_as, port=port, say=say)
    click.echo(server.url)
    click.echo("Ctrl-C ends it", err=True)
    serve(server, browser=browser)
