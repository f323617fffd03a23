"""The command line: one verb per task, no logic. Heavy imports wait until a verb runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from compensator.cli_first_hour import VERBS
from compensator.cli_shell import VERBS as SHELL_VERBS
from compensator.cli_view import view
from compensator.command_line import INPUT, OUTPUT, Verbs, strict_verb
from compensator.measuring_verbs import plan, trace
from compensator.path_verbs import VERBS as PATH_VERBS
from toolpaths.languages.table import READ, WRITTEN

# one BLAS thread: the arrays are small or run through CasADi, and numpy starts twice as fast
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_LANGUAGES = [language.name for language in WRITTEN]
_READ = click.Choice([language.name for language in READ])
_from = click.option("--from", "read_as", type=_READ, help="Language of TOOLPATH, where its suffix does not say it.")


@click.group(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="toolpath-compensator")
def main() -> None:
    """Compensate CAM toolpaths for the elastic deflection of an industrial robot."""


@main.command()
@click.argument("toolpath", type=INPUT, nargs=-1, required=True)
@click.option("--cell", required=True, type=INPUT, help="cell/1 file: robot, tool, work object, process.")
@click.option("-o", "--output", "program", required=True, type=OUTPUT, help="Program to write.")
@click.option("--format", "language", type=click.Choice(_LANGUAGES), help="Language, where the suffix does not say it.")
@_from
@click.option("--report", type=OUTPUT, help="HTML report: the arm at work, numbers, curves.")
@click.option("--pdf", type=OUTPUT, help="One page of it for a customer.")
@click.option("--glb", type=OUTPUT, help="The scene for other 3D viewers (glTF).")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@click.option("--engagement", type=OUTPUT, help="CSV of what is engaged at every pose, where the process is milling.")
@click.option("--left", type=OUTPUT, help="Mesh (.stl, .ply, .obj) of the stock that remains.")
@strict_verb
def compensate(toolpath: tuple[Path, ...], cell: Path, program: Path, verbose: bool, **options: Any) -> None:
    """Move every pose of TOOLPATH (files of a program, or its folder) so that the predicted deflection cancels."""
    from compensator.tasks.compensate import compensate_file
    from compensator.terminal.path import show_path
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = compensate_file(toolpath, cell, program, say=say, **options)
    show_path(done)
    print_findings(done.report)


@main.command()
@click.argument("toolpath", type=INPUT, nargs=-1, required=True)
@click.option("--cell", required=True, type=INPUT, help="cell/1 file: robot, tool, work object, process.")
@_from
@click.option("--csv", type=OUTPUT, help="Deflection per pose.")
@click.option("--report", type=OUTPUT, help="HTML report: the arm at work, numbers, curves.")
@click.option("--pdf", type=OUTPUT, help="One page of it for a customer.")
@click.option("--glb", type=OUTPUT, help="The scene for other 3D viewers (glTF).")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@click.option("--engagement", type=OUTPUT, help="CSV of what is engaged at every pose, where the process is milling.")
@click.option("--left", type=OUTPUT, help="Mesh (.stl, .ply, .obj) of the stock that remains.")
@strict_verb
def preview(toolpath: tuple[Path, ...], cell: Path, verbose: bool, **options: Any) -> None:
    """Predict the deflection at every pose of TOOLPATH, uncompensated."""
    from compensator.tasks.compensate import preview_file
    from compensator.terminal.path import show_path
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = preview_file(toolpath, cell, say=say, **options)
    show_path(done)
    print_findings(done.report)


@main.command()
@click.argument("sessions", type=INPUT, nargs=-1, required=True)
@click.option("-o", "--output", required=True, type=OUTPUT, help="Model file to write.")
@click.option("--method", type=click.Choice(("global", "local")), default="global", help="All at once, or by joint.")
@click.option("--effects", help="Names, separated by commas, that fix the set of effects.")
@click.option("--prior", type=INPUT, help="Model to start from; its standard deviations are prior knowledge.")
@click.option("--report", "html", type=OUTPUT, help="HTML report of the fit.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def identify(sessions: tuple[Path, ...], output: Path, effects: str | None, verbose: bool, **options: Any) -> None:
    """Turn measurement SESSIONS of one robot into a stiffness model."""
    from compensator.tasks.identify import identify_files
    from compensator.terminal.fit import show_fit
    from compensator.terminal.screen import print_findings, progress

    names = None if effects is None else [name.strip() for name in effects.split(",") if name.strip()]
    with progress(verbose) as say:
        done = identify_files(sessions, output, effects=names, say=say, **options)
    print_findings(done.report, done.warnings)  # what is wrong with the measurement is said first
    show_fit(done)


@main.command()
@click.argument("sessions", type=INPUT, nargs=-1, required=True)
@click.option("--model", required=True, type=INPUT, help="Model to judge.")
@click.option("-o", "--output", type=OUTPUT, help="Refined model to write; the model itself where nothing was found.")
@click.option("--report", "html", type=OUTPUT, help="HTML report.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def diagnose(
    sessions: tuple[Path, ...], model: Path, output: Path | None, verbose: bool, **options: Any
) -> None:
    """Say what MODEL lacks in the readings of SESSIONS, add it, and say how much better that is."""
    from compensator.report.words.diagnosis import diagnosis_lines
    from compensator.tasks.diagnose import diagnose_files
    from compensator.terminal.screen import print_findings, progress, show_lines

    with progress(verbose) as say:
        done = diagnose_files(sessions, model, output, say=say, **options)
    print_findings(done.report, done.warnings)  # first, as of identify
    show_lines([*diagnosis_lines(done.diagnosis, done.report), *(f"wrote {file}" for file in done.files)])


@main.command()
@click.argument("session", type=INPUT)
@click.option("--model", required=True, type=INPUT, help="Model to judge.")
@click.option("--register", type=int, help="States per block that place the tracker; default 25 where not registered.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def evaluate(session: Path, model: Path, verbose: bool, **options: Any) -> None:
    """Say how well a model predicts the readings of SESSION."""
    from compensator.tasks.identify import evaluate_file
    from compensator.terminal.fit import show_evaluation
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        _, report = evaluate_file(session, model, say=say, **options)
    print_findings(report)
    show_evaluation(report)


@main.command("stiffness-map")
@click.argument("model", type=INPUT)
@click.option("--robot-joints", "joints", default="2,3", show_default=True, help="The two joints that vary.")
@click.option("--grid", "spans", help="LOW:HIGH:STEP,LOW:HIGH:STEP in deg.  [default: the limits, every 5 deg]")
@click.option("--fixed", help="The other joints, such as 1=0,4=45, deg.  [default: 1 to 3 at 0, 4 to 6 at 45]")
@click.option(
    "--wrench",
    nargs=6,
    type=float,
    default=(200.0, 200.0, -2500.0, 0.0, 0.0, 0.0),
    show_default=True,
    help="On the robot, about the TCP: fx fy fz in N, mx my mz in N*m.",
)
@click.option("--frame", type=click.Choice(("base", "tool")), default="base", show_default=True, help="Its axes.")
@click.option("--tool-xyz", nargs=3, type=float, default=(0.0, 0.0, 0.0), help="TCP in the flange frame, mm.")
@click.option("--tool-rpy", nargs=3, type=float, default=(0.0, 0.0, 0.0), help="Its roll, pitch, yaw, deg.")
@click.option("--tool-name", default="tool", help="Tool effects of the model hold for the tool of this name.")
@click.option("--tool-mass", type=float, help="kg, with --tool-com.")
@click.option("--tool-com", nargs=3, type=float, help="Centre of mass in the flange frame, mm.")
@click.option("--weight/--no-weight", default=True, help="Whether arm and tool weigh something.")
@click.option("--png", type=OUTPUT, help="Contour maps.")
@click.option("--csv", type=OUTPUT, help="A row per posture.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def stiffness_map(model: Path, verbose: bool, **options: Any) -> None:
    """Map the Cartesian stiffness of MODEL over two joints, and what the complementary stiffness K_c is worth."""
    from compensator.tasks.stiffness_map import map_file, tool_of
    from compensator.terminal.screen import print_findings, progress
    from compensator.terminal.stiffness_map import show_map

    held = {key: options.pop(f"tool_{key}") for key in ("xyz", "rpy", "name", "mass", "com")}
    with progress(verbose) as say:
        done = map_file(model, tool=tool_of(**held), say=say, **options)
    show_map(done)
    print_findings(done.report)


@main.command()
@click.argument("readings", type=INPUT)
@click.option("--robot", required=True, help="Built-in name, or path to a robot .toml or .urdf.")
@click.option("-o", "--output", "model", required=True, type=OUTPUT, help="Model file to write.")
@click.option(
    "--above", type=float, default=0.25, show_default=True, help="Share of the largest torque that readings count from."
)
@click.option(
    "--torque-scale-sd", "scale_sd", type=float, default=0.05, show_default=True,
    help="Standard deviation of the scale of the torque, as a share.",
)
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def clamped(readings: Path, robot: str, model: Path, verbose: bool, **options: Any) -> None:
    """Fit joint stiffness to READINGS of motor torque against motor angle, taken with the end-effector locked."""
    from compensator.tasks.models import clamped_file
    from compensator.terminal.made_model import show_made
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = clamped_file(readings, robot, model, say=say, **options)
    show_made(done)
    print_findings(done.report)


@main.command()
@click.argument("forces", type=INPUT)
@click.option("-o", "--output", "material", required=True, type=OUTPUT, help="Material file to write.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def cutting(forces: Path, material: Path, verbose: bool, **options: Any) -> None:
    """Fit coefficients of the cutting force to FORCES, a csv of mean forces or spindle powers."""
    from compensator.tasks.cutting import cutting_file
    from compensator.terminal.cutting import show_material
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = cutting_file(forces, material, say=say, **options)
    show_material(done)
    print_findings(done.report)


@main.command()
@click.argument("robot")
@click.option("-o", "--output", "model", required=True, type=OUTPUT, help="Model file to write.")
@click.option("--json", "json", type=OUTPUT, help="Summary for scripts.")
@strict_verb
def datasheet(robot: str, model: Path, verbose: bool, **options: Any) -> None:
    """Make a starting model, with wide standard deviations, from the reducer data in the file of ROBOT."""
    from compensator.tasks.models import datasheet_file
    from compensator.terminal.made_model import show_made
    from compensator.terminal.screen import print_findings, progress

    with progress(verbose) as say:
        done = datasheet_file(robot, model, say=say, **options)
    show_made(done)
    print_findings(done.report)


main.add_command(plan)
main.add_command(trace)
main.add_command(view)


@main.command()
@click.argument("name", required=False)
@click.option("--verbose", is_flag=True, help="Show where a refusal comes from.")
def effects(name: str | None, verbose: bool) -> None:
    """List the effects of the catalogue, with those of installed packages; with NAME show one."""
    from compensator.tasks.effects import effect_lines, effects_lines

    click.echo("\n".join(effects_lines() if name is None else effect_lines(name)))


@main.command()
@click.argument("name", required=False)
@click.option("--verbose", is_flag=True, help="Show where a refusal comes from.")
def robots(name: str | None, verbose: bool) -> None:
    """List the built-in robots; with NAME (built-in, .toml or .urdf) show one."""
    from compensator.terminal.robots import show_robot, show_robots

    show_robots() if name is None else show_robot(name)


for _verb in (*VERBS, *PATH_VERBS, *SHELL_VERBS):
    main.add_command(_verb)

if __name__ == "__main__":
    main()
