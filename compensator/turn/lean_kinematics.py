"""Joint angles as functions of turn and lean of the tool axis, and their derivatives: the closed form in CasADi."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.path.tcp_inverse import TcpInverse
from compensator.turn.turn_kinematics import configuration_signs, kernels_by_tool
from stiffness.numerics.kernel import Kernel
from stiffness.statics.tool import Tool
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Rows = npt.NDArray[np.intp]
Some = slice | Rows


@dataclass(frozen=True, repr=False, eq=False)
class LeanKinematics:
    """K poses whose turn and lean are open: states (K, 3) rad are turn and lean.

    Attributes:
        reference: (K) TCP in the base at a state of zeros.
        radius: (K,) m of the ball whose centre stays.
        signs: (K, 3) of the arm configuration.
        tool: (K,) which kernel.
    """

    reference: Frame
    radius: Floats
    signs: Floats
    tool: Rows
    kernels: tuple[Kernel, ...]

    @classmethod
    def of(
        cls, inverse: TcpInverse, toolpath: Toolpath, reference: Frame, *, radius: Floats, branch: Ints
    ) -> LeanKinematics:
        """Of the poses of ``toolpath`` (K), in arm configurations (K,)."""
        tool, kernels = kernels_by_tool(inverse, toolpath.tool, _leaned)
        signs = configuration_signs(branch)
        return cls(reference=reference, radius=radius, signs=signs, tool=tool, kernels=kernels)

    def angles(self, state: Floats, some: Some = slice(None)) -> tuple[Floats, Floats, Floats]:
        """(M, n) rad without regard to full turns, (M, n, 3) derivatives by the states (M, 3), and (M,) how far each is
        within reach, m: negative beyond."""
        rotation, origin = self.reference.rotation[some].reshape(-1, 9), self.reference.origin[some]
        radius, signs, tool = self.radius[some][:, None], self.signs[some], self.tool[some]
        q, slope, reach = np.empty((len(state), 6)), np.empty((len(state), 18)), np.empty(len(state))
        for k, kernel in enumerate(self.kernels):
            at = np.flatnonzero(tool == k)
            if len(at):
                q[at], slope[at], margins = kernel.run(rotation[at], origin[at], radius[at], state[at], signs[at])
                reach[at] = margins.min(axis=1)
        return q, slope.reshape(-1, 3, 6).swapaxes(1, 2), reach


def _leaned(inverse: ca.Function, tool: Tool) -> ca.Function:
    """(R (9) row-major, p (3), radius (1), state (3), signs (3)) -> q (n), dq/dstate (n x 3 by columns), margins."""
    sizes = {"R": 9, "p": 3, "radius": 1, "x": 3, "s": 3}
    flat, p, radius, state, signs = (ca.SX.sym(name, size) for name, size in sizes.items())
    turn, u, v = state[0], state[1], state[2]
    c, s = ca.cos(turn), ca.sin(turn)
    about = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
    cross = ca.vertcat(ca.horzcat(0, 0, v), ca.horzcat(0, 0, -u), ca.horzcat(-v, u, 0))
    angle = ca.sqrt(u * u + v * v + 1e-16)  # smooth where it is upright
    lean = ca.DM.eye(3) + ca.sin(angle) / angle * cross
    lean += (1 - ca.cos(angle)) / (angle * angle) * ca.mtimes(cross, cross)
    rotation = ca.reshape(flat, 3, 3).T
    upright = rotation[:, 2]
    tcp = ca.mtimes([rotation, lean, about])
    tip = p + radius * (tcp[:, 2] - upright)
    flange = ca.mtimes(tcp, ca.DM(np.asarray(tool.rotation.T)))
    q, margins, _ = inverse(ca.vec(flange.T), tip - ca.mtimes(flange, ca.DM(np.asarray(tool.position))), signs)
    outputs = [ca.densify(q), ca.vec(ca.densify(ca.jacobian(q, state))), ca.densify(margins)]
    return ca.Function("leaned", [flat, p, radius, state, signs], outputs)
