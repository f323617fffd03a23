"""What a robot must not be sent: beyond a joint limit, through a singularity, with a jump."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.errors import PathError
from compensator.path.pose_text import place
from stiffness.kinematics.inverse import Inverse
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.robot.robot import Robot
from toolpaths.columns import blocks
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

ON_LIMIT = 1e-9  # rad beyond a limit that rounding explains


@dataclass(frozen=True, eq=False)
class MotionBounds:
    """Limits of a robot, and how near its singularities and how far from pose to pose it may go.

    Attributes:
        min_wrist_angle, min_elbow_angle: rad. min_shoulder: m, of the wrist centre from axis 1.
        min_singular_value: of the Jacobian, translations divided by half the reach; for arms without a spherical wrist.
        max_joint_step: rad, between two poses.
    """

    inverse: Inverse
    min_wrist_angle: float
    min_elbow_angle: float
    min_shoulder: float
    min_singular_value: float
    max_joint_step: float

    @property
    def robot(self) -> Robot:
        """Whose limits."""
        return self.inverse.robot

    @property
    def _smallest(self) -> dict[str, tuple[float, str, str]]:
        """Measure -> bound, its key in [solve], what it is."""
        return {
            "wrist": (float(np.sin(self.min_wrist_angle)), "min_wrist_angle", "sine of the wrist angle"),
            "elbow": (float(np.sin(self.min_elbow_angle)), "min_elbow_angle", "sine of the elbow angle"),
            "shoulder": (self.min_shoulder, "min_shoulder", "distance (m) of the wrist centre from axis 1"),
            "jacobian": (self.min_singular_value, "min_singular_value", "smallest singular value of the Jacobian"),
        }

    def margin(self, q: Floats) -> Floats:
        """(N,) how far each posture is from a limit or a singularity; negative beyond. Comparable, not exact."""
        room = np.minimum(q - self.robot.lower, self.robot.upper - q) / np.radians(45)
        margin = np.minimum(np.min(room, axis=1), 1.0)
        smallest = self._smallest
        for name, value in self._measures(q).items():
            bound = smallest[name][0]
            margin = np.minimum(margin, (value - bound) / (8 * bound))
        return np.asarray(margin)

    def _measures(self, q: Floats) -> dict[str, Floats]:
        """Singularity measures: those of the closed form where there is one, they cost nothing."""
        return self.inverse.singularity(q, jacobian=not isinstance(self.inverse, SphericalInverse))

    def check(self, toolpath: Toolpath, q: Floats, what: str, *, first: int = 0, begun: Sequence[int] = ()) -> None:
        """Refuse what a robot must not be sent: beyond a limit, through a singularity, with a jump.

        Args:
            first: as in ``place``.
            begun: poses that a joint move goes to: any angle may change there.

        Raises:
            PathError: the first pose, why, the value and the bound.
        """
        if not np.isfinite(q).all():
            k = int(np.argmax(~np.isfinite(q).all(axis=1)))
            raise PathError(f"{place(toolpath, k, first)}: the {what} joint angles are not finite")
        outside = (q < self.robot.lower - ON_LIMIT) | (q > self.robot.upper + ON_LIMIT)
        if outside.any():
            k = int(np.argmax(outside.any(axis=1)))
            j = int(np.argmax(outside[k]))
            raise PathError(
                f"{place(toolpath, k, first)}: {what} angle of joint {j + 1} is {np.degrees(q[k, j]):.3f} deg, limits "
                f"are {np.degrees(self.robot.lower[j]):.3f} ... {np.degrees(self.robot.upper[j]):.3f} deg; move "
                "[workobject], allow solve.free_tool_axis, or choose another [start]"
            )
        self._check_singularity(toolpath, q, what, first)
        bound, free = self.max_joint_step, np.zeros(len(q), dtype=np.bool_)
        free[list(begun)] = True
        for b in blocks(len(q)):
            before = max(b.start - 1, 0)
            step = np.abs(np.diff(q[before : b.stop], axis=0))
            step[free[before + 1 : b.stop]] = 0.0
            if (step > bound).any():
                k, j = (int(v) for v in np.unravel_index(np.argmax(step > bound), step.shape))
                raise PathError(
                    f"{place(toolpath, before + k + 1, first)}: joint {j + 1} would jump {np.degrees(step[k, j]):.1f} "
                    f"deg from the pose before ({what}; solve.max_joint_step is {np.degrees(bound):g} deg): the arm "
                    "configuration changes or a singularity is near"
                )

    def _check_singularity(self, toolpath: Toolpath, q: Floats, what: str, first: int) -> None:
        smallest = self._smallest
        for name, value in self._measures(q).items():
            bound, key, meaning = smallest[name]
            if not np.all(value >= bound):
                k = int(np.argmin(value >= bound))
                raise PathError(
                    f"{place(toolpath, k, first)}: too near the {name} singularity ({what}): {meaning} is "
                    f"{value[k]:.3g}, bound {bound:.3g} (solve.{key}); move [workobject], tilt the tool, or allow "
                    "solve.free_tool_axis"
                )
