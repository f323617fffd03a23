"""What of a model holds for another base or tip of its arm, and what to do with the rest."""

from __future__ import annotations

from dataclasses import replace

from stiffness.model.model import ComplianceModel
from stiffness.robot.robot import Robot


def other_frames_remedy(model: ComplianceModel, other: Robot, robot: Robot) -> str:
    """What to do with a model whose base or tip is not that of the robot; empty where the arm differs as well.

    Args:
        other: the robot of the model. robot: that it is wanted for.
    """
    differ = [key for key in ("base", "tip") if getattr(other, key) != getattr(robot, key)]
    if not differ or other.name != robot.name or not _same_joints(other, robot, differ):
        return ""
    frames = {"base": robot.base_frame, "tip": robot.flange_frame}
    makers = [key for key in differ if (frame := frames[key]) is not None and frame.name == getattr(other, key)]
    if makers != differ:
        return _remedy(model, other, robot, differ=differ)
    measured = {"base": "positions", "tip": "tools and what sits on them"}
    asked = " and ".join(f"{measured[key]} measured from {getattr(other, key)}" for key in differ)
    return (
        f"Are {asked}, as controllers do, write {_set(other, differ)} here; "
        f"if they are from {' and '.join(getattr(robot, key) for key in differ)}: "
        f"{_remedy(model, other, robot, differ=differ)}"
    )


def _remedy(model: ComplianceModel, other: Robot, robot: Robot, *, differ: list[str]) -> str:
    places = {"base": 0, "tip": robot.n}
    bound = [
        e.name
        for e in model.effects
        if (e.scope == "tool" and "tip" in differ)
        or (e.place is not None and any(places[key] in e.places(robot.n) for key in differ))
    ]
    words = " and ".join(differ)
    if not bound:
        return (
            f"its numbers are those of joints and hold for any {words} of the arm: "
            f"set {_set(robot, differ)} in the model"
        )
    some = "is" if len(bound) == 1 else "are"
    named = " and ".join(repr(getattr(other, key)) for key in differ)
    return (
        f"its {', '.join(bound)} {some} in the axes of its own {words}: identify it again from sessions with "
        f"{_set(robot, differ)}, or measure from {named} and set {_set(other, differ)} here"
    )


def _set(robot: Robot, keys: list[str]) -> str:
    return " and ".join(f'{key} = "{getattr(robot, key)}"' for key in keys)


def _same_joints(one: Robot, other: Robot, differ: list[str]) -> bool:
    """Whether both are one arm but for what comes before its first joint, or after its last, or both."""
    if one.before.shape != other.before.shape or one.after.shape != other.after.shape:
        return False
    before, after = other.before.copy(), other.after.copy()
    if "base" in differ:
        before[0] = one.before[0]
    if "tip" in differ:
        after[-1] = one.after[-1]
    return one.same_kinematics(replace(other, before=before, after=after))
