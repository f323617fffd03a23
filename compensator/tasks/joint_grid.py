"""The grid of a stiffness map from the words of the command line, in deg."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.errors import CompensatorError
from stiffness.robot.robot import Robot
from stiffness.statics.joint_grid import JointGrid

Floats = npt.NDArray[np.float64]

_STEP = 5.0  # deg
_MOST = 250_000
_WRIST = 45.0  # deg: joints 4 to 6 where none is given, away from a stretched wrist, as in the paper


def grid_of(robot: Robot, joints: str, spans: str | None, fixed: str | None) -> JointGrid:
    """A grid on a robot.

    Args:
        joints: ``2,3``: two joints counted from 1.
        spans: ``LOW:HIGH:STEP,LOW:HIGH:STEP`` in deg; None: all between the limits, every 5 deg.
        fixed: ``1=0,4=45``: angles of other joints in deg; 0 for joints 1 to 3 and 45 for the others where not given.

    Raises:
        CompensatorError: names the option, its value and what was expected.
    """
    i, j = _pair(robot, joints)
    first, second = _axes(robot, (i, j), spans)
    count = len(first) * len(second)
    if count > _MOST:
        raise CompensatorError(f"--grid: {count} postures are more than {_MOST}: take larger steps")
    return JointGrid((i, j), first, second, _fixed(robot, (i, j), fixed))


def _pair(robot: Robot, text: str) -> tuple[int, int]:
    words = [w.strip() for w in text.split(",")]
    numbers = [int(w) - 1 for w in words if w.isdecimal()]
    if len(words) != 2 or len(numbers) != 2 or numbers[0] == numbers[1] or not all(0 <= k < robot.n for k in numbers):
        raise CompensatorError(f"--robot-joints {text!r}: expected two joints out of 1 ... {robot.n}, such as 2,3")
    return numbers[0], numbers[1]


def _axes(robot: Robot, joints: tuple[int, int], spans: str | None) -> list[Floats]:
    if spans is None:
        return [_axis(*_limits(robot, k), _STEP) for k in joints]
    words = spans.split(",")
    if len(words) != 2:
        raise CompensatorError(
            f"--grid {spans!r}: expected two ranges LOW:HIGH:STEP in deg, such as -65:75:5,-180:60:5"
        )
    axes = []
    for word, k in zip(words, joints, strict=True):
        numbers = [_number("--grid", w) for w in word.split(":")]
        if len(numbers) != 3 or not (numbers[0] < numbers[1] and 0 < numbers[2] <= numbers[1] - numbers[0]):
            raise CompensatorError(
                f"--grid {word!r} for joint {k + 1}: expected LOW:HIGH:STEP in deg with LOW < HIGH and a positive STEP "
                "that fits in between"
            )
        if (numbers[1] - numbers[0]) / numbers[2] > _MOST:
            raise CompensatorError(f"--grid {word!r} for joint {k + 1}: more than {_MOST} steps: take larger ones")
        axes.append(_axis(*numbers))
    return axes


def _limits(robot: Robot, k: int) -> tuple[float, float]:
    """deg, one turn at most, in whole steps."""
    low, high = np.degrees([robot.lower[k], robot.upper[k]])
    low, high = max(low, -180.0), min(high, 180.0)
    return float(np.ceil(low / _STEP - 1e-9) * _STEP), float(np.floor(high / _STEP + 1e-9) * _STEP)


def _axis(low: float, high: float, step: float) -> Floats:
    return np.asarray(low + step * np.arange(int(np.floor((high - low) / step + 1e-9)) + 1), dtype=float)


def _fixed(robot: Robot, joints: tuple[int, int], text: str | None) -> Floats:
    angles = np.where(np.arange(robot.n) < 3, 0.0, _WRIST)
    given: set[int] = set()
    for word in text.split(",") if text else []:
        name, equals, value = (w.strip() for w in word.partition("="))
        k = int(name) - 1 if name.isdecimal() else -1
        if not equals or not 0 <= k < robot.n:
            raise CompensatorError(
                f"--fixed {word!r}: expected JOINT=ANGLE in deg, such as 4=45, with a joint of 1 ... {robot.n}"
            )
        if k in joints or k in given:
            why = "varies over the grid" if k in joints else "stands there twice"
            raise CompensatorError(f"--fixed {word!r}: joint {k + 1} {why}; take it out")
        angles[k] = _number("--fixed", value)
        given.add(k)
    for k in sorted(set(range(robot.n)) - set(joints)):
        low, high = np.degrees([robot.lower[k], robot.upper[k]])
        if not low - 1e-9 <= angles[k] <= high + 1e-9:
            raise CompensatorError(
                f"--fixed: joint {k + 1} at {angles[k]:g} deg is outside its limits {low:g} ... {high:g} deg of "
                f"{robot.name}; give another angle"
            )
    return np.asarray(angles, dtype=float)


def _number(option: str, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or "_" in word:
        raise CompensatorError(f"{option}: {word.strip()!r} is not a number")
    return value
