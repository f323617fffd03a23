"""What goes wrong with robots, models and measurements."""

from __future__ import annotations


class StiffnessError(Exception):
    """A robot, model or session is refused. The message names file, place, value and remedy."""


class RobotError(StiffnessError):
    """A robot description cannot be used."""


class ModelError(StiffnessError):
    """A model file is refused or does not belong to the robot."""


class EquilibriumError(StiffnessError):
    """No static equilibrium: the load is too large for the stiffness.

    Args:
        row: of the arrays that were asked about.
        problem: what is wrong there.
    """

    def __init__(self, row: int, problem: str) -> None:
        self.row, self.problem = row, problem
        super().__init__(f"pose {row}: {problem}")
