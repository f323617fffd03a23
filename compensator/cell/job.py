"""Job: what one run works with: an arm with its tools, the placement, and the planner that both make."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from compensator.cell.arm import Arm, load_arm
from compensator.cell.assumptions import job_findings
from compensator.cell.cell_file import load_cell
from compensator.cell.equipped_arm import EquippedArm, equipped
from compensator.cell.placement import Placement, placement_of
from compensator.path.motion_bounds import MotionBounds
from compensator.path.planner import Planner
from compensator.path.tcp_inverse import TcpInverse
from compensator.process.acting_process import ActingProcess
from toolpaths.finding import Finding


@dataclass(frozen=True, repr=False, eq=False)
class Job:
    """Everything but the toolpath.

    Attributes:
        findings: about cell, robot and model.
    """

    arm: EquippedArm
    placement: Placement
    planner: Planner
    findings: tuple[Finding, ...]

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


def job_of(arm: Arm, placement: Placement, findings: tuple[Finding, ...] = ()) -> Job:
    """An arm at a placement.

    Args:
        findings: further ones.

    Raises:
        CellError: the two do not belong together.
    """
    tools, solve = placement.tools, placement.solve
    able = equipped(
        arm,
        tools,
        placement.conditions,
        source=placement.source,
        process=placement.process_names,
        walls=placement.process.tells_walls,
    )
    changed = [e for e in able.effects if e.process_wrench]
    if changed:
        placement = replace(placement, process=ActingProcess(placement.process, changed, able.values))
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
        one_turn=solve.turn == "constant",
        source=placement.source,
    )
    found = job_findings(able, placement, arm.sag(placement.conditions))
    return Job(able, placement, planner, (*arm.findings, *found, *findings))
