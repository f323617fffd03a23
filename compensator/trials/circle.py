"""A ball-bar circle: centre, plane, tilt of the tool, arc; and its poses in both directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from toolpaths.rotation import quaternion_from_matrix

Floats = npt.NDArray[np.float64]

#: Planes by name: the two axes of the work object that span them, angle 0 along the first.
PLANES = {"XY": (0, 1), "XZ": (0, 2), "YZ": (1, 2)}
TOOL_DOWN = np.diag([1.0, -1.0, -1.0])  # TCP z into the table, TCP x along x


@dataclass(frozen=True)
class CircleShape:
    """A circle, or the upper arc of a standing one: below it is the cup of the ball-bar.

    Attributes:
        plane: one of PLANES. tilt: rad of the tool about x and y of the work object. turn: rad about the tool axis.
    """

    plane: str
    tilt: tuple[float, float] = (0.0, 0.0)
    turn: float = 0.0

    @property
    def standing(self) -> bool:
        """Whether only an arc of it can be run."""
        return self.plane != "XY"

    @property
    def arc(self) -> tuple[float, float]:
        """rad, where data begin and end."""
        return (np.radians(-20.0), np.radians(200.0)) if self.standing else (0.0, 2 * np.pi)

    @property
    def overshoot(self) -> float:
        """rad before and after the data: the joints are on their way when these begin."""
        return float(np.radians(2.0 if self.standing else 45.0))

    def angles(self, step: float) -> Floats:
        """(N,) rad with run-in and overshoot, one way."""
        begin, end = self.arc[0] - self.overshoot, self.arc[1] + self.overshoot
        return np.linspace(begin, end, round((end - begin) / step) + 1)

    def outward(self, angle: Floats) -> Floats:
        """(N, 3) unit, from the centre to the TCP, axes of the work object."""
        out = np.zeros((len(angle), 3))
        first, second = PLANES[self.plane]
        out[:, first], out[:, second] = np.cos(angle), np.sin(angle)
        return out

    @property
    def quaternion(self) -> Floats:
        """(4,) of the TCP in the work object."""
        tilted = Rotation.from_rotvec([self.tilt[0], self.tilt[1], 0.0]).as_matrix()
        turned = Rotation.from_rotvec([0.0, 0.0, self.turn]).as_matrix()
        return np.asarray(quaternion_from_matrix((tilted @ TOOL_DOWN @ turned)[None])[0])

    @property
    def words(self) -> str:
        """For people."""
        leaned = [f"{np.degrees(t):g} deg about {axis}" for t, axis in zip(self.tilt, "xy", strict=True) if t]
        return f"{self.plane}" + (f", tool leaned {' and '.join(leaned)}" if leaned else "")
