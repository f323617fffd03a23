"""The robot that sessions and models name: the path from a new file to it, and whether two files mean the same arm."""

from __future__ import annotations

import os
from pathlib import Path

from stiffness.errors import RobotError, StiffnessError
from stiffness.model.frames import other_frames_remedy
from stiffness.model.model import ComplianceModel, robot_of
from stiffness.robot.load import builtin_robots
from stiffness.session.session import Session


def robot_beside(folder: Path, robot: str, output: Path) -> str:
    """A robot as the file ``output`` has to name it, so that it is what ``robot`` is in files of ``folder``: a path is
    relative to the file that it stands in."""
    beside = folder / robot
    if robot in builtin_robots() or not beside.exists():
        return robot
    return Path(os.path.relpath(beside.resolve(), output.resolve().parent)).as_posix()


def refuse_other_robot(session: Session, model: ComplianceModel) -> None:
    """Refuse a session of another robot, or of other frames of it, than the model is for.

    Raises:
        StiffnessError: names both files and what differs.
    """
    try:
        other = robot_of(model)
    except RobotError as e:
        raise StiffnessError(
            f"{session.source}: the model {model.source} is for robot {model.robot!r}, which cannot be loaded to "
            f"compare it with {session.robot_name!r}: {e}"
        ) from e
    own = session.robot
    if other.name != own.name and session.robot_name != model.robot:
        raise StiffnessError(
            f"{session.source}: robot {session.robot_name!r} is not the robot {model.robot!r} of the model "
            f"{model.source}: a stiffness model holds for the robot it was identified on"
        )
    if not own.same_kinematics(other):
        advice = other_frames_remedy(model, other, own)
        remedy = f": {advice}" if advice else ", or the robot file has changed since"
        raise StiffnessError(
            f"{session.source}: base {own.base!r} and tip {own.tip!r} of the session are not the frames of the model "
            f"{model.source} (base {other.base!r}, tip {other.tip!r}){remedy}"
        )
