"""Job: a cell with its robot, model and tools, all checked against each other, ready to predict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.cell.cell import Cell, load_cell
from compensator.errors import CellError, SolveError
from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import EquilibriumError, RobotError
from stiffness.kinematics.solvers import Inverse, inverse_kinematics
from stiffness.memory.preload import PreloadState, unknown
from stiffness.model.model import ComplianceModel, load_model
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.statics.predictor import COLUMNS, Command, Near, Prediction, Predictor, Tool
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
ONE_TOOL = 0  # key of the only tool, whatever number the file calls


@dataclass(frozen=True, repr=False)
class Job:
    """Everything but the toolpath.

    Attributes:
        cell, robot, inverse, model: as loaded.
        tools: number -> Tool; the single key ONE_TOOL where the cell has one [tool].
        effects, values: what acts on the path.
        not_applied: names of effects of the model that do not.
        notes: what the result does not know, in words, for every summary.
        predictors: one per tool.
    """

    cell: Cell
    robot: Robot
    inverse: Inverse
    model: ComplianceModel
    tools: dict[int, Tool]
    effects: tuple[Effect, ...]
    values: Mapping[str, Numbers]
    not_applied: tuple[str, ...]
    notes: tuple[str, ...]
    predictors: dict[int, Predictor] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"Job({self.cell!r}, effects {[e.name for e in self.effects]})"

    @property
    def state_before(self) -> PreloadState:
        """Before the first move nothing is known of the flanks."""
        return unknown(self.effects, self.values)

    def _by_tool(self, toolpath: Toolpath) -> Sequence[tuple[Predictor, npt.NDArray[np.intp] | slice]]:
        if len(self.tools) == 1:
            return [(next(iter(self.predictors.values())), slice(None))]
        rows = [(self.predictors[k], np.flatnonzero(toolpath.tool == k)) for k in self.tools]
        return [(p, r) for p, r in rows if len(r)]

    def command(
        self,
        toolpath: Toolpath,
        rotation: Floats,
        position: Floats,
        wrench: Floats,
        state: Floats,
        start: Floats,
        near: Near | None = None,
    ) -> Command:
        """Predictor.command with the tool of every pose."""
        done = []
        for p, r in self._by_tool(toolpath):
            begin = near and Near(near.q[r], near.actual[r], near.extra[r])
            done.append((r, p.command(rotation[r], position[r], wrench[r], state[r], start[r], begin)))
        if len(done) == 1:
            return done[0][1]
        q, actual, torque, turned, at, error, extra = (
            _merged(len(start), [(r, getattr(c, name)) for r, c in done]) for name in COLUMNS
        )
        return Command(q, actual, torque, turned, at, error, extra, max(c.steps for _, c in done))

    def forward(self, toolpath: Toolpath, q: Floats, wrench: Floats, state: Floats) -> Prediction:
        """Predictor.forward with the tool of every pose."""
        done = [(r, self._forward(toolpath, p, r, q, wrench, state)) for p, r in self._by_tool(toolpath)]
        if len(done) == 1:
            return done[0][1]
        names = ("rotation", "position", "torque", "residual")
        return Prediction(*(_merged(len(q), [(r, getattr(f, name)) for r, f in done]) for name in names))

    def _forward(
        self,
        toolpath: Toolpath,
        predictor: Predictor,
        rows: npt.NDArray[np.intp] | slice,
        q: Floats,
        wrench: Floats,
        state: Floats,
    ) -> Prediction:
        try:
            return predictor.forward(q[rows], wrench[rows], state[rows])
        except EquilibriumError as e:
            k = int(np.arange(len(q))[rows][e.row])
            where = f"{toolpath.source}:{toolpath.line[k]} (pose {toolpath.row[k]:g} of the file)"
            raise SolveError(f"{where}: {e.problem}") from e

    def joint_deflection(self, q: Floats, torque: Floats, state: Floats) -> Floats:
        """dq (N, n) of the joint laws alone."""
        return next(iter(self.predictors.values())).joint_deflection(q, torque, state)

    def joint_states(self, state: Floats) -> Floats:
        """(N, n) rad: the part of ``state`` that is itself a joint deflection."""
        n = self.robot.n
        total = np.zeros((len(state), n))
        at = 0
        for e in self.effects:
            if e.memory:
                if np.any(e.memory.gain(self.values[e.name]) != 0):
                    total += state[:, at : at + n]
                at += n
        return total


def _merged(rows: int, parts: Sequence[tuple[npt.NDArray[np.intp] | slice, Floats]]) -> Floats:
    out = np.empty((rows, *parts[0][1].shape[1:]))
    for r, values in parts:
        out[r] = values
    return out


def load_job(path: str | Path) -> Job:
    """Load a cell and what it names, and refuse what does not belong together.

    Raises:
        CellError, RobotError, ModelError: one message each.
    """
    return job_of(load_cell(path))


def job_of(cell: Cell) -> Job:
    """The job of a cell that is loaded already.

    Raises:
        CellError, RobotError, ModelError: one message each.
    """
    if "workobject" not in cell.model_fields_set:  # a robot program may bring its own
        raise CellError(f"{cell.source}: workobject is missing")
    if cell.tool is None and not cell.tools:
        raise CellError(f"{cell.source}: give either [tool] or [tools.1], [tools.2], ... by the number in the file")
    try:
        robot = load_robot(cell.robot, folder=cell.folder, base=cell.base, tip=cell.tip)
    except RobotError as e:
        raise CellError(f"{cell.source}: robot = {cell.robot!r}: {e}") from e
    model_path = cell.folder / cell.model
    model = load_model(model_path, robot.n)
    _same_robot(cell, robot, model, model_path)
    tools = {ONE_TOOL: cell.tool.tool()} if cell.tool else {k: t.tool() for k, t in cell.tools.items()}
    names = {t.name for t in tools.values()}
    if len(names) > 1 and any(e.scope == "tool" for e in model.effects):
        listed = ", ".join(sorted(names))
        raise CellError(f"{cell.source}: the model has effects of one tool; the cell has tools {listed}")
    effects, not_applied = model.applied(next(iter(names)))
    gravity = cell.gravity or model.gravity
    _masses(cell, robot, effects, gravity)
    values = {e.name: model.values[e.name] for e in effects}
    job = Job(
        cell, robot, inverse_kinematics(robot), model, tools, effects, values, not_applied,
        _notes(cell, robot, model, effects, gravity),
    )
    for number, tool in tools.items():
        job.predictors[number] = Predictor(
            robot, effects, values, tool, gravity=cell.gravity_in_base(),
            calibrated_out=gravity == "calibrated-out", complementary=cell.solve.complementary_stiffness,
            temperature=0.0 if cell.temperature is None else cell.temperature - model.reference_temperature,
        )
    return job


def _same_robot(cell: Cell, robot: Robot, model: ComplianceModel, path: Path) -> None:
    try:
        other = load_robot(model.robot, folder=path.resolve().parent, base=model.base, tip=model.tip)
    except RobotError as e:
        raise CellError(
            f"{cell.source}: the model {cell.model} is for robot {model.robot!r}, which cannot be loaded to compare it "
            f"with {cell.robot!r}: {e}"
        ) from e
    if other.name != robot.name and cell.robot != model.robot:
        raise CellError(
            f"{cell.source}: robot {cell.robot!r} and model {cell.model} (for {model.robot!r}) do not belong together; "
            "a stiffness model holds for the robot it was identified on"
        )
    same = all(
        a.shape == b.shape and np.allclose(a, b, atol=1e-9)
        for a, b in ((robot.before, other.before), (robot.axis, other.axis), (robot.after, other.after))
    )
    if not same:
        raise CellError(
            f"{cell.source}: base {robot.base!r} and tip {robot.tip!r} of the cell are not the frames of the model "
            f"{cell.model} (base {other.base!r}, tip {other.tip!r}), or the robot file has changed since"
        )


def _masses(cell: Cell, robot: Robot, effects: Sequence[Effect], gravity: str) -> None:
    if robot.mass is None and gravity == "uncompensated":
        raise CellError(
            f"{cell.source}: gravity = 'uncompensated' needs the link masses of {robot.name}: {robot.mass_problem}; "
            "give them in the robot file, or set gravity = \"calibrated-out\" if the controller takes the sag off"
        )
    if robot.mass is None and any(e.needs_torque_sign for e in effects):
        names = ", ".join(e.name for e in effects if e.needs_torque_sign)
        raise CellError(
            f"{cell.source}: {names} depends on the gravity torque of every joint, but {robot.mass_problem}; "
            "give link masses in the robot file or leave the effect out of the model"
        )


def _notes(
    cell: Cell, robot: Robot, model: ComplianceModel, effects: Sequence[Effect], gravity: str
) -> tuple[str, ...]:
    notes = [f"{robot.name}: {text}" for text in robot.assumptions]
    if model.provenance.get("kind") == "assumption":
        notes.append(f"{model.source}: the stiffness values are an assumption: {model.provenance.get('source', '')}")
    if not any(model.sd.get(e.name) for e in effects):
        notes.append(f"{model.source}: no standard deviations: how sure the prediction is cannot be said")
    weightless = [t.name for t in ([cell.tool] if cell.tool else cell.tools.values()) if t and not t.mass]
    if weightless:
        notes.append(f"tool {', '.join(weightless)}: no mass given, its weight is not modelled")
    warm = cell.temperature is not None and cell.temperature != model.reference_temperature
    if warm and not any(e.thermal for e in effects):
        notes.append("temperature differs from the model's reference; the model has no thermal effect")
    if gravity == "calibrated-out":
        notes.append("gravity: the controller is taken to know the sag of arm and tool")
    return tuple(notes)


def check_tools(job: Job, toolpath: Toolpath) -> None:
    """Refuse a tool call that the cell has no entry for.

    Raises:
        CellError: names the source line.
    """
    if ONE_TOOL in job.tools and len(job.tools) == 1 and job.cell.tool is not None:
        return
    missing = ~np.isin(toolpath.tool, list(job.tools))
    if missing.any():
        k = int(np.argmax(missing))
        number = int(toolpath.tool[k])
        what = f"tool {number} is called" if number else "moves before any tool call"
        raise CellError(
            f"{toolpath.source}:{toolpath.line[k]}: {what}, but {job.cell.source} has [tools.N] for "
            f"{', '.join(map(str, sorted(job.tools)))} only"
        )


def check_cuts(toolpath: Toolpath) -> None:
    """Refuse a path that never cuts.

    Raises:
        CellError: names the file.
    """
    if not np.any(toolpath.kind == CUT):
        raise CellError(f"{toolpath.source}: no cutting move (feed) in it: nothing to compensate")
