"""One timed job in a process of its own: ``python -m benchmarks.job compensate|text|preview|program|filter FOLDER``.

``program`` writes the RAPID program of the nominal path that ``filter`` compensates in place.

Prints JSON: seconds of the job without the start of Python, and the peak memory of the process.
"""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line has it

import numpy as np

from benchmarks.timing import peak_mb

CELL = """schema = "cell/1"
robot = "abb-irb6600-175-255"
tip = "tool0"
model = "model.toml"
gravity = "uncompensated"
[tool]
xyz = [20.0, -10.0, 250.0]
mass = 35.0
com = [0.0, 10.0, 120.0]
[workobject]
xyz = [1500.0, -300.0, 800.0]
[process]
kind = "constant"
frame = "path"
wrench = [-320.0, 210.0, -260.0, 8.0, -5.0, 3.0]
[solve]
max_correction = 20.0
[sampling]
spacing = 50.0
"""
SPRINGS = """schema = "model/1"
robot = "abb-irb6600-175-255"
gravity = "uncompensated"
[effects.joint-stiffness]
k_nm_per_rad = [2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4]
"""
MEMORY = (
    SPRINGS
    + """[effects.preload-softening]
ratio = [0.747, 0.9, 0.9, 0.8, 0.8, 0.8]
[effects.backlash]
gap_rad = [6.0e-5, 5.0e-5, 6.0e-5, 1.1e-4, 1.6e-4, 2.2e-4]
"""
)


def write_inputs(folder: Path, poses: int, *, memory: bool = False) -> None:
    """A pocket of rows, half a millimetre from pose to pose, with a tilting tool: cell, model and csv."""
    (folder / "cell.toml").write_text(CELL)
    (folder / "model.toml").write_text(MEMORY if memory else SPRINGS)
    per_row = 800
    along = np.arange(poses) % per_row
    row = np.arange(poses) // per_row
    x = 0.5 * np.where(row % 2, per_row - 1 - along, along)
    y = np.minimum(2.0 * (row % 250), 498.0)
    z = 8.0 * np.sin(x / 60) * np.cos(y / 80) - 1.0 * (row // 250)
    i, j = 0.15 * np.sin(x / 70), 0.15 * np.cos(y / 90)
    table = np.column_stack([x, y, z, i, j, np.sqrt(1 - i * i - j * j), np.full(poses, 1800.0)])
    header = "x_mm,y_mm,z_mm,i,j,k,feed_mm_min"
    np.savetxt(folder / "path.csv", table, fmt="%.5f", delimiter=",", header=header, comments="")


def compensate(folder: Path) -> int:
    """The whole command, as the shell runs it; gives the number of poses."""
    from compensator.tasks.compensate import compensate_file

    done = compensate_file(folder / "path.csv", folder / "cell.toml", folder / "out.mod")
    return len(done.result)


def preview(folder: Path) -> int:
    """The prediction for every pose, as csv."""
    from compensator.tasks.compensate import preview_file

    done = preview_file(folder / "path.csv", folder / "cell.toml", csv=folder / "preview.csv")
    return len(done.result)


def program(folder: Path) -> int:
    """The nominal path as a RAPID program that nobody compensated."""
    from compensator.program.export import program_of
    from compensator.solve.compensate import uncompensated
    from compensator.solve.planned import planned
    from compensator.tasks.compensate import files_of, read_input
    from toolpaths.files import write_program

    (folder / "source").mkdir(exist_ok=True)
    given = read_input(files_of(folder / "path.csv", None), folder / "cell.toml")
    plain = uncompensated(given.job, planned(given.job, given.path))
    nominal = replace(program_of(plain, corrected=False, name="NOM"), heading="Program")
    write_program(nominal, folder / "source" / "nom.mod", "rapid")
    return len(plain)


def filter_in_place(folder: Path) -> int:
    """That program compensated in place, all of its files."""
    from compensator.tasks.compensate import compensate_file

    (folder / "filtered").mkdir(exist_ok=True)
    source = sorted((folder / "source").glob("nom*.mod"))
    done = compensate_file(source, folder / "cell.toml", folder / "filtered" / "nom.mod")
    return len(done.result)


def text(folder: Path) -> int:
    """The same text read and written, with nothing in between."""
    from compensator.path.free_turn import reference_rotation
    from toolpaths.files import read_toolpath, write_program
    from toolpaths.frame import Frame
    from toolpaths.tool_frame import ToolFrame
    from toolpaths.writing.program import Program

    path = read_toolpath(folder / "path.csv", chord=1e-5)
    program = Program(
        name="PART1",
        position=path.position,
        rotation=reference_rotation(path),
        joints=np.zeros((len(path), 6)),
        feed=path.feed,
        kind=path.kind,
        tool=path.tool,
        line=path.line,
        tools={0: ToolFrame("tool", Frame(np.eye(3), np.zeros(3)))},
        workobject=Frame.identity(),
        rapid_speed=0.25,
        configuration=np.zeros(len(path), dtype=np.int32),
        source=path.source,
    )
    write_program(program, folder / "text.mod", "rapid")
    return len(path)


JOBS = {"compensate": compensate, "text": text, "preview": preview, "program": program, "filter": filter_in_place}


def main() -> None:
    """Run one job and print its figures."""
    if len(sys.argv) != 3 or sys.argv[1] not in JOBS:
        raise SystemExit(__doc__)
    began = time.perf_counter()
    poses = JOBS[sys.argv[1]](Path(sys.argv[2]))
    seconds = time.perf_counter() - began
    print(json.dumps({"poses": poses, "seconds": seconds, "peak_mb": peak_mb()}))


if __name__ == "__main__":
    main()
