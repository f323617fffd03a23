"""A small job for every verb that writes: what it is called with, what it reads, what it writes.

A new verb gets an entry here; tests that go over all verbs fail without it.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import click

from compensator.cli import main
from compensator.command_line import OUTPUT
from compensator.tasks.compensate import compensate_file
from tests.compensator import small_job
from tests.stiffness.bench_lab import Lab
from tests.stiffness.model.test_clamped import cycle, lines, written
from tests.stiffness.model.test_datasheet import BARE, robot_text

RAN = "index,kind,q1_deg\n0,cut,1\n1,cut,2\n"
WRENCHES = "index,fx,fy,fz,mx,my,mz\n" + "".join(f"{k},-300,200,250,5,-4,3\n" for k in range(len(small_job.ROWS)))


@dataclass(frozen=True)
class VerbJob:
    """A run that takes about a second.

    Attributes:
        arguments: all but outputs; files are in the folder of the job.
        reads: every file of that folder which the run reads.
        writes: option -> usual name of the file.
        beside: what it writes beside these.
        overwrites: whether it runs where files of these names stand already.
        keeps: folders beside the outputs that a run which was ended leaves for the next to go on with.
    """

    arguments: tuple[str, ...]
    reads: tuple[str, ...]
    writes: dict[str, str] = field(default_factory=dict)
    beside: tuple[str, ...] = ()
    overwrites: bool = True
    keeps: tuple[str, ...] = ()


PATH = ("path.csv", "cell.toml", "model.toml", "arm.toml", "w.csv")
MILLED = ("path.csv", "mill.toml", "model.toml", "arm.toml", "stock.stl", "own.toml")
CUT = {"--engagement": "cut.csv", "--left": "out.stl"}
PICTURES = {"--glb": "out.glb", "--pdf": "out.pdf"}
SESSION = ("session.toml", "samples.csv", "arm.toml")
JOBS = {
    "compensate": VerbJob(
        ("path.csv", "--cell", "mill.toml", "--format", "csv"),
        MILLED,
        {"-o": "out.csv", "--report": "out.html", "--json": "out.json", **CUT, **PICTURES},
    ),
    "preview": VerbJob(
        ("path.csv", "--cell", "mill.toml"),
        MILLED,
        {"--csv": "out.csv", "--report": "out.html", "--json": "out.json", **CUT, **PICTURES},
    ),
    "identify": VerbJob(
        ("session.toml", "--effects", "joint-stiffness", "--prior", "model.toml"),
        (*SESSION, "model.toml"),
        {"-o": "out.toml", "--report": "out.html", "--json": "out.json"},
    ),
    "diagnose": VerbJob(
        ("session.toml", "--model", "model.toml"),
        (*SESSION, "model.toml"),
        {"-o": "out.toml", "--report": "out.html", "--json": "out.json"},
    ),
    "evaluate": VerbJob(
        ("session.toml", "--model", "model.toml"), (*SESSION, "model.toml"), {"--json": "out.json"}
    ),
    "stiffness-map": VerbJob(
        ("model.toml", "--grid", "-20:20:20,10:50:20"),
        ("model.toml", "arm.toml"),
        {"--png": "out.png", "--csv": "out.csv", "--json": "out.json"},
    ),
    "clamped": VerbJob(
        ("readings.csv", "--robot", "geared.toml"),
        ("readings.csv", "geared.toml"),
        {"-o": "out.toml", "--json": "out.json"},
    ),
    "cutting": VerbJob(("forces.csv",), ("forces.csv",), {"-o": "out.toml", "--json": "out.json"}),
    "datasheet": VerbJob(("geared.toml",), ("geared.toml",), {"-o": "out.toml", "--json": "out.json"}),
    "axis-map": VerbJob(
        ("path.csv", "--cell", "cell.toml", "--poses", "6", "--turns", "12"),
        PATH,
        {"--csv": "out.csv", "--png": "out.png", "--report": "out.html", "--json": "out.json"},
    ),
    "place": VerbJob(
        (
            *("path.csv", "--cell", "cell.toml", "--box", "x=1500", "--poses", "10", "--turns", "2"),
            *("--workers", "1"),
        ),
        PATH,
        {"-o": "out.parquet", "--png": "out.png", "--best": "out.toml", "--json": "out.json"},
        overwrites=False,  # it goes on with a study that stands there
        keeps=("out.parquet.parts",),
    ),
    "check": VerbJob(("cell.toml", "path.csv"), PATH, {"--json": "out.json"}),
    "compare": VerbJob(("one.json", "other.json"), ("one.json", "other.json"), {"--json": "out.json"}),
    "init": VerbJob(
        (
            *("--robot", "arm.toml", "--tool", "0 0 250", "--part", "1500 -100 800", "--cam", "path.csv"),
            *("--stiffness", "unknown", "--controller", "rapid"),
        ),
        ("arm.toml", "path.csv"),
        {"-o": "out.toml", "--new-model": "out-model.toml"},
        overwrites=False,
    ),
    "plan": VerbJob(
        ("model.toml", "--session", "session.toml", "--toolpath", "path.csv", "--cell", "cell.toml", "--count", "2"),
        (*PATH, *SESSION),
        {"-o": "out.csv", "--json": "out.json", "--program": "out.mod"},
        beside=("session.toml", "samples.csv"),
        overwrites=False,
    ),
    "trace": VerbJob(
        ("points.csv", "--frame", "base", "--noise", "0.01", "--cell", "cell.toml", "--program", "ran.csv"),
        ("points.csv", "cell.toml", "ran.csv"),
        {"-o": "out.toml", "--samples": "out.csv", "--json": "out.json"},
    ),
    "verify": VerbJob(
        ("program.mod", "--cell", "cell.toml", "--toolpath", "path.csv"), ("program.mod", *PATH), {"--json": "out.json"}
    ),
}


def outputs(verb: str) -> list[str]:
    """Options of a verb that name a file to write, as the command line has them."""
    return [p.opts[0] for p in main.commands[verb].params if p.type is OUTPUT]


def files_of(command: click.Command) -> list[click.Parameter]:
    """Arguments and options that are files."""
    return [p for p in command.params if isinstance(p.type, click.Path | click.File)]


def write_inputs(folder: Path) -> None:
    """Everything that the jobs read, in one folder."""
    Lab().session(folder, 7, setups=8)
    session = folder / "session.toml"
    session.write_text(session.read_text().replace(f'"{small_job.ABB}"', '"arm.toml"'))
    arm = (Path(__file__).parents[1] / "stiffness" / "robot" / "data" / f"{small_job.ABB}.toml").read_text()
    (folder / "arm.toml").write_text(arm.replace(f'name = "{small_job.ABB}"', 'name = "arm"'))
    (folder / "w.csv").write_text(WRENCHES)
    process = {"kind": "table", "frame": "workobject", "file": "w.csv"}
    robot = {"robot": "arm.toml", "gravity": None}
    milled = small_job.files(folder, {**robot, "process": small_job.milling(folder)}, {"robot": "arm.toml"})
    milled.cell.rename(folder / "mill.toml")
    small_job.files(folder, {**robot, "process": process}, {"robot": "arm.toml"})
    (folder / "forces.csv").write_text(small_job.FORCES)
    (folder / "geared.toml").write_text(robot_text(*[BARE] * 6).replace('name = "arm"', 'name = "geared"'))
    written(folder, lines(cycle()))
    (folder / "points.csv").write_text("index,x_mm,y_mm,z_mm\n0,1,2,3\n1,2,3,4\n")
    (folder / "ran.csv").write_text(RAN)
    compensate_file(folder / "path.csv", folder / "cell.toml", folder / "program.mod")
    for name, error in (("one", 0.25), ("other", 0.5)):
        summary = {"schema": "path-summary/1", "findings": [], "predicted_error_mm": {"before": {"max": error}}}
        (folder / f"{name}.json").write_text(json.dumps(summary))


@cache
def input_bytes(folder: Path) -> dict[str, bytes]:
    """Name -> content of what ``write_inputs`` wrote."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}
