"""`init`: six answers become a cell that runs, and a model with a wide band where no stiffness is known."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.cell.cell_file import load_cell
from compensator.cell.new_cell import CellAnswers, assumed_wrench, cell_text, numbers_of
from compensator.errors import CompensatorError
from compensator.report.json.findings import findings_report
from compensator.tasks.outputs import Outputs
from compensator.tasks.robot_reference import robot_beside
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from stiffness.model.model import builtin_model, load_model, model_text
from stiffness.model.sister import starting_model
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.robot.robot import Robot
from stiffness.robot.tips import MAKERS
from toolpaths.errors import ToolpathError
from toolpaths.files import language_of, read_program
from toolpaths.finding import WARNING, Finding
from toolpaths.program_files import program_files

UNKNOWN = "unknown"
MODEL = "stiffness.toml"


@dataclass(frozen=True, repr=False)
class NewCell:
    """What was written, and ``report`` with the findings about it."""

    files: tuple[Path, ...]
    report: dict[str, Any]


def init_files(
    answers: Mapping[str, str],
    *,
    output: Path = Path("cell.toml"),
    new_model: Path | None = None,
    say: Say = quiet,
) -> NewCell:
    """Write a commented cell.

    Args:
        answers: ``robot``: built-in name or file; ``tool``: "x y z" of the TCP in the flange, mm, and its mass, kg,
            where known; ``part``: "x y z", mm, of the zero of the CAM file in the base, and roll, pitch, yaw, deg,
            where it is turned; ``cam``: the CAM file; ``stiffness``: a model file, a built-in set, or "unknown";
            ``controller``: the language of the programs to write.
        new_model: where the model goes when the stiffness is unknown; None: ``stiffness.toml`` beside the cell.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: an answer is refused, or a file stands there already.
    """
    stiffness = answers["stiffness"]
    if stiffness != UNKNOWN and new_model is not None:
        raise CompensatorError(f"{new_model}: no model is made: --stiffness names {stiffness}; leave --new-model out")
    asked = _Question(
        robot=answers["robot"],
        tool=numbers_of(answers["tool"], (3, 4), "tool"),
        part=numbers_of(answers["part"], (3, 6), "part"),
        cam=Path(answers["cam"]),
        controller=answers["controller"],
    )
    if stiffness == UNKNOWN:
        return _with_new_model(asked, output, new_model or _beside(output), say)
    return _with_known_model(asked, output, stiffness, say)


@dataclass(frozen=True)
class _Question:
    """The answers, in numbers."""

    robot: str
    tool: tuple[float, ...]
    part: tuple[float, ...]
    cam: Path
    controller: str


@writes("output", "new_model")
def _with_new_model(asked: _Question, output: Path, new_model: Path, say: Say) -> NewCell:
    arm, tip, found = _read(asked, say)
    for file in (output, new_model):
        _refuse_standing(file)
    made = starting_model(arm, robot_beside(Path(), asked.robot, new_model))
    model = _seen_from(output, new_model)
    text = cell_text(_answers(asked, output, (arm, tip), model=model, known=False), output.name)
    files = _write(output, text, (new_model, model_text(made)))
    source = made.provenance.get("source", "data sheets of its reducers")
    what = f"the stiffness of this robot is not measured, a wide band is taken; from: {source}"
    remedy = "`compensator check` tells what that is worth, `compensator plan` what to measure"
    found = [*found, Finding(WARNING, str(new_model), what, remedy, kind="model")]
    return NewCell(files, {"findings": findings_report([*found, *_assumed(asked)])})


@writes("output")
def _with_known_model(asked: _Question, output: Path, stiffness: str, say: Say) -> NewCell:
    arm, tip, found = _read(asked, say)
    load_model(stiffness, arm.n)
    _refuse_standing(output)
    model = stiffness if builtin_model(stiffness) is not None else _seen_from(output, Path(stiffness))
    text = cell_text(_answers(asked, output, (arm, tip), model=model, known=True), output.name)
    files = _write(output, text)
    return NewCell(files, {"findings": findings_report([*found, *_assumed(asked)])})


def _read(asked: _Question, say: Say) -> tuple[Robot, str | None, list[Finding]]:
    """Robot, its tip where it has to be named, and findings about the CAM file."""
    say("reading the robot")
    robot, tip = load_robot(asked.robot), None
    if robot.former_flange is not None:
        robot, tip = load_robot(asked.robot, tip=MAKERS), MAKERS
    if asked.robot not in builtin_robots():
        Path(asked.robot).read_bytes()  # a URDF is read by C++: this tells the run that it is an input
    say(f"reading {asked.cam.name}")
    return robot, tip, _readable(asked.cam)


def _answers(
    asked: _Question, output: Path, arm: tuple[Robot, str | None], *, model: str, known: bool
) -> CellAnswers:
    robot, tip = arm
    return CellAnswers(
        robot=robot_beside(Path(), asked.robot, output),
        tip=tip,
        tool=asked.tool,
        part=asked.part,
        cam=_seen_from(output, asked.cam),
        model=model,
        known=known,
        wrench=assumed_wrench(None if robot.mass is None else float(robot.mass.sum())),
        controller=asked.controller,
        suffix=language_of(asked.cam, asked.controller).writes,
    )


def _write(output: Path, text: str, *others: tuple[Path, str]) -> tuple[Path, ...]:
    with Outputs() as outputs:
        with outputs.writing(output, ".toml") as staged:
            staged.write_bytes(text.encode())
            load_cell(staged)  # what it refuses is refused here
        outputs.add(staged, output)
        for file, content in others:
            outputs.text(file, content)
        outputs.commit()
    return output, *(file for file, _ in others)


def _readable(cam: Path) -> list[Finding]:
    """A warning where the CAM file is not read without more in the cell, such as the machine it was posted for."""
    if not cam.exists():
        raise CompensatorError(f"{cam}: there is no such file; give the CAM file that the cell is for")
    try:
        read_program(program_files([cam]))
    except ToolpathError as e:
        what = f"is refused with this cell: {e}"
        return [Finding(WARNING, str(cam), what, "See docs/toolpaths-in.md", kind="toolpath")]
    return []


def _assumed(asked: _Question) -> list[Finding]:
    what = "the wrench is an assumption: a light finishing cut in aluminium"
    out = [Finding(WARNING, "process", what, "Put in that of your cut", kind="process")]
    if len(asked.tool) < 4:
        what = "no mass given, its weight is not modelled"
        out.append(Finding(WARNING, "tool", what, "Give [tool] mass and com", kind="cell"))
    return out


def _refuse_standing(file: Path) -> None:
    if file != STDOUT and os.path.lexists(file):
        raise CompensatorError(f"{file}: stands there already, and init overwrites nothing; give another name")


def _beside(output: Path) -> Path:
    return Path(MODEL) if output == STDOUT else output.parent / MODEL


def _seen_from(output: Path, file: Path) -> str:
    """A path as the file ``output`` names it; on standard output as the working folder does."""
    folder = Path() if output == STDOUT else output.parent
    return Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
