"""Folders of files that stand for the words of a page, and what its reader does between two commands."""

from __future__ import annotations

import shlex
from pathlib import Path
from shutil import copy

import numpy as np

from tests import first_part, test_own_effect, verb_jobs
from tests.compensator import filled_session, small_job
from tests.compensator.api.test_python_page import PART
from tests.compensator.devices import device_samples
from tests.compensator.plant_bench import MM, TOOL
from tests.compensator.program.test_several_files import OWN, START
from tests.compensator.trace.test_traces_of_the_plant import CENTRE, NOISE, circles
from tests.oracles.robot_programs import RAPID
from tests.pages.page_commands import DOCS, shell_lines
from tests.plant.lab import Form, Noise, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import Lab
from tests.toolpaths.languages.test_programs_of_several_files import KRL_FILES, put
from tests.trace_bench import ballbar

BAND = [0.5 * k for k in small_job.STIFFNESS]
WIDE = {"effects": {"joint-stiffness": {"k_nm_per_rad": small_job.STIFFNESS, "sd_nm_per_rad": BAND}}}
TRUE = [1.3 * k for k in small_job.STIFFNESS]
PASSES = 60  # lines of the wave that are left


def everything(folder: Path) -> None:
    """What the small jobs of all verbs read, and part.nc."""
    folder.mkdir()
    verb_jobs.write_inputs(folder)
    (folder / "part.nc").write_text(PART)
    (folder / "plain").mkdir()
    small_job.files(folder / "plain")
    (folder / "plain" / "part.mod").write_bytes(RAPID.replace("\n", "\r\n").encode())


def cam_file(folder: Path) -> None:
    """A CAM file alone."""
    folder.mkdir()
    (folder / "part.nc").write_text(PART)


def no_cell(folder: Path) -> None:
    """The reader who takes the other way to a first cell, after a look at the first."""
    for name in ("cell.toml", "stiffness.toml"):
        (folder / name).unlink()


def wave(folder: Path) -> None:
    """What the page copies, the beginning of it."""
    (line,) = shell_lines("tutorial", "mkdir")
    made, copied, inside = (shlex.split(part) for part in line.split(" && "))
    assert made[1] == copied[-1] == inside[-1]
    folder.mkdir()
    for name in copied[1:-1]:
        copy(DOCS.parent / name, folder)
    path = folder / "wave.nc"
    path.write_text("\n".join([*path.read_text().splitlines()[:PASSES], "G0 Z20", "M5", "M30\n"]))


def first_cell(folder: Path) -> None:
    """The cell of tests/first_part.py."""
    folder.mkdir()
    first_part.cell(folder).cell()
    first_part.toolpath_of(folder)


def cut_and_measured(folder: Path) -> None:
    """The plant, in a harder material than the cell has it, cuts first.csv."""
    _, there, side = first_part.toolpath_of(folder)
    ran = first_part.ran(first_part.cell(folder), folder / "first.csv", first_part.CAUSES[0])
    assert first_part.measured(ran, there, side) == folder / "part.toml"


def with_the_refined_model(folder: Path) -> None:
    first_part.refined(folder / "cell.toml")


def plan_day(folder: Path) -> None:
    """The small job, its model roughly known and called as on the page."""
    folder.mkdir()
    job = small_job.files(folder, {"gravity": None, "tip": None, "model": "stiffness.toml"}, WIDE)
    (folder / "model.toml").rename(folder / "stiffness.toml")
    job.toolpath.rename(folder / "part.csv")


def measured(folder: Path) -> None:
    """day1/samples.csv filled in."""
    filled_session.fill_in(folder / "day1", TRUE)


def traces(folder: Path) -> None:
    """A ball-bar and a session of the same arm."""
    folder.mkdir()
    ran = circles(folder, points=40)
    ballbar(ran, NOISE, CENTRE, name="trace")
    plant = ran.bench.plant()
    tcp = Target("tcp", 6, MM * np.array(TOOL["xyz"]))
    setups = random_setups(plant.arm, 8, 3, force=800.0, levels=(0.4, 1.0))
    measure(plant, setups, [tcp], noise=Noise(), form=Form(), seed=5).write(folder, small_job.ABB)
    (folder / "model.toml").rename(folder / "stiffness.toml")


def devices(folder: Path) -> None:
    """Files as devices write them, the nominals of one, and what the trace names."""
    folder.mkdir()
    small_job.files(folder)
    measured = "\n".join(f"{10 * k},5,0.00{k}" for k in range(6))
    texts = {
        "points.txt": device_samples.SA,
        "report.txt": device_samples.PCDMIS,
        "drawing.csv": device_samples.NOMINALS,
        "cmm.csv": f"Nom X,Nom Y,Dev\n{measured}\n",
        "run.csv": verb_jobs.RAN,
    }
    for name, text in texts.items():
        (folder / name).write_text(text)


def krl_job(folder: Path) -> None:
    """A main program with two operations; its tool is that of the cell."""
    folder.mkdir()
    small_job.files(folder, {**OWN, "tool": {"xyz": [30.0, -20.0, 240.0], "rpy": [0.0, 0.0, 0.0]}})
    (folder / "out").rmdir()
    changes = (("TOOL_DATA[3]", "{X 30,Y -20,Z 240,A 0,B 0,C 0}"), START, ("JOB", "main"))
    files = dict(KRL_FILES)
    for change in changes:
        files = {name.replace("JOB", "main"): text.replace(*change) for name, text in files.items()}
    put(folder / "JOB", files)


def own_effect(folder: Path) -> None:
    """The package of the page as if it were installed, and a session."""
    folder.mkdir()
    for name, text in test_own_effect.blocks().items():
        (folder / name).write_text(text, encoding="utf-8")
    test_own_effect.installed(folder, "dresspack-effect", {"dress-pack": "dresspack:EFFECT"})
    Lab().session(folder, 7, setups=8)
