"""Static equilibrium by virtual work: numpy and scipy only, no formula shared with the package.

Poses come from products of homogeneous matrices, generalised forces from differences of poses, the
equilibrium from a root search. Slow, and exact to about 1e-12.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from stiffness.robot.robot import Robot

Floats = npt.NDArray[np.float64]
STEP = 1e-3
STENCIL = ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12))  # central difference of fourth order


@dataclass(frozen=True)
class Push:
    """A wrench (6,) in base axes on a point (3,) of a link."""

    link: int
    point: Floats
    wrench: Floats


@dataclass(frozen=True)
class ElasticArm:
    """An arm with joint laws, rigid displacements of places, weights and pushes.

    Attributes:
        law: (torque (n,), angle (n,)) -> dq (n,).
        compliance: place -> (6, 6).
        masses: (link, kg, com (3,)) beyond those of the robot.
        spring: (n,) angles of the links -> (n,) torque of internal springs.
    """

    robot: Robot
    law: Callable[[Floats, Floats], Floats]
    compliance: dict[int, Floats] = field(default_factory=dict)
    masses: tuple[tuple[int, float, Floats], ...] = ()
    gravity: Floats = field(default_factory=lambda: np.array([0.0, 0.0, -9.80665]))
    spring: Callable[[Floats], Floats] | None = None

    def links(self, q: Floats, x: Floats) -> list[Floats]:
        """(4, 4) of links 0 ... n, with coordinates x = (dq, displacements in the order of places)."""
        n = self.robot.n
        displacements = {k: x[n + 6 * i : n + 6 * i + 6] for i, k in enumerate(sorted(self.compliance))}
        frame = small_motion(displacements.get(0))
        out = [frame]
        for k in range(n):
            turn = np.eye(4)
            turn[:3, :3] = Rotation.from_rotvec(self.robot.axis[k] * (q[k] + x[k])).as_matrix()
            frame = frame @ self.robot.before[k] @ turn @ self.robot.after[k] @ small_motion(displacements.get(k + 1))
            out.append(frame)
        return out

    def generalised(self, q: Floats, x: Floats, pushes: list[Push]) -> Floats:
        """Work of all loads per change of every coordinate."""
        every = pushes + [Push(k, c, np.r_[m * self.gravity, 0, 0, 0]) for k, m, c in self._all_masses()]
        at = self.links(q, x)
        total = np.zeros(len(x))
        for i in range(len(x)):
            along = np.eye(len(x))[i] * STEP
            slope = sum(weight / STEP * np.array(self.links(q, x + k * along)) for k, weight in STENCIL)
            for p in every:
                velocity = (slope[p.link] @ np.r_[p.point, 1.0])[:3]
                spin = slope[p.link][:3, :3] @ at[p.link][:3, :3].T
                omega = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
                total[i] += p.wrench[:3] @ velocity + p.wrench[3:] @ omega
        return total

    def solve(self, q: Floats, pushes: list[Push]) -> tuple[Floats, Floats]:
        """Elastic coordinates at equilibrium, and the generalised forces there."""
        n = self.robot.n

        def caused(x: Floats) -> Floats:
            force = self.generalised(q, x, pushes)
            torque = force[:n] + (self.spring(q + x[:n]) if self.spring else 0.0)
            parts = [self.law(torque, q)]
            for i, k in enumerate(sorted(self.compliance)):
                parts.append(self.compliance[k] @ force[n + 6 * i : n + 6 * i + 6])
            return np.concatenate(parts)

        size = n + 6 * len(self.compliance)
        found = root(lambda y: y - 1e4 * caused(y / 1e4), np.zeros(size), method="hybr", options={"xtol": 1e-14})
        x = found.x / 1e4
        for _ in range(4):  # the last digits: what the search leaves, the law contracts
            x = caused(x)
        miss = float(np.abs(x - caused(x)).max())
        if not miss < 1e-12:
            raise RuntimeError(f"the oracle found no equilibrium: {miss:.1e}")
        return x, self.generalised(q, x, pushes)

    def _all_masses(self) -> list[tuple[int, float, Floats]]:
        own: list[tuple[int, float, Floats]] = []
        if self.robot.mass is not None and self.robot.com is not None:
            own = [(k + 1, float(m), c) for k, (m, c) in enumerate(zip(self.robot.mass, self.robot.com, strict=True))]
        return own + list(self.masses)


def small_motion(displacement: Floats | None) -> Floats:
    """(4, 4) of a translation followed, outward of it, by a rotation vector."""
    out = np.eye(4)
    if displacement is not None:
        out[:3, :3] = Rotation.from_rotvec(displacement[3:]).as_matrix()
        out[:3, 3] = displacement[:3]
    return out
