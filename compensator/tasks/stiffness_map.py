"""What `stiffness-map` does, from a model file to a picture and a table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from compensator.cell.assumptions import assumptions
from compensator.cell.placement_tables import ToolTable
from compensator.errors import CompensatorError
from compensator.report.csv.stiffness_map import map_csv
from compensator.report.json.findings import findings_report
from compensator.report.json.stiffness_map import map_report
from compensator.report.json.text import as_json
from compensator.tasks.joint_grid import grid_of
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError
from stiffness.model.model import ComplianceModel, load_model, robot_of
from stiffness.robot.robot import STANDARD_GRAVITY, Robot
from stiffness.statics.joint_grid import JointGrid
from stiffness.statics.stiffness_map import LIMIT, NO_EQUILIBRIUM, OK, SINGULAR, StiffnessMap, stiffness_map
from toolpaths.finding import NOTE, Finding, of_kind

Floats = npt.NDArray[np.float64]
PAPER_WRENCH = (200.0, 200.0, -2500.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, repr=False)
class Mapped:
    """What a map made: the postures, its JSON report, the files."""

    grid: JointGrid
    result: StiffnessMap
    report: dict[str, Any]
    files: tuple[Path, ...]


def tool_of(
    xyz: tuple[float, ...], rpy: tuple[float, ...], name: str, mass: float | None, com: tuple[float, ...] | None
) -> ToolTable:
    """A tool from the words of the command line: mm, deg, kg.

    Raises:
        CompensatorError: names the option.
    """
    try:
        return ToolTable.model_validate({"xyz": xyz, "rpy": rpy, "name": name, "mass": mass, "com": com})
    except ValidationError as e:
        found = e.errors()[0]
        place = "".join(f"-{p}" for p in found["loc"][:1])
        raise CompensatorError(f"--tool{place}: {found['msg'].removeprefix('Value error, ')}") from e


@writes("png", "csv", "json")
def map_file(
    model: Path,
    *,
    joints: str = "2,3",
    spans: str | None = None,
    fixed: str | None = None,
    wrench: tuple[float, ...] = PAPER_WRENCH,
    frame: str = "base",
    tool: ToolTable | None = None,
    weight: bool = True,
    min_singular_value: float = 0.02,
    png: Path | None = None,
    csv: Path | None = None,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Mapped:
    """Stiffness and deflection over two joints.

    Args:
        joints, spans, fixed: as ``grid_of`` reads them.
        wrench: N and N*m on the robot, about the TCP, axes of ``frame``: base or tool.
        tool: as in a cell; None: the TCP is the flange.
        weight: arm and tool weigh something.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    if not (np.isfinite(wrench).all() and np.any(wrench)):
        raise CompensatorError(f"--wrench {wrench}: expected six finite numbers, not all zero")
    say("reading the model")
    loaded = load_model(model)
    robot = robot_of(loaded)
    grid = grid_of(robot, joints, spans, fixed)
    held = (tool or ToolTable(xyz=(0.0, 0.0, 0.0))).tool()
    effects, left_out = loaded.applied(held.name)
    _usable(loaded, robot, effects, weight)
    say(f"{len(grid.first)} x {len(grid.second)} postures")
    result = stiffness_map(
        robot,
        effects,
        {e.name: loaded.values[e.name] for e in effects},
        tool=held,
        q=grid.q,
        wrench=np.array(wrench, dtype=float),
        gravity=np.array(STANDARD_GRAVITY) * weight,
        tool_axes=frame == "tool",
        min_singular_value=min_singular_value,
    )
    if not np.any(result.status == OK):
        raise CompensatorError(f"{model}: nothing to map: {_counted(result)}; give other --grid or --fixed angles")
    notes = _notes(loaded, robot, effects, weight=weight, tool_mass=held.mass)
    report = map_report(result, grid.joints, left_out, [str(note) for note in notes])
    report["findings"] = findings_report(of_kind("model", notes))
    refuse_warnings(report, strict)
    load = ", ".join(f"{v:g}" for v in wrench)
    title = f"{loaded.source}: {robot.name}, wrench {load} N, N·m in {frame} axes at the TCP\n{_others(grid)}"
    with Outputs() as outputs:
        if png:
            say("drawing")
            _draw(outputs, png, grid, result, title=title)
        if csv:
            outputs.text(csv, map_csv(result))
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    return Mapped(grid, result, report, tuple(f for f in (png, csv, json) if f))


def _draw(outputs: Outputs, png: Path, grid: JointGrid, result: StiffnessMap, *, title: str) -> None:
    from compensator.report.figures.stiffness_map import draw

    with outputs.writing(png) as staged:
        draw(grid, result, title, staged)
    outputs.add(staged, png)


def _others(grid: JointGrid) -> str:
    return ", ".join(f"joint {k + 1} {a:g}" for k, a in enumerate(grid.fixed) if k not in grid.joints) + " deg"


def _usable(model: ComplianceModel, robot: Robot, effects: tuple[Effect, ...], weight: bool) -> None:
    for e in effects:
        unknown = np.flatnonzero(~model.identified.get(e.name, np.ones(robot.n, dtype=bool)))
        if len(unknown):
            raise ModelError(
                f"{model.source}: {e.name} of joint {', '.join(str(k + 1) for k in unknown)} is not identified; a map "
                "would show an invented number: measure it first"
            )
    asking = [e.name for e in effects if e.needs_torque_sign]
    if weight and robot.mass is None and asking:
        raise ModelError(
            f"{model.source}: {', '.join(asking)} depends on the gravity torque of every joint, but "
            f"{robot.mass_problem}; give link masses in the robot file, or map with --no-weight"
        )


def _notes(
    model: ComplianceModel, robot: Robot, effects: tuple[Effect, ...], *, weight: bool, tool_mass: float
) -> list[Finding]:
    notes = []
    memory = [e.name for e in effects if e.memory]
    if memory:
        notes.append(f"{', '.join(memory)}: no path, no flank: joints stand mid-gap, with the mean of both sides")
    if not weight:
        notes.append("without weight: gravity takes no part")
    elif robot.mass is None:
        notes.append(f"without the weight of the arm: {robot.mass_problem}")
    elif not tool_mass:
        notes.append("the tool weighs nothing here")
    return [*assumptions(robot, model), *(Finding(NOTE, "", text) for text in notes)]


def _counted(result: StiffnessMap) -> str:
    words = {LIMIT: "beyond a joint limit", SINGULAR: "singular", NO_EQUILIBRIUM: "without equilibrium"}
    counts = {words[s]: int(np.sum(result.status == s)) for s in words}
    return f"{len(result.q)} postures, " + ", ".join(f"{n} {word}" for word, n in counts.items() if n)
