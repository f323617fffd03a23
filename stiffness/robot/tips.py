"""Tips: frames on the flange of a robot that poses may lead to, and the flange that it had in earlier versions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError

Floats = npt.NDArray[np.float64]

FLANGE = "flange"
MAKERS = "tool0"  # what ROS calls a maker's flange frame: every robot file may be asked for it


@dataclass(frozen=True, eq=False)
class FormerFlange:
    """The flange that a built-in robot had in earlier versions, under the name ``tip``.

    Attributes:
        shift: (3,) m, where it stood in the flange of today.
        was, now: both in words.
    """

    tip: str
    shift: Floats
    was: str
    now: str

    def __str__(self) -> str:
        return f"the flange is {self.now}; in earlier versions it was {self.was}"


class FormerFlangeError(RobotError):
    """A robot is asked for with the flange of an earlier version."""

    def __init__(self, robot: str, former: FormerFlange) -> None:
        self.former = former
        shift = ", ".join(f"{v * 1e3:g}" for v in former.shift)
        super().__init__(
            f"robot {robot}: tip = {former.tip!r}: {former}. Add [{shift}] mm to every position that was measured from "
            f"there (tool, centre of mass, reflectors on the flange), and set tip = \"{MAKERS}\""
        )


@dataclass(frozen=True, eq=False)
class Tip:
    """A frame on the flange: its ``placement`` (4, 4) there, and ``why`` no controller has it as its flange."""

    name: str
    placement: Floats
    why: str = ""


def chosen_tip(
    asked: str | None, *, robot: str, flange: str, tips: Mapping[str, Tip], former: FormerFlange | None
) -> Tip:
    """The tip that is asked for; None or ``tool0``: the flange.

    Raises:
        FormerFlangeError, RobotError: it is that of an earlier version; there is none of this name.
    """
    if asked in (None, flange, MAKERS):
        return Tip(flange, np.eye(4))
    if former is not None and asked == former.tip:
        raise FormerFlangeError(robot, former)
    if asked not in tips:
        known = ", ".join((flange, *tips))
        raise RobotError(f"robot {robot} has no tip {asked!r}; it has {known}: only a URDF has links to choose from")
    return tips[asked]
