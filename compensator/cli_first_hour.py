"""The verbs around a run: a first cell, what is wrong with it, two runs compared, a finished program verified.

As in ``cli.py``: no logic, and heavy imports wait until a verb runs.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from compensator.command_line import INPUT, OUTPUT, Verb
from toolpaths.languages.table import READ, WRITTEN

LANGUAGES = [language.name for language in WRITTEN]
_READ = click.Choice([language.name for language in READ])
_from = click.option("--from", "read_as", type=_READ, help="Language of TOOLPATH, where its suffix does not say it.")
_verbose = click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")


@click.command(cls=Verb)
@click.option("--robot", help="Built-in name, or path to a robot .toml or .urdf.")
@click.option("--tool", help="'X Y Z' of the TCP in the flange frame, mm, and the mass, kg; several: '1=...; 2=...'.")
@click.option("--part", help="'X Y Z' of the zero of the CAM file in the base, mm; then roll, pitch, yaw, deg.")
@click.option("--cam", type=INPUT, help="CAM file that the cell is for.")
@click.option("--stiffness", help="Model file, built-in set, or: unknown.")
@click.option("--controller", type=click.Choice(LANGUAGES), help="Language of the programs to write.")
@click.option("--cutter", help="'SHAPE DIAMETER FLUTES LENGTH', mm; several: '1=flat 10 2 25; 2=ball 6 2 20'.")
@click.option("--material", help="Built-in set, or path to a material/1 file.")
@click.option("--stock", help="Mesh, 'box X Y Z X Y Z' or 'cylinder X Y RADIUS Z Z' in its frame, or: unknown.")
@click.option("--spindle-rpm", help="Where the CAM file gives no S, 1/min.")
@click.option("-o", "--output", type=OUTPUT, default=Path("cell.toml"), show_default=True, help="Cell to write.")
@click.option("--new-model", type=OUTPUT, help="Model to write for an unknown stiffness.  [default: stiffness.toml]")
@_verbose
def init(output: Path, new_model: Path | None, verbose: bool, **options: Any) -> None:
    """Write a first cell from answers, asked for or given as options. Overwrites nothing."""
    from compensator.tasks.init import init_files
    from compensator.terminal.questions import answered
    from compensator.terminal.screen import print_findings, progress, show_lines

    answers = answered(options, tuple(LANGUAGES))
    with progress(verbose) as say:
        done = init_files(answers, output=output, new_model=new_model, say=say)
    show_lines([f"wrote {file}" for file in done.files])
    print_findings(done.report)


@click.command(cls=Verb)
@click.argument("cell", type=INPUT)
@click.argument("toolpath", type=INPUT, nargs=-1)
@_from
@click.option("--json", "json", type=OUTPUT, help="The findings for scripts.")
@_verbose
def check(cell: Path, toolpath: tuple[Path, ...], verbose: bool, **options: Any) -> None:
    """List all that is wrong with CELL and TOOLPATH, or assumed, worst first, and what each assumption is worth."""
    from compensator.report.words.check import check_lines
    from compensator.tasks.check import check_files
    from compensator.terminal.screen import echo_lines, progress

    with progress(verbose) as say:
        done = check_files(cell, toolpath, say=say, **options)
    echo_lines(check_lines(done.report))
    done.refuse_errors()


@click.command(cls=Verb)
@click.argument("one", type=INPUT)
@click.argument("other", type=INPUT)
@click.option("--json", "json", type=OUTPUT, help="The differences for scripts.")
@_verbose
def compare(one: Path, other: Path, verbose: bool, json: Path | None) -> None:
    """Show what differs between two JSON summaries of the same verb, ONE and OTHER."""
    from compensator.tasks.compare import compare_files
    from compensator.terminal.compared import show_compared

    show_compared(compare_files(one, other, json=json))


@click.command(cls=Verb)
@click.argument("program", type=INPUT)
@click.option("--cell", required=True, type=INPUT, help="cell/1 file that the program was made with.")
@click.option("--toolpath", type=INPUT, multiple=True, help="What it was made from.  [default: found by its hash]")
@click.option("--format", "language", type=click.Choice(LANGUAGES), help="Language, where the suffix does not say it.")
@_from
@click.option("--json", "json", type=OUTPUT, help="The verdict for scripts.")
@_verbose
def verify(program: Path, cell: Path, verbose: bool, **options: Any) -> None:
    """Read a finished PROGRAM anew, simulate it with the cell's model, and say whether it is what was written."""
    from compensator.report.words.verification import verification_lines
    from compensator.tasks.verify import verify_file
    from compensator.terminal.screen import echo_lines, progress

    with progress(verbose) as say:
        done = verify_file(program, cell, say=say, **options)
    echo_lines(verification_lines(done.report))
    done.refuse_unconfirmed()


VERBS = (init, check, compare, verify)
