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


@click.command("place", cls=Verb)
@click.argument("toolpath", type=INPUT, nargs=-1, required=True)
@click.option("--cell", required=True, type=INPUT, help="cell/1 file: robot, tool, work object, process.")
@click.option("-o", "--output", required=True, type=OUTPUT, help="Study to write: a Parquet of all placements.")
@click.option("--from", "read_as", type=_READ, help="Language of TOOLPATH, where its suffix does not say it.")
@click.option("--box", "within", help="Placements, mm and deg: x=1200:1800:13,y=-400:400:9,yaw=0:90:3.")
@click.option("--list", "places", type=INPUT, help="Or a csv of them: x_mm, y_mm, z_mm, roll_deg, pitch_deg, yaw_deg.")
@click.option("--turns", type=int, default=12, show_default=True, help="Turns about the tool axis, where it is free.")
@click.option("--poses", type=int, default=200, show_default=True, help="Of the path, that placements are judged at.")
@click.option("--workers", type=click.IntRange(1, 1024), help="Local processes; one for each core where not given.")
@click.option("--scheduler", help="Address of a Dask scheduler, such as tcp://host:8786, in their place.")
@click.option("--png", type=OUTPUT, help="Picture: map over x and y, the best ten.")
@click.option("--best", type=OUTPUT, help="Cell file with the best placement.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def place(toolpath: tuple[Path, ...], cell: Path, output: Path, verbose: bool, **options: Any) -> None:
    """Try where the part of TOOLPATH may stand, and rank what is reachable, free of collisions and stiff."""
    from compensator.tasks.place import place_file
    from compensator.terminal.place import show_place
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = place_file(toolpath, cell, output, say=say, **options)
    print_findings(done.report)
    show_place(done)


VERBS = (axis_map, place)
