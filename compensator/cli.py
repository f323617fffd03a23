"""The command line: one verb per task, no logic. Heavy imports wait until a verb runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

# one BLAS thread: the arrays are small or run through CasADi, and numpy starts twice as fast
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_FILE = click.Path(path_type=Path)
_FORMATS = ("rapid", "krl", "fanuc", "urscript", "val3", "inform", "gcode", "csv")


def _refusals(task: Callable[..., None]) -> Callable[..., None]:
    """A refusal becomes one message on stderr and exit status 1."""

    @wraps(task)
    def guarded(*args: Any, **options: Any) -> None:
        verbose = click.get_current_context().find_root().params.get("verbose") or options.get("verbose")
        try:
            task(*args, **options)
        except Exception as error:
            if not _is_refusal(error):
                raise
            if verbose:
                import traceback

                traceback.print_exc()
            click.echo(f"compensator: {error}", err=True)
            sys.exit(1)

    return guarded


def _is_refusal(error: Exception) -> bool:
    from compensator.errors import CompensatorError
    from stiffness.errors import StiffnessError
    from toolpaths.errors import ToolpathError

    return isinstance(error, CompensatorError | StiffnessError | ToolpathError)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="toolpath-compensator")
def main() -> None:
    """Compensate CAM toolpaths for the elastic deflection of an industrial robot."""


@main.command()
@click.argument("toolpath", type=_FILE)
@click.option("--cell", required=True, type=_FILE, help="cell/1 file: robot, tool, work object, process.")
@click.option("-o", "--output", "program", required=True, type=_FILE, help="Program to write.")
@click.option("--format", "language", type=click.Choice(_FORMATS), help="Language, where the suffix does not say it.")
@click.option("--report", type=_FILE, help="HTML report.")
@click.option("--json", "json", type=_FILE, help="Summary for scripts.")
@click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
@_refusals
def compensate(
    toolpath: Path,
    cell: Path,
    program: Path,
    language: str | None,
    report: Path | None,
    json: Path | None,
    verbose: bool,
) -> None:
    """Move every pose of TOOLPATH so that the predicted deflection cancels, and write a robot program."""
    from compensator.report.text import progress, show
    from compensator.tasks import compensate_file

    with progress(verbose) as say:
        done = compensate_file(toolpath, cell, program, language=language, report=report, json=json, say=say)
    show(done)


@main.command()
@click.argument("toolpath", type=_FILE)
@click.option("--cell", required=True, type=_FILE, help="cell/1 file: robot, tool, work object, process.")
@click.option("--csv", type=_FILE, help="Deflection per pose.")
@click.option("--report", type=_FILE, help="HTML report.")
@click.option("--json", "json", type=_FILE, help="Summary for scripts.")
@click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
@_refusals
def preview(
    toolpath: Path, cell: Path, csv: Path | None, report: Path | None, json: Path | None, verbose: bool
) -> None:
    """Predict the deflection at every pose of TOOLPATH, uncompensated."""
    from compensator.report.text import progress, show
    from compensator.tasks import preview_file

    with progress(verbose) as say:
        done = preview_file(toolpath, cell, csv=csv, report=report, json=json, say=say)
    show(done)


@main.command()
@click.argument("name", required=False)
@click.option("--verbose", is_flag=True, help="Show where a refusal comes from.")
@_refusals
def robots(name: str | None, verbose: bool) -> None:
    """List the built-in robots; with NAME (built-in, .toml or .urdf) show one."""
    from compensator.report.text import show_robot, show_robots

    if name is None:
        show_robots()
    else:
        show_robot(name)


if __name__ == "__main__":
    main()
