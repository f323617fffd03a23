"""Choice of the inverse kinematics of a robot: in closed form if its wrist is spherical, else iterative."""

from __future__ import annotations

from stiffness.kinematics.closed_form import spherical_arm
from stiffness.kinematics.inverse import Inverse
from stiffness.kinematics.iterative import IterativeInverse
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.robot.robot import Robot


def inverse_kinematics(robot: Robot) -> Inverse:
    """Closed form for a spherical wrist, else iterative."""
    arm = spherical_arm(robot)
    if arm is None:
        return IterativeInverse(robot)
    return SphericalInverse(robot, arm)
