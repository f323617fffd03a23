"""What of a model holds for another tip of its arm, and what to do with the rest."""

from __future__ import annotations

from dataclasses import replace

from stiffness.model.model import ComplianceModel
from stiffness.robot.robot import Robot


def other_tip_remedy(model: ComplianceModel, other: Robot, robot: Robot) -> str:
    """What to do with a model whose tip is not that of the robot; empty where base or arm differ as well.

    Args:
        other: the robot of the model. robot: that it is wanted for.
    """
    if other.tip == robot.tip or other.name != robot.name or not _same_joints(other, robot):
        return ""
    frame = robot.flange_frame
    if frame is not None and frame.name == other.tip:
        return (
            f'Are tools and positions measured from {frame.name}, as controllers do, write tip = "{frame.name}" here; '
            f"if they are from {robot.tip}: {_remedy(model, other, robot)}"
        )
    return _remedy(model, other, robot)


def _remedy(model: ComplianceModel, other: Robot, robot: Robot) -> str:
    bound = [
        e.name for e in model.effects if e.scope == "tool" or (e.place is not None and robot.n in e.places(robot.n))
    ]
    if not bound:
        return f'its numbers are those of joints and hold for any tip of the arm: set tip = "{robot.tip}" in the model'
    some = "is" if len(bound) == 1 else "are"
    return (
        f"its {', '.join(bound)} {some} in the axes of its own tip: identify it again from "
        f'sessions with tip = "{robot.tip}", or measure the tools from {other.tip!r} and set tip = "{other.tip}" here'
    )


def _same_joints(one: Robot, other: Robot) -> bool:
    """Whether both are one arm but for what comes after its last joint."""
    return one.same_kinematics(_with_end_of(other, one))


def _with_end_of(robot: Robot, other: Robot) -> Robot:
    if robot.after.shape != other.after.shape:
        return robot
    after = robot.after.copy()
    after[-1] = other.after[-1]
    return replace(robot, after=after)
