"""Inverse kinematics of the TCP, with the tool that each pose calls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.tool_set import ToolSet
from stiffness.kinematics.inverse import Inverse, InverseSolution
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class TcpInverse:
    """An arm's inverse kinematics under a set of tools."""

    inverse: Inverse
    tools: ToolSet

    @property
    def robot(self) -> Robot:
        """The arm."""
        return self.inverse.robot

    @property
    def labelled(self) -> bool:
        """Whether a branch is the same arm configuration at every pose; the others are counted pose by pose."""
        return isinstance(self.inverse, SphericalInverse)

    def along(self, toolpath: Toolpath, tcp: Frame, branch: int | Ints, seed: Floats | None) -> InverseSolution:
        """Joint angles of the poses of a toolpath.

        Args:
            tcp: (N) in the base.
            branch, seed: as in ``Inverse.along``.
        """
        return self.inverse.along(self.tools.flange(toolpath, tcp), branch, seed)

    def reached(self, toolpath: Toolpath, tcp: Frame, *, thorough: bool) -> Bools:
        """(N,) whether the arm takes up the poses of a toolpath at all; as ``Inverse.reached``."""
        return self.inverse.reached(self.tools.flange(toolpath, tcp), thorough=thorough)

    def postures(self, pose: Toolpath, tcp: Frame, *, limits: bool) -> list[tuple[int, Floats]]:
        """Every posture (branch, joint angles (n,) rad) of a toolpath of one pose, its ``tcp`` (1) in the base.

        Args:
            limits: as in ``Inverse.all``.
        """
        return self.inverse.all(self.tools.flange(pose, tcp).take(0).matrix, limits=limits)
