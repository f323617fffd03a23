"""Arms, springs and postures that the tests of the stiffness core share."""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect, Numbers
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]
GRAVITY = np.array([0.0, 0.0, -9.80665])
NAMES = ("abb-irb6600-175-255", "kuka-kr210-r2700", "kuka-kr240-class", "kuka-kr500", "ur10")
STIFFNESS = np.array([2.0e6, 1.774e6, 1.378e6, 2.82e5, 9.6e4, 3.74e4])
VALUES: dict[str, Numbers] = {
    "joint-stiffness": {"k_nm_per_rad": STIFFNESS},
    "preload-softening": {"ratio": np.array([0.75, 0.8, 0.9, 0.85, 0.7, 0.95])},
    "backlash": {
        "gap_rad": np.array([6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4]),
        "breakaway_nm": np.array([100.0, 300.0, 200.0, 20.0, 10.0, 5.0]),
        "side": np.ones(6),
    },
    "joint-hardening": {
        "windup_rad": np.array([5e-5, 4e-5, 6e-5, 1e-4, 2e-4, 3e-4]),
        "knee_nm": np.array([300.0, 400.0, 200.0, 100.0, 50.0, 30.0]),
        "further_rad": np.array([4e-5, 0.0, 3e-5, 5e-5, 1e-4, 2e-4]),
        "knee_ratio": np.full(6, 4.0),
        "sharpness": np.zeros(6),
    },
    "tool-compliance": {
        "linear_m_per_n": np.array([2e-7, 3e-7, 5e-8]),
        "angular_rad_per_nm": np.array([2e-6, 1e-6, 4e-6]),
        "coupling": np.array([3e-8, 0, 0, 0, 2e-7, 0, -3e-7, 0, 0, 0, 0, 0, 0, 5e-7, 0.0]),
    },
}
TOOL_ROTATION = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@cache
def robot(name: str = NAMES[0]) -> Robot:
    """A built-in robot, loaded once."""
    return load_robot(name)


def effects(*names: str) -> tuple[Effect, ...]:
    """Joint stiffness and what else is named."""
    return tuple(BY_NAME[n] for n in ("joint-stiffness", *names))


def tool(mass: float = 35.0) -> Tool:
    """A spindle that hangs off the flange axis."""
    return Tool(TOOL_ROTATION, np.array([0.05, -0.08, 0.25]), mass, np.array([0.02, -0.03, 0.12]))


def postures(arm: Robot, count: int, seed: int = 0, margin: float = 0.02) -> Floats:
    """(count, n) rad inside the limits, away from a stretched wrist and a stretched elbow."""
    rng = np.random.default_rng(seed)
    low, high = np.maximum(arm.lower + margin, -3.0), np.minimum(arm.upper - margin, 3.0)
    found: list[Floats] = []
    while len(found) < count:
        q = rng.uniform(low, high)
        if np.linalg.svd(arm.jacobian(q))[1][-1] > 0.05:
            found.append(q)
    return np.array(found)


def predictor(*names: str, arm: Robot | None = None, **kwargs: object) -> Predictor:
    """A predictor with effects of VALUES."""
    options: dict[str, object] = {"gravity": GRAVITY, **kwargs}
    values = options.pop("values", VALUES)
    return Predictor(arm or robot(), effects(*names), values, options.pop("tool", tool()), **options)  # type: ignore[arg-type]


def wrenches(count: int, force: float, seed: int = 0) -> Floats:
    """(count, 6) random directions: forces of the given size, moments of a tenth of it."""
    w = np.random.default_rng(seed).normal(size=(count, 6))
    w[:, :3] *= force / np.linalg.norm(w[:, :3], axis=1, keepdims=True)
    w[:, 3:] *= 0.1 * force / np.linalg.norm(w[:, 3:], axis=1, keepdims=True)
    return w
