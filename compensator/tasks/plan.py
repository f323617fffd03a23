"""What `plan` does, from a model and what was measured to a list of set-ups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.assumptions import assumptions
from compensator.cell.controller_frames import session_frame_findings
from compensator.cell.job import Job, load_job
from compensator.errors import CompensatorError
from compensator.report.csv.plan import plan_csv
from compensator.report.json.findings import findings_report
from compensator.report.json.plan import plan_report
from compensator.report.json.text import as_json
from compensator.solve.compensate import uncompensated
from compensator.solve.planned import planned
from compensator.tasks.outputs import Outputs
from compensator.tasks.plan_session import add_session, session_findings, session_language
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError, StiffnessError
from stiffness.identification.readings import ReadingModel
from stiffness.model.model import ComplianceModel, load_model, robot_of
from stiffness.planning.design import Design, Loading, planned_layout
from stiffness.planning.plan import Plan, choose
from stiffness.planning.postures import reachable_postures
from stiffness.robot.robot import STANDARD_GRAVITY, Robot
from stiffness.session.file import Instruments, Reflector
from stiffness.session.session import Session, load_session
from stiffness.statics.tool import Tool
from toolpaths.files import read_toolpath
from toolpaths.finding import NOTE, Finding, of_kind
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

POSTURES = 300  # to choose from
COUNT = 12
FORCE = 100.0  # N, where neither the command line nor a session has one
LEVELS = (1.0,)
TWO_LEVELS = (0.4, 1.0)  # a gap and a softer flank are told apart by two
INSTRUMENTS = Instruments(2e-5, None, 0.3, 0.1)  # the paper's tracker and force sensor
OFFSET_POINT, ON_LINK_3 = (0.15, 0.0, 0.0), (0.1, 0.1, 0.1)  # m from the TCP, m in link 3
POSES = 1000  # of a toolpath that are looked at


@dataclass(frozen=True, repr=False)
class Planned:
    """A plan, its JSON report, one sentence for people, and the files that were written."""

    plan: Plan
    report: dict[str, Any]
    sentence: str
    files: tuple[Path, ...]


@writes("output", "json", "program")
def plan_file(
    model: Path,
    output: Path,
    *,
    sessions: Sequence[Path] = (),
    count: int = COUNT,
    force: float | None = None,
    toolpath: Path | None = None,
    cell: Path | None = None,
    seed: int = 0,
    json: Path | None = None,
    program: Path | None = None,
    language: str | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Planned:
    """A model that is roughly right in, set-ups to measure next out.

    Args:
        program: that drives to them, with session.toml and samples.csv to fill in beside it. language: of it.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    _check_options(count=count, force=force, toolpath=toolpath, cell=cell, seed=seed)
    say("reading the model")
    loaded = load_model(model)
    robot = robot_of(loaded)
    _check_masses(loaded, robot)
    measured = [load_session(path) for path in sessions]
    for s in measured:
        _check_same(model=loaded, robot=robot, other=s.robot, gravity=s.gravity, source=s.source)
    job = None if cell is None else _job(cell, loaded, robot)
    path = None if job is None or toolpath is None else _read(job, toolpath)
    spoken = session_language(program, language)
    tool, notes = _tool(measured, job)
    design = _design(
        model=loaded,
        robot=robot,
        tool=tool,
        reflectors=_reflectors(measured, tool, robot.n),
        from_model=not measured,
    )
    loading, more = _loading(design, measured, force)
    say("looking for postures")
    postures = reachable_postures(robot, tool, max(POSTURES, 2 * count), seed)
    before = sum((design.measured(s) for s in measured), design.known)
    matters = None
    if job is not None and path is not None:
        say("following the toolpath")
        matters = _path(loaded, robot, job, path)
    say("choosing")
    plan = choose(design=design, postures=postures, loading=loading, count=count, before=before, matters=matters)
    report = plan_report(plan, seed, [*notes, *more])
    noted = [Finding(NOTE, "", text) for text in (*notes, *more)]
    told = [*session_frame_findings(measured), *assumptions(robot, loaded), *noted]
    found = of_kind("model", told) if spoken is None else (*of_kind("model", told), *session_findings())
    report["findings"] = findings_report(found)
    refuse_warnings(report, strict)
    beside: tuple[Path, ...] = ()
    with Outputs() as outputs:
        outputs.text(output, plan_csv(plan))
        if spoken is not None and program is not None:
            say(f"writing {spoken.name}")
            beside = add_session(outputs, program, spoken, plan=plan, tool=tool, model=loaded)
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    return Planned(plan, report, report["sentence"], (*(p for p in (output, json) if p), *beside))


def _check_options(
    *, count: int, force: float | None, toolpath: Path | None, cell: Path | None, seed: int
) -> None:
    if not 1 <= count <= 1000:
        raise CompensatorError(f"--count {count}: expected 1 ... 1000 set-ups")
    if force is not None and not 0 < force < 1e6:
        raise CompensatorError(f"--force {force:g}: expected N above 0, the largest force the arm may be pulled with")
    if toolpath is not None and cell is None:
        raise CompensatorError(f"--toolpath {toolpath}: needs --cell, which says where the part and the tool are")
    if seed < 0:
        raise CompensatorError(f"--seed {seed}: expected a whole number from 0")


def _check_masses(model: ComplianceModel, robot: Robot) -> None:
    if model.gravity == "uncompensated" and robot.mass is None:
        raise ModelError(
            f"{model.source}: gravity = 'uncompensated' needs the masses of {robot.name}: {robot.mass_problem}"
        )


def _check_same(model: ComplianceModel, robot: Robot, other: Robot, *, gravity: str, source: str) -> None:
    if not robot.same_kinematics(other):
        raise StiffnessError(f"{source}: robot {other.name} is not that of the model {model.source} ({robot.name})")
    if gravity != model.gravity:
        raise StiffnessError(
            f"{source}: gravity = {gravity!r}, but the model {model.source} has {model.gravity!r}: what they say of a "
            "stiffness does not add up"
        )


def _job(cell: Path, model: ComplianceModel, robot: Robot) -> Job:
    job = load_job(cell)
    _check_same(model=model, robot=robot, other=job.arm.robot, gravity=model.gravity, source=str(cell))
    tools = job.placement.tools.by_number
    if len(tools) > 1:
        raise CompensatorError(f"{cell}: {len(tools)} tools; a plan is for one: give a cell with one [tool]")
    return job


def _tool(measured: Sequence[Session], job: Job | None) -> tuple[Tool, list[str]]:
    """The tool to measure with: that of the last session, else of the cell, else none."""
    if measured:
        return measured[-1].tool.tool(), []
    if job is not None:
        return job.placement.tools.first, []
    note = "no session and no cell says what tool hangs on the flange: the TCP is the flange"
    return Tool(np.eye(3), np.zeros(3)), [note]


def _reflectors(measured: Sequence[Session], tool: Tool, joints: int) -> tuple[Reflector, ...]:
    """Those of the last session, else the TCP, a point aside of it, and one on link 3."""
    if measured:
        return measured[-1].reflectors
    aside = tool.position + tool.rotation @ np.array(OFFSET_POINT)
    return (
        Reflector(name="tcp", link=joints, position=tool.position, exact=True, group=None),
        Reflector(name="aside", link=joints, position=aside, exact=True, group=None),
        Reflector(name="link3", link=3, position=np.array(ON_LINK_3), exact=True, group=None),
    )


def _design(
    model: ComplianceModel, robot: Robot, tool: Tool, reflectors: Sequence[Reflector], *, from_model: bool
) -> Design:
    effects, _ = model.applied(tool.name)
    values = {e.name: model.values[e.name] for e in effects}
    return Design(_reading_model(model, robot, effects, tool), values, reflectors, model.sd if from_model else None)


def _reading_model(model: ComplianceModel, robot: Robot, effects: Sequence[Effect], tool: Tool) -> ReadingModel:
    return ReadingModel(
        robot,
        planned_layout(effects, robot.n),
        {e.name: model.values[e.name] for e in effects},
        tool,
        gravity=np.array(STANDARD_GRAVITY),
        calibrated_out=model.gravity == "calibrated-out",
    )


def _loading(design: Design, measured: Sequence[Session], force: float | None) -> tuple[Loading, list[str]]:
    notes = []
    if force is None:
        largest = [float(np.linalg.norm(s.samples.load.wrench[:, :3], axis=1).max()) for s in measured]
        force = max(largest, default=0.0) or FORCE
        source = "the largest of the sessions" if any(largest) else "an assumption"
        notes.append(f"loads up to {force:.0f} N: {source}; --force says otherwise")
    instruments = measured[-1].instruments if measured else INSTRUMENTS
    if not measured:
        notes.append("noise: 0.02 mm of the tracker, 0.3 N and 0.1 N*m of the sensor, an assumption")
    return Loading(force, TWO_LEVELS if design.remembers else LEVELS, instruments), notes


def _read(job: Job, toolpath: Path) -> Toolpath:
    return read_toolpath(toolpath, chord=job.placement.sampling.chord / 1e3, machine=job.placement.machine)


def _path(model: ComplianceModel, robot: Robot, job: Job, path: Toolpath) -> Floats:
    """What of the parameters matters to the deflection at the poses of a toolpath that cut."""
    followed = uncompensated(job, planned(job, path))
    cutting = np.flatnonzero(followed.cutting)
    some = cutting if len(cutting) else np.arange(len(followed))
    rows = some[np.unique(np.linspace(0, len(some) - 1, min(POSES, len(some))).astype(int))]
    design = _design(
        model=model, robot=robot, tool=job.placement.tools.first, reflectors=(), from_model=False
    )
    state = _flanks(design, job, followed.state.middle[rows])
    return design.of_path(followed.path.q[rows], followed.wrench[rows], state)


def _flanks(design: Design, job: Job, state: Floats) -> Floats:
    """(N, m) flanks of the path as a share of their range; where the cell's model knows of others, the middle."""
    own = [e for e in design.layout.effects if e.memory]
    theirs = [e for e in job.arm.effects if e.memory]
    if [e.name for e in own] != [e.name for e in theirs]:
        return np.zeros((len(state), design.model.statics.n_state))
    half = [e.memory.bounds(job.arm.values[e.name]) for e in theirs if e.memory]
    return np.asarray(state / np.maximum(np.concatenate(half), 1e-12)) if half else state
