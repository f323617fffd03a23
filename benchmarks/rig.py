"""Arms, models and paths that the benchmarks run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from benchmarks.naive import NaiveArm
from stiffness.effects import BY_NAME
from stiffness.kinematics.inverse import Inverse
from stiffness.kinematics.solver import inverse_kinematics
from stiffness.poses import PoseArray, Poses
from stiffness.robot.load import load_robot
from stiffness.robot.robot import STANDARD_GRAVITY, Robot, placement
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

GRAVITY = np.array(STANDARD_GRAVITY)
TOOL = Tool(np.eye(3), np.array([0.02, -0.01, 0.25]), 35.0, np.array([0.0, 0.01, 0.12]))
LIGHT = Tool(np.eye(3), np.array([0.01, 0.0, 0.12]), 2.0, np.array([0.0, 0.0, 0.05]))
WRENCH = np.array([-320.0, 210.0, -260.0, 8.0, -5.0, 3.0])
ABB_STIFFNESS = {"joint-stiffness": {"k_nm_per_rad": np.array([2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4])}}
UR_STIFFNESS = {"joint-stiffness": {"k_nm_per_rad": np.array([8e4, 8e4, 4e4, 1.5e4, 1.5e4, 1.5e4])}}
RICHER = {
    "joint-hardening": {
        "windup_rad": np.full(6, 5e-5),
        "knee_nm": np.array([400.0, 400, 300, 100, 60, 40]),
        "further_rad": np.zeros(6),
        "knee_ratio": np.full(6, 4.0),
        "sharpness": np.zeros(6),
    },
    "tool-compliance": {
        "linear_m_per_n": np.array([2.0e-8, 2.5e-8, 8e-9]),
        "angular_rad_per_nm": np.array([3.0e-7, 2.0e-7, 4.0e-7]),
        "coupling": np.zeros(15),
    },
}
# centre and size (m) of the volume that a path winds through
_PLACES = {"ur10": ((0.65, -0.2, 0.25), (0.12, 0.18, 0.08))}
_PLACE = ((1.75, -0.1, 0.95), (0.25, 0.35, 0.15))


@dataclass(frozen=True)
class Rig:
    """One arm with a model.

    Attributes:
        robot, tool, values: as Predictor takes them; invented masses where the robot file has none.
        calibrated_out: the controller takes the sag off.
    """

    robot: Robot
    tool: Tool
    values: Mapping[str, Mapping[str, Floats]]
    calibrated_out: bool = False

    @cached_property
    def predictor(self) -> Predictor:
        """The product."""
        effects = [BY_NAME[name] for name in self.values]
        return Predictor(
            self.robot, effects, self.values, self.tool, gravity=GRAVITY, calibrated_out=self.calibrated_out
        )

    @cached_property
    def naive(self) -> NaiveArm:
        """The loop."""
        return NaiveArm(self.robot, self.values, self.tool, gravity=GRAVITY, calibrated_out=self.calibrated_out)

    @cached_property
    def inverse(self) -> Inverse:
        """Nominal inverse kinematics."""
        return inverse_kinematics(self.robot)


@dataclass(frozen=True)
class Task:
    """Poses of the TCP in the base with the wrench there: ``rotation`` (N, 3, 3), ``position`` (N, 3), ``wrench``
    (N, 6); ``start`` (N, n) rad is nominal inverse kinematics and ``branch`` its configuration."""

    rotation: Floats
    position: Floats
    wrench: Floats
    start: Floats
    branch: int

    def __len__(self) -> int:
        return len(self.position)

    @property
    def tcp(self) -> PoseArray:
        """The poses."""
        return PoseArray(self.rotation, self.position)

    def first(self, count: int) -> Task:
        """The first poses of the path."""
        some = slice(count)
        return replace(
            self, rotation=self.rotation[some], position=self.position[some], wrench=self.wrench[some],
            start=self.start[some],
        )  # fmt: skip


def rig(name: str, *, richer: bool = False, calibrated_out: bool = False) -> Rig:
    """A built-in robot with joint springs, and hardening and a spring at the flange if ``richer``."""
    robot = load_robot(name)
    if robot.mass is None:
        raise ValueError(f"{name}: no masses, no gravity to bench")
    base = UR_STIFFNESS if name == "ur10" else ABB_STIFFNESS
    return Rig(robot, LIGHT if name == "ur10" else TOOL, {**base, **(RICHER if richer else {})}, calibrated_out)


def winding(name: str, count: int) -> tuple[Floats, Floats]:
    """A five-axis path: TCP rotation (N, 3, 3) and position (N, 3), neighbours about 0.5 mm apart."""
    centre, size = (np.array(v) for v in _PLACES.get(name, _PLACE))
    t = np.arange(count) * 1e-3
    position = centre + size * np.stack([np.sin(t), np.cos(0.61 * t), np.sin(0.37 * t + 1)], axis=1)
    tilt, way = 0.25 * np.sin(0.43 * t), 0.2 * np.cos(0.29 * t)
    zero, one = np.zeros(count), np.ones(count)
    down = np.diag([1.0, -1.0, -1.0])
    about_x = np.stack([one, zero, zero, zero, np.cos(tilt), -np.sin(tilt), zero, np.sin(tilt), np.cos(tilt)], 1)
    about_y = np.stack([np.cos(way), zero, np.sin(way), zero, one, zero, -np.sin(way), zero, np.cos(way)], 1)
    return about_y.reshape(-1, 3, 3) @ about_x.reshape(-1, 3, 3) @ down, position


def task(rig: Rig, count: int) -> Task:
    """A winding path with its nominal inverse kinematics, in the first configuration that follows it all."""
    rotation, position = winding(rig.robot.name, count)
    under = flange(rig, PoseArray(rotation, position))
    pose = placement(under.rotation[0], under.origin[0])
    wave = np.sin(np.arange(count) * 0.011)[:, None]
    wrench = (0.25 if rig.tool is LIGHT else 1.0) * WRENCH * (1 + 0.3 * wave)
    for branch, q in rig.inverse.all(pose):
        batch = rig.inverse.along(under, branch, q)
        if batch.ok.all() and batch.limit_margin.min() > 0:
            return Task(rotation, position, wrench, batch.q, branch)
    raise ValueError(f"{rig.robot.name}: no configuration follows the bench path")


def flange(rig: Rig, tcp: Poses) -> PoseArray:
    """Flange poses under TCP poses."""
    r = tcp.rotation @ rig.tool.rotation.T
    return PoseArray(r, tcp.origin - r @ rig.tool.position)
