"""Stiffness map: how stiff an arm is posture by posture, and how much the complementary stiffness K_c changes it.

The equilibrium under a wrench is a fixed point x = F(x, W) of the statics (statics.py). Its derivative

    C = J_x (I - dF/dx)^-1 dF/dW           without K_c:  C_0 = J_x dF/dW

is the compliance of the loaded arm at the TCP. For joint springs alone this is the inverse of

    K_x = J^-T (K_theta - K_c) J^-1        K_c = d(J^T W + g)/dq

(Chen & Kao, IJRR 19 (2000) 835; the paper, Eq. 25 and 26); a place that yields is in C all the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.effects.effect import Effect, Numbers
from stiffness.kinematics.jacobian import Conditioning
from stiffness.memory.preload import unknown
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.statics.load import Load
from stiffness.statics.predictor import Predictor
from stiffness.statics.statics import Statics, largest
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

OK, LIMIT, SINGULAR, NO_EQUILIBRIUM = "ok", "limit", "singular", "no-equilibrium"
_STILL = 1e-12  # rad and m: the equilibrium has settled
_SWEEPS = 60
_FARTHEST = 0.2  # rad and m: a larger deflection counts as no equilibrium


@dataclass(frozen=True, repr=False)
class StiffnessMap:
    """Stiffness and deflection at N postures; NaN wherever ``status`` is not ``ok``.

    Attributes:
        q: (N, n) rad.
        status: (N,) ok | limit | singular | no-equilibrium.
        position: (N, 3) m, nominal TCP.
        compliance, compliance_rigid: (N, 6, 6) m and rad per N and N*m at the TCP, with and without K_c.
        displacement, displacement_rigid: (N, 6) m and rad that the wrench moves the TCP, with and without K_c.
    """

    q: Floats
    status: npt.NDArray[np.str_]
    position: Floats
    compliance: Floats
    compliance_rigid: Floats
    displacement: Floats
    displacement_rigid: Floats

    def __repr__(self) -> str:
        return f"StiffnessMap({len(self.q)} postures, {int(np.sum(self.status == OK))} ok)"

    @property
    def softest(self) -> tuple[Floats, Floats, Floats]:
        """Smallest and largest stiffness (N,) N/m against a force at the TCP, and the direction (N, 3) of the smallest
        in base axes. The TCP is free to turn; the direction points up."""
        return _ellipsoid(self.compliance)

    @property
    def softest_rigid(self) -> tuple[Floats, Floats, Floats]:
        """The same without K_c."""
        return _ellipsoid(self.compliance_rigid)

    @property
    def deflection(self) -> Floats:
        """(N,) m."""
        return np.asarray(np.linalg.norm(self.displacement[:, :3], axis=1))

    @property
    def deflection_rigid(self) -> Floats:
        """(N,) m, without K_c."""
        return np.asarray(np.linalg.norm(self.displacement_rigid[:, :3], axis=1))

    @property
    def shift(self) -> Floats:
        """(N,) m between the TCP with and without K_c."""
        return np.asarray(np.linalg.norm(self.displacement[:, :3] - self.displacement_rigid[:, :3], axis=1))

    @property
    def nu_p(self) -> Floats:
        """(N,) the paper's Eq. 27: ``shift`` over the larger of the two deflections; a ratio."""
        return np.asarray(self.shift / np.maximum(self.deflection, self.deflection_rigid))

    @property
    def nu_r(self) -> Floats:
        """(N,) rad, the paper's Eq. 28: largest component of the turn that K_c makes, about x, y, z of the base."""
        return np.asarray(np.abs(self.displacement[:, 3:] - self.displacement_rigid[:, 3:]).max(axis=1))


def _ellipsoid(compliance: Floats) -> tuple[Floats, Floats, Floats]:
    linear = compliance[:, :3, :3]
    fine = np.isfinite(linear).all(axis=(1, 2))
    low, high, direction = (np.full(shape, np.nan) for shape in ((len(linear),), (len(linear),), (len(linear), 3)))
    u, s, _ = np.linalg.svd(linear[fine])
    low[fine], high[fine] = 1 / s[:, 0], 1 / s[:, 2]
    axis = u[:, :, 0]
    # of the two signs the one with its last large component positive: an axis has no head
    size = np.abs(axis)
    last = 2 - np.argmax(size[:, ::-1] > 1e-9, axis=1)
    direction[fine] = axis * np.sign(np.take_along_axis(axis, last[:, None], axis=1))
    return low, high, direction


class Tangent:
    """Equilibrium and its derivative by the wrench, over many postures."""

    def __init__(
        self, robot: Robot, effects: Sequence[Effect], values: Mapping[str, Numbers], tool: Tool, *, gravity: Floats
    ) -> None:
        self._statics = Statics(robot, effects)
        self._p = {e.name: {k: ca.SX(ca.DM(v)) for k, v in values[e.name].items()} for e in effects}
        extra = [(robot.n, ca.SX(tool.mass), ca.SX(ca.DM(tool.com)))] if tool.mass and tool.com is not None else []
        self._weights = self._statics.loads_of_weight(ca.SX(ca.DM(gravity)), extra, self._p)
        self._tool = tool
        self._sweep, self._derivative = self._kernels()

    def equilibrium(self, q: Floats, wrench: Floats, state: Floats) -> tuple[Floats, Bools]:
        """Elastic coordinates (N, n_x), and where they have settled."""
        x = np.zeros((len(q), self._statics.n_x))
        moved = np.full((len(q), 1), np.inf)
        for _ in range(_SWEEPS):
            x, moved = self._sweep.run(q, wrench, state, x)
            # what runs away is kept small enough for the statics to stay finite
            x = np.clip(np.nan_to_num(x, nan=_FARTHEST), -_FARTHEST, _FARTHEST)
            if np.all(moved <= _STILL):
                break
        settled = (moved[:, 0] <= _STILL) & (np.abs(x).max(axis=1) < _FARTHEST)
        return x, np.asarray(settled)

    def compliance(self, q: Floats, wrench: Floats, state: Floats, x: Floats) -> tuple[Floats, Floats]:
        """(N, 6, 6) at the TCP, with and without K_c; rows and columns linear first, base axes."""
        jacobian, by_x, by_wrench = self._derivative.run(q, wrench, state, x)
        n_x = self._statics.n_x
        moved = _columns(jacobian, 6, n_x)
        softening = np.eye(n_x) - _columns(by_x, n_x, n_x)
        loaded = _columns(by_wrench, n_x, 6)
        return moved @ np.linalg.solve(softening, loaded), moved @ loaded

    def _kernels(self) -> tuple[Kernel, Kernel]:
        n, statics = self._statics.robot.n, self._statics
        q, wrench = ca.SX.sym("q", n), ca.SX.sym("wrench", 6)
        state, x = ca.SX.sym("state", statics.n_state), ca.SX.sym("x", statics.n_x)
        posture = statics.posture(q, x)
        tcp = ca.SX(ca.DM(self._tool.position))
        new, _ = statics.law(
            posture, q, weights=self._weights, loads=[Load(n, tcp, wrench)], state=state, values=self._p
        )
        flange = posture.links[n]
        given = [q, wrench, state, x]
        columns = [_moved(flange.rotation, flange.at(tcp), x[k]) for k in range(statics.n_x)]
        out = [_dense(m) for m in (ca.horzcat(*columns), ca.jacobian(new, x), ca.jacobian(new, wrench))]
        sweep = Kernel(ca.Function("sweep", given, [_dense(new), _dense(largest(new - x))]))
        return sweep, Kernel(ca.Function("tangent", given, out))


def _moved(rotation: ca.SX, point: ca.SX, coordinate: ca.SX) -> ca.SX:
    """(6,) velocity and spin of a frame per unit of a coordinate, base axes."""
    spin = ca.mtimes(ca.reshape(ca.jacobian(ca.vec(rotation), coordinate), 3, 3), rotation.T)
    return ca.vertcat(ca.jacobian(point, coordinate), spin[2, 1], spin[0, 2], spin[1, 0])


def _dense(v: ca.SX) -> ca.SX:
    return ca.densify(ca.vec(v))


def _columns(flat: Floats, rows: int, columns: int) -> Floats:
    """(N, rows * columns), column-major, -> (N, rows, columns)."""
    return np.swapaxes(flat.reshape(-1, columns, rows), 1, 2)


def stiffness_map(
    robot: Robot,
    effects: Sequence[Effect],
    values: Mapping[str, Numbers],
    tool: Tool,
    q: Floats,
    wrench: Floats,
    *,
    gravity: Floats,
    tool_axes: bool = False,
    min_singular_value: float = 0.02,
) -> StiffnessMap:
    """Stiffness and deflection at postures.

    Args:
        q: (N, n) rad commanded.
        wrench: (6,) N and N*m on the robot, about the TCP, in base axes, or with ``tool_axes`` in those of the TCP.
        gravity: (3,) m/s2 in the base; zeros leave all weight out.
        min_singular_value: of the Jacobian, translations divided by half the reach; below it a posture is left out.

    Joints stand in the middle of their gaps, with the mean stiffness of both flanks. Deflections are
    what the WRENCH moves: from the equilibrium under weight alone to that under weight and wrench.
    """
    status = np.full(len(q), OK, dtype="<U16")
    status[Conditioning(robot)(q) < min_singular_value] = SINGULAR
    status[np.any((q < robot.lower - 1e-9) | (q > robot.upper + 1e-9), axis=1)] = LIMIT
    exact = Predictor(robot, effects, values, tool, gravity=gravity)
    tcp = exact.nominal(q)
    acting = np.tile(wrench, (len(q), 1))
    if tool_axes:
        acting = np.einsum("nij,nkj->nki", tcp.rotation, acting.reshape(-1, 2, 3)).reshape(-1, 6)
    state = unknown(effects, values).middle
    tangent = Tangent(robot, effects, values, tool, gravity=gravity)
    x, settled = tangent.equilibrium(q, acting, state)
    _, unloaded = tangent.equilibrium(q, np.zeros(6), state)
    status[(status == OK) & ~(settled & unloaded)] = NO_EQUILIBRIUM
    fine = status == OK
    n = len(q)
    stiff, soft = np.full((n, 6, 6), np.nan), np.full((n, 6, 6), np.nan)
    moved, moved_rigid = np.full((n, 6), np.nan), np.full((n, 6), np.nan)
    if fine.any():
        rows = np.ascontiguousarray(q[fine]), np.ascontiguousarray(acting[fine])
        soft[fine], stiff[fine] = tangent.compliance(*rows, state, x[fine])
        rigid = Predictor(robot, effects, values, tool, gravity=gravity, complementary=False)
        moved[fine], moved_rigid[fine] = _displacement(exact, *rows, state), _displacement(rigid, *rows, state)
    for array in (q, status, tcp.origin, soft, stiff, moved, moved_rigid):
        array.setflags(write=False)
    return StiffnessMap(
        q=q,
        status=status,
        position=tcp.origin,
        compliance=soft,
        compliance_rigid=stiff,
        displacement=moved,
        displacement_rigid=moved_rigid,
    )


def _displacement(predictor: Predictor, q: Floats, wrench: Floats, state: Floats) -> Floats:
    """(N, 6) m and rotation vector, base axes, that the wrench moves the TCP."""
    loaded, free = predictor.forward(q, wrench, state), predictor.forward(q, np.zeros(6), state)
    turn = Rotation.from_matrix(loaded.rotation @ np.swapaxes(free.rotation, 1, 2)).as_rotvec()
    return np.hstack([loaded.position - free.position, turn])
