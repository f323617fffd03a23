"""Joint angles as functions of the turn about the tool axis, and their derivatives: the closed form in CasADi."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.path.planned_path import PlannedPath
from compensator.path.tcp_inverse import TcpInverse
from compensator.turn.turn_grid import reference_of
from stiffness.kinematics.spherical import SphericalInverse
from stiffness.numerics.kernel import Kernel
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Numbers = npt.NDArray[Any]


@dataclass(frozen=True, repr=False, eq=False)
class TurnKinematics:
    """K poses of a path whose turn is open.

    Attributes:
        rows: (K,) poses of the path.
        reference: (K) TCP in the base before it is turned.
        signs: (K, 3) of the arm configuration.
        tool: (K,) which kernel.
    """

    rows: Rows
    reference: Frame
    signs: Floats
    tool: Rows
    kernels: tuple[Kernel, ...]

    @classmethod
    def of(cls, inverse: TcpInverse, path: PlannedPath, rows: Rows) -> TurnKinematics:
        """Of an arm with a closed form."""
        tool, kernels = kernels_by_tool(inverse, path.toolpath.tool[rows], _turned)
        signs = configuration_signs(path.branch[rows])
        return cls(rows=rows, reference=reference_of(path, rows), signs=signs, tool=tool, kernels=kernels)

    def angles(self, turn: Floats, some: slice = slice(None)) -> tuple[Floats, Floats]:
        """(K, n) rad, without regard to full turns, and (K, n) their derivatives by the turn (K,) rad."""
        rotation, origin = self.reference.rotation[some].reshape(-1, 9), self.reference.origin[some]
        tool, signs = self.tool[some], self.signs[some]
        q, slope = np.empty((len(turn), 6)), np.empty((len(turn), 6))
        for k, kernel in enumerate(self.kernels):
            at = np.flatnonzero(tool == k)
            if len(at):
                q[at], slope[at] = kernel.run(rotation[at], origin[at], turn[at, None], signs[at])
        return q, slope


def kernels_by_tool(
    inverse: TcpInverse, tools: Numbers, made: Callable[[ca.Function, Tool], ca.Function]
) -> tuple[Rows, tuple[Kernel, ...]]:
    """Which kernel each of the poses with ``tools`` (K,) takes, and the kernels, ``made`` of the closed form.

    Raises:
        TypeError: the arm has no closed form.
    """
    if not isinstance(inverse.inverse, SphericalInverse):
        raise TypeError(f"{inverse.robot.name} has no closed form")
    numbers = list(inverse.tools.by_number)
    own = np.zeros(len(tools), dtype=np.intp)
    for k, number in enumerate(numbers if len(numbers) > 1 else ()):
        own[tools == number] = k
    return own, tuple(Kernel(made(inverse.inverse.function, inverse.tools.by_number[k])) for k in numbers)


def configuration_signs(branch: Numbers) -> Floats:
    """(K, 3) of arm configurations (K,), as the closed form takes them."""
    return np.asarray(1.0 - 2.0 * ((branch[:, None] >> np.array([2, 1, 0])) & 1))


def moves(q: Floats) -> Floats:
    """(K - 1, n) rad from each posture to the next, the short way round."""
    return np.asarray((np.diff(q, axis=0) + np.pi) % (2 * np.pi) - np.pi)


def _turned(inverse: ca.Function, tool: Tool) -> ca.Function:
    """(R (9) row-major, p (3), turn (1), signs (3)) of the TCP -> q (n), dq/dturn (n)."""
    flat, p, turn, branch = (ca.SX.sym(name, size) for name, size in (("R", 9), ("p", 3), ("turn", 1), ("s", 3)))
    c, s = ca.cos(turn), ca.sin(turn)
    about = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
    flange = ca.mtimes([ca.reshape(flat, 3, 3).T, about, ca.DM(np.asarray(tool.rotation.T))])
    origin = p - ca.mtimes(flange, ca.DM(np.asarray(tool.position)))
    q = inverse(ca.vec(flange.T), origin, branch)[0]
    outputs = [ca.densify(q), ca.densify(ca.jacobian(q, turn))]
    return ca.Function("turned", [flat, p, turn, branch], outputs)
