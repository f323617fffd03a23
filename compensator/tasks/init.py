"""`init`: the answers become a cell that runs, and a model with a wide band where no stiffness is known."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.cell.cell_file import load_cell
from compensator.cell.controller_frames import new_cell_findings
from compensator.cell.new_cell import CellAnswers, assumed_wrench, cell_text, numbers_of, tools_of
from compensator.cell.new_cut import NONE, UNKNOWN, CutAnswers, cut_lines, wrench_lines
from compensator.errors import CompensatorError
from compensator.report.json.findings import findings_report
from compensator.tasks.init_cut import cut_asked, refuse_unfit, used_tools
from compensator.tasks.outputs import Outputs
from compensator.tasks.robot_reference import robot_beside
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from stiffness.errors import RobotError
from stiffness.model.frames import other_frames_remedy
from stiffness.model.model import ComplianceModel, builtin_model, load_model, model_text, robot_of
from stiffness.model.sister import starting_model
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.robot.robot import Robot
from stiffness.robot.tips import MAKERS
from toolpaths.errors import ToolpathError
from toolpaths.files import language_of, read_program
from toolpaths.finding import WARNING, Finding
from toolpaths.program_files import program_files
from toolpaths.toolpath import Toolpath

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
            ``controller``: the language of the programs to write; and where the force of the cut is to be computed
            ``cutter``, ``material``, ``stock``, ``spindle_rpm``, as in docs/init.md; without ``cutter`` it is assumed.
        new_model: where the model goes when the stiffness is unknown; None: ``stiffness.toml`` beside the cell.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: an answer is refused, or a file stands there already.
    """
    stiffness = answers["stiffness"]
    if stiffness != UNKNOWN and new_model is not None:
        raise CompensatorError(f"{new_model}: no model is made: --stiffness names {stiffness}; leave --new-model out")
    asked = _Question(
        robot=answers["robot"],
        tool=answers["tool"],
        part=numbers_of(answers["part"], (3, 6), "part"),
        cam=Path(answers["cam"]),
        controller=answers["controller"],
        cut={key: answers.get(key, "") for key in ("cutter", "material", "stock", "spindle_rpm")},
    )
    if stiffness == UNKNOWN:
        return _with_new_model(asked, output, new_model or _beside(output), say)
    return _with_known_model(asked, output, stiffness, say)


@dataclass(frozen=True)
class _Question:
    """The answers."""

    robot: str
    tool: str
    part: tuple[float, ...]
    cam: Path
    controller: str
    cut: Mapping[str, str]


@dataclass(frozen=True)
class _Read:
    """Robot, its base and tip where they have to be named, tools by number, the CAM file where it can be read, what was
    found."""

    robot: Robot
    base: str | None
    tip: str | None
    tools: Mapping[int | None, tuple[float, ...]]
    toolpath: Toolpath | None
    findings: tuple[Finding, ...]


@writes("output", "new_model")
def _with_new_model(asked: _Question, output: Path, new_model: Path, say: Say) -> NewCell:
    read = _read(asked, say)
    for file in (output, new_model):
        _refuse_standing(file)
    made = starting_model(read.robot, robot_beside(Path(), asked.robot, new_model))
    model, cut = _seen_from(output, new_model), _cut(asked, output, read)
    text = cell_text(_answers(asked, output, read, model=model, known=False, cut=cut), output.name)
    files, found = _write(output, text, (new_model, model_text(made)), read=read, cut=cut)
    source = made.provenance.get("source", "data sheets of its reducers")
    what = f"the stiffness of this robot is not measured, a wide band is taken; from: {source}"
    remedy = "`compensator check` tells what that is worth, `compensator plan` what to measure"
    found = (*found, Finding(WARNING, str(new_model), what, remedy, kind="model"))
    return NewCell(files, {"findings": findings_report([*read.findings, *found, *_assumed(read, cut)])})


@writes("output")
def _with_known_model(asked: _Question, output: Path, stiffness: str, say: Say) -> NewCell:
    read = _read(asked, say)
    _refuse_other_frames(load_model(stiffness, read.robot.n), read.robot)
    _refuse_standing(output)
    model = stiffness if builtin_model(stiffness) is not None else _seen_from(output, Path(stiffness))
    cut = _cut(asked, output, read)
    text = cell_text(_answers(asked, output, read, model=model, known=True, cut=cut), output.name)
    files, found = _write(output, text, read=read, cut=cut)
    return NewCell(files, {"findings": findings_report([*read.findings, *found, *_assumed(read, cut)])})


def _read(asked: _Question, say: Say) -> _Read:
    say("reading the robot")
    robot, base, tip, frames = _with_frames(asked.robot)
    if asked.robot not in builtin_robots():
        Path(asked.robot).read_bytes()  # a URDF is read by C++: this tells the run that it is an input
    say(f"reading {asked.cam.name}")
    toolpath, found = _readable(asked.cam)
    used = [] if toolpath is None else used_tools(toolpath)
    tools = tools_of(asked.tool, used)
    if len(used) > 1 and "=" not in asked.tool:
        what = f"the CAM file cuts with {len(used)} tools, and all are taken to be as long as the one that is given"
        found = (*found, Finding(WARNING, "tools", what, "Give --tool '1=X Y Z; 2=X Y Z'", kind="cell"))
    return _Read(robot, base, tip, tools=tools, toolpath=toolpath, findings=(*frames, *found))


def _with_frames(name: str) -> tuple[Robot, str | None, str | None, tuple[Finding, ...]]:
    """The robot, its base and its tip where they have to be named, and what is to be said about them."""
    robot = load_robot(name)
    if robot.former_flange is not None:
        return load_robot(name, tip=MAKERS), None, MAKERS, ()
    base, tip = (None if frame is None else frame.name for frame in (robot.base_frame, robot.flange_frame))
    return load_robot(name, base=base, tip=tip), base, tip, new_cell_findings(name, robot)


def _refuse_other_frames(model: ComplianceModel, robot: Robot) -> None:
    """Refuse a model of this arm that was made for another base or tip than those that the cell is to name."""
    with suppress(RobotError):  # a model of a robot that is lost: `check` tells
        other = robot_of(model)
        if advice := other_frames_remedy(model, other, robot):
            differ = [key for key in ("base", "tip") if getattr(other, key) != getattr(robot, key)]
            made = " and ".join(f"{key} {getattr(other, key)!r}" for key in differ)
            asked = " and ".join(repr(getattr(robot, key)) for key in differ)
            raise CompensatorError(f"{model.source}: was made for {made}, the cell has {asked}: {advice}")


def _cut(asked: _Question, output: Path, read: _Read) -> CutAnswers | None:
    """Cutter, material and stock; None: the wrench is assumed."""
    if asked.cut["cutter"].strip() in ("", NONE):
        given = [f"--{key.replace('_', '-')}" for key in ("material", "stock", "spindle_rpm") if asked.cut[key]]
        if given:
            raise CompensatorError(f"{', '.join(given)} without --cutter: the force is computed from all three")
        return None
    return cut_asked(asked.cut, read.toolpath, asked.cam, lambda file: _seen_from(output, file))


def _answers(
    asked: _Question, output: Path, read: _Read, *, model: str, known: bool, cut: CutAnswers | None
) -> CellAnswers:
    mass = read.robot.mass
    wrench = assumed_wrench(None if mass is None else float(mass.sum()))
    return CellAnswers(
        robot=robot_beside(Path(), asked.robot, output),
        base=read.base,
        tip=read.tip,
        tools=read.tools,
        part=asked.part,
        cam=_seen_from(output, asked.cam),
        model=model,
        known=known,
        process=wrench_lines(wrench) if cut is None else cut_lines(cut),
        controller=asked.controller,
        suffix=language_of(asked.cam, asked.controller).writes,
    )


def _write(
    output: Path, text: str, *others: tuple[Path, str], read: _Read, cut: CutAnswers | None
) -> tuple[tuple[Path, ...], tuple[Finding, ...]]:
    found: tuple[Finding, ...] = ()
    with Outputs() as outputs:
        with outputs.writing(output, ".toml") as staged:
            staged.write_bytes(text.encode())
            cell = load_cell(staged)  # what it refuses is refused here
            if cut is not None:
                folder = Path() if output == STDOUT else output.parent
                found = refuse_unfit(cell.model_copy(update={"folder": folder, "source": str(output)}), read.toolpath)
        outputs.add(staged, output)
        for file, content in others:
            outputs.text(file, content)
        outputs.commit()
    return (output, *(file for file, _ in others)), found


def _readable(cam: Path) -> tuple[Toolpath | None, tuple[Finding, ...]]:
    """The toolpath; a warning where it is not read without more in the cell, such as the machine it was posted for."""
    if not cam.exists():
        raise CompensatorError(f"{cam}: there is no such file; give the CAM file that the cell is for")
    try:
        return read_program(program_files([cam])), ()
    except ToolpathError as e:
        what = f"is refused with this cell: {e}"
        return None, (Finding(WARNING, str(cam), what, "See docs/toolpaths-in.md", kind="toolpath"),)


def _assumed(read: _Read, cut: CutAnswers | None) -> list[Finding]:
    out = []
    if cut is None:
        what = "the wrench is an assumption: a light finishing cut in aluminium"
        remedy = "Give --cutter, --material and --stock, and it is computed; or put in that of your cut"
        out.append(Finding(WARNING, "process", what, remedy, kind="process"))
    elif cut.assumed:
        what = f"the stock is an assumption: a full block around the cuts, {cut.stock.box}"
        out.append(Finding(WARNING, "process.stock", what, "Give yours: its material makes the force", kind="process"))
    if any(len(tool) < 4 for tool in read.tools.values()):
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
