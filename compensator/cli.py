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
@click.argument("sessions", type=_FILE, nargs=-1, required=True)
@click.option("-o", "--output", required=True, type=_FILE, help="Model file to write.")
@click.option("--method", type=click.Choice(("global", "local")), default="global", help="All at once, or by joint.")
@click.option("--effects", help="Names, separated by commas, that fix the set of effects.")
@click.option("--prior", type=_FILE, help="Model to start from; its standard deviations are prior knowledge.")
@click.option("--json", "json", type=_FILE, help="Summary for scripts.")
@click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
@_refusals
def identify(
    sessions: tuple[Path, ...],
    output: Path,
    method: str,
    effects: str | None,
    prior: Path | None,
    json: Path | None,
    verbose: bool,
) -> None:
    """Turn measurement SESSIONS of one robot into a stiffness model."""
    from compensator.report.text import progress, show_fit
    from compensator.tasks_identify import identify_files

    names = None if effects is None else [name.strip() for name in effects.split(",") if name.strip()]
    with progress(verbose) as say:
        done = identify_files(sessions, output, method=method, effects=names, prior=prior, json=json, say=say)
    show_fit(done)


@main.command()
@click.argument("session", type=_FILE)
@click.option("--model", required=True, type=_FILE, help="Model to judge.")
@click.option("--register", type=int, help="States per block that place the tracker; default 25 where not registered.")
@click.option("--json", "json", type=_FILE, help="Summary for scripts.")
@click.option("--verbose", is_flag=True, help="Say what is being done; show where a refusal comes from.")
@_refusals
def evaluate(session: Path, model: Path, register: int | None, json: Path | None, verbose: bool) -> None:
    """Say how well a model predicts the readings of SESSION."""
    from compensator.report.text import progress, show_evaluation
    from compensator.tasks_identify import evaluate_file

    with progress(verbose) as say:
        _, report = evaluate_file(session, model, register=register, json=json, say=say)
    show_evaluation(report)


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
