"""Arm: a robot with the model of its stiffness, loaded once and used at any number of placements."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from compensator.cell.cell_file import Cell
from compensator.cell.controller_frames import CELL, base_findings
from compensator.cell.flange import flange_findings, with_new_numbers
from compensator.errors import CellError
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError, RobotError
from stiffness.kinematics.inverse import Inverse
from stiffness.kinematics.solver import inverse_kinematics
from stiffness.model.frames import other_frames_remedy
from stiffness.model.model import ComplianceModel, load_model, robot_of
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.robot.tips import MAKERS, FormerFlangeError
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool
from toolpaths.finding import Finding


@dataclass(frozen=True)
class Conditions:
    """Under what an arm is predicted, besides process and tool.

    Attributes:
        gravity: (3,) m/s2 in the base.
        sag: whether the controller takes the sag of arm and tool off; None: as when the model was made.
        temperature: deg C; None: the model's reference.
        complementary: False takes every load at the unloaded posture: no K_c.
    """

    gravity: tuple[float, float, float]
    sag: Literal["uncompensated", "calibrated-out"] | None = None
    temperature: float | None = None
    complementary: bool = True


@dataclass(frozen=True, repr=False, eq=False)
class Arm:
    """A robot, its inverse kinematics, and the model of its stiffness; ``findings`` of the cell that names them."""

    robot: Robot
    inverse: Inverse
    model: ComplianceModel
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        return f"Arm({self.robot.name}, {self.model.source!r})"

    def acting(
        self, tool_name: str, process: tuple[str, str] | None = None, *, walls: bool = False
    ) -> tuple[tuple[Effect, ...], tuple[str, ...]]:
        """Effects that act on a path with a tool of this name, and names of those that do not.

        Args:
            process: names of material and cutter; None: nothing is cut. walls: it tells which wall a cutter cuts.
        """
        return self.model.applied(tool_name, process, walls=walls)

    def sag(self, conditions: Conditions) -> str:
        """Whether the controller takes the sag of arm and tool off: ``uncompensated`` or ``calibrated-out``."""
        return conditions.sag or self.model.gravity

    def predictor(self, tool: Tool, conditions: Conditions) -> Predictor:
        """The statics with one tool; the same tool under the same conditions gets the same predictor."""
        com = None if tool.com is None else tool.com.tobytes()
        key = (tool.name, tool.rotation.tobytes(), tool.position.tobytes(), tool.mass, com, conditions)
        if key not in self._predictors:
            self._predictors[key] = self._new_predictor(tool, conditions)
        return self._predictors[key]

    @cached_property
    def _predictors(self) -> dict[tuple[object, ...], Predictor]:
        """What ``predictor`` gave so far: building the CasADi functions takes longer than many placements."""
        return {}

    def _new_predictor(self, tool: Tool, conditions: Conditions) -> Predictor:
        effects, _ = self.acting(tool.name)
        reference = self.model.reference_temperature
        return Predictor(
            self.robot,
            effects,
            {e.name: self.model.values[e.name] for e in effects},
            tool,
            gravity=np.array(conditions.gravity),
            calibrated_out=self.sag(conditions) == "calibrated-out",
            complementary=conditions.complementary,
            temperature=0.0 if conditions.temperature is None else conditions.temperature - reference,
        )


def load_arm(cell: Cell) -> Arm:
    """The robot that a cell names, with the model that it names.

    Raises:
        CellError, RobotError, ModelError: a file cannot be read, or the two do not belong together.
    """
    try:
        robot = load_robot(cell.robot, folder=cell.folder, base=cell.base, tip=cell.tip)
    except FormerFlangeError as e:
        raise CellError(f"{cell.source}: robot = {cell.robot!r}: {e}. {with_new_numbers(cell, e.former)}") from e
    except RobotError as e:
        raise CellError(f"{cell.source}: robot = {cell.robot!r}: {e}") from e
    try:
        model = load_model(cell.model, robot.n, folder=cell.folder)
    except ModelError as e:
        if (cell.folder / cell.model).exists():
            raise
        raise CellError(f"{cell.source}: model = {cell.model!r}: {e}") from e
    _refuse_other_robot(cell, robot, model)
    found = (*flange_findings(cell, robot), *base_findings(robot, cell.source, CELL))
    return Arm(robot, inverse_kinematics(robot), model, found)


def _refuse_other_robot(cell: Cell, robot: Robot, model: ComplianceModel) -> None:
    try:
        other = robot_of(model)
    except FormerFlangeError as e:
        raise CellError(
            f"{cell.source}: the model {cell.model} was made for an earlier version of {robot.name}: {e.former}. "
            f"Stiffness of joints holds as it is: set tip = \"{MAKERS}\" in the model. "
            f"{with_new_numbers(cell, e.former)}"
        ) from e
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
    if not robot.same_kinematics(other):
        advice = other_frames_remedy(model, other, robot)
        remedy = f": {advice}" if advice else ", or the robot file has changed since"
        raise CellError(
            f"{cell.source}: base {robot.base!r} and tip {robot.tip!r} of the cell are not the frames of the model "
            f"{cell.model} (base {other.base!r}, tip {other.tip!r}){remedy}"
        )
