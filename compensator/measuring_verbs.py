"""Verbs about what is measured: what to measure, and what devices wrote. No logic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from compensator.command_line import INPUT, OUTPUT, Verb, strict_verb
from compensator.devices.table import DEVICES
from toolpaths.languages.table import WRITTEN

_LANGUAGES = [language.name for language in WRITTEN]


@click.command(cls=Verb)
@click.argument("model", type=INPUT, required=False)
@click.option("-o", "--output", required=True, type=OUTPUT, help="CSV of the set-ups, or the program.")
@click.option("--session", "sessions", type=INPUT, multiple=True, help="Already measured; may be given several times.")
@click.option("--count", type=int, help="How many set-ups.  [default: 12]")
@click.option("--force", type=float, help="Largest force, N; default that of the sessions, else 100.")
@click.option("--toolpath", type=INPUT, help="Plan for the deflection at its poses; needs --cell.")
@click.option("--cell", type=INPUT, help="cell/1 file of the toolpath, or of the tool to measure with.")
@click.option("--seed", type=int, help="Of the postures to choose from.  [default: 0]")
@click.option("--ballbar", is_flag=True, help="Circles that tell the lost motion of every joint of --cell, a program.")
@click.option("--probe", is_flag=True, help="Two-sided touches that tell it, for a dial gauge; a program.")
@click.option("--program", type=OUTPUT, help="That drives to the set-ups, with a session to fill in beside it.")
@click.option("--format", "language", type=click.Choice(_LANGUAGES), help="Of that program, where its suffix is none.")
@click.option("--radius", type=float, help="Of the circles, mm.  [default: 150]")
@click.option("--center", nargs=3, type=float, help="Of the circles, or of the touches, mm in the base.")
@click.option("--feed", "feeds", type=float, multiple=True, help="Of the circles, mm/min.  [default: 500 and 2000]")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def plan(model: Path | None, output: Path, verbose: bool, **options: Any) -> None:
    """Say which set-ups to measure next, so that MODEL is known best; or which circles or touches of a cell."""
    from compensator.tasks.plan_any import plan_any
    from compensator.terminal.screen import print_findings, progress, show_lines

    if model is None and not (options["ballbar"] or options["probe"]):
        raise click.UsageError("Missing argument 'MODEL'.")
    with progress(verbose) as say:
        done = plan_any(model, output, say=say, **options)
    show_lines([done.sentence, *(f"wrote {file}" for file in done.files)])
    print_findings(done.report)


@click.command(cls=Verb)
@click.argument("file", type=INPUT)
@click.option("-o", "--output", required=True, type=OUTPUT, help="trace/1 file to write.")
@click.option("--samples", type=OUTPUT, help="Its samples.  [default: samples.csv beside it]")
@click.option("--from", "read_as", type=click.Choice([d.name for d in DEVICES]), help="Where content does not tell.")
@click.option("--cell", type=INPUT, help="The cell that the program ran in.  [default: cell.toml beside the trace]")
@click.option("--program", type=INPUT, help="The program that ran, as csv.  [default: run.csv beside the trace]")
@click.option("--units", type=click.Choice(("mm", "inch", "um", "m")), help="Of lengths, where the file has none.")
@click.option("--frame", type=click.Choice(("base", "workobject", "free")), help="Of the points; free: any other.")
@click.option("--noise", type=float, help="Standard deviation of a single reading, mm.")
@click.option("--index", help="Rows of the program at the readings, from 0: 4,8,12 or 0:100:2.")
@click.option("--dry", is_flag=True, help="The program ran in air.")
@click.option("--group", help="Of several groups of points, the one to take.")
@click.option("--point", help="Of several reflectors, the one to take.")
@click.option("--column", "columns", multiple=True, help="NAME=HEADING of a csv, or NAME=NUMBER; several times.")
@click.option("--nominals", type=INPUT, help="csv name,x,y,z,i,j,k of points whose normals the report lacks.")
@click.option("--center", nargs=3, type=float, help="Of a ball-bar, mm in the base.")
@click.option("--radius", type=float, help="Nominal length of a ball-bar, mm.")
@click.option("--calibrated", is_flag=True, help="The length of the ball-bar is known.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def trace(file: Path, output: Path, verbose: bool, **options: Any) -> None:
    """Turn FILE of a measuring device into a trace of a program that ran."""
    from compensator.devices.order import TraceOrder
    from compensator.tasks.trace import trace_file
    from compensator.terminal.screen import print_findings, progress, show_lines

    told = {key: options.pop(key) for key in TraceOrder.__dataclass_fields__}
    with progress(verbose) as say:
        done = trace_file(file, output, order=TraceOrder(**told), say=say, **options)
    show_lines([done.sentence, *(f"wrote {name}" for name in done.files)])
    print_findings(done.report)
