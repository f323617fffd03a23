"""Job: what one run works with: an arm with its tools, the placement, and the planner that both make."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compensator.cell.arm import Arm, load_arm
from compensator.cell.assumptions import assumptions
from compensator.cell.cell_file import load_cell
from compensator.cell.equipped_arm import EquippedArm, equipped
from compensator.cell.placement import Placement, placement_of
from compensator.path.motion_bounds import MotionBounds
from compensator.path.planner import Planner
from compensator.path.tcp_inverse import TcpInverse
from toolpaths.finding import NOTE, Finding


@dataclass(frozen=True, repr=False, eq=False)
class Job:
    """Everything but the toolpath.

    Attributes:
        notes: what the result does not know, for every summary.
    """

    arm: EquippedArm
    placement: Placement
    planner: Planner
    notes: tuple[Finding, ...]

    def __repr__(self) -> str:
        return f"Job({self.placement!r}, {self.arm!r})"


def load_job(path: str | Path) -> Job:
    """Load a cell and what it names, and refuse what does not belong together.

    Raises:
        CellError, RobotError, ModelError: one message each.
    """
    cell = load_cell(path)
    placement = placement_of(cell)
    return job_of(load_arm(cell), placement)


def job_of(arm: Arm, placement: Placement, notes: tuple[Finding, ...] = ()) -> Job:
    """An arm at a placement.

    Args:
        notes: what is not known besides.

    Raises:
        CellError: the two do not belong together.
    """
    tools, solve = placement.tools, placement.solve
    able = equipped(arm, tools, placement.conditions, placement.source)
    inverse = TcpInverse(arm.inverse, tools)
    bounds = MotionBounds(
        arm.inverse,
        min_wrist_angle=np.radians(solve.min_wrist_angle),
        min_elbow_angle=np.radians(solve.min_elbow_angle),
        min_shoulder=solve.min_shoulder / 1e3,
        min_singular_value=solve.min_singular_value,
        max_joint_step=np.radians(solve.max_joint_step),
    )
    planner = Planner(
        inverse,
        bounds,
        workobject=placement.workobject,
        start=placement.start,
        free_tool_axis=solve.free_tool_axis,
        source=placement.source,
    )
    return Job(able, placement, planner, (*_notes(able, placement, arm.sag(placement.conditions)), *notes))


def _notes(arm: EquippedArm, placement: Placement, sag: str) -> list[Finding]:
    model = arm.model
    notes = assumptions(arm.robot, model)
    if not any(model.sd.get(e.name) for e in arm.effects):
        what = "no standard deviations: how sure the prediction is cannot be said"
        notes.append(Finding(NOTE, model.source, what))
    weightless = [t.name for t in placement.tools.by_number.values() if not t.mass]
    if weightless:
        what = "no mass given, its weight is not modelled"
        notes.append(Finding(NOTE, f"tool {', '.join(weightless)}", what))
    temperature = placement.conditions.temperature
    warm = temperature is not None and temperature != model.reference_temperature
    if warm and not any(e.thermal for e in arm.effects):
        what = "temperature differs from the model's reference; the model has no thermal effect"
        notes.append(Finding(NOTE, "", what))
    if sag == "calibrated-out":
        notes.append(Finding(NOTE, "gravity", "the controller is taken to know the sag of arm and tool"))
    return notes
