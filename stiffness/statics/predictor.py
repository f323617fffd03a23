"""Predictor: the statics of one arm with one tool, over whole paths, forwards and backwards.

Forwards, a command is given and the equilibrium asked for. Backwards, the pose of the deflected TCP is given
and the command asked for; the ACTUAL joint angles are then the unknown, because the load depends on
them alone: a pure joint model needs no iteration (``q_cmd = q_act - law(J(q_act)^T W + g(q_act))`` is exact,
K_c included), any other a few Newton steps with the Jacobian of the deflected chain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers, Values
from stiffness.errors import EquilibriumError
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot, constant
from stiffness.statics.solution import COLUMNS, TOLERANCE, Command, Near, Prediction, Tool
from stiffness.statics.statics import SWEEPS, Equilibrium, Load, Posture, Statics, largest

__all__ = ["COLUMNS", "TOLERANCE", "Command", "Near", "Prediction", "Predictor", "Tool"]

Floats = npt.NDArray[np.float64]

MAX_STEPS = 25
OPENING = 4  # Newton steps without a look at the error, where nothing better than the nominal pose is known
LARGEST_TURN = 0.05  # rad; statics.rotation is exact below
MAX_SWEEP_CALLS = 10


class Predictor:
    """Statics of ``robot`` with ``effects`` of the given ``values``, carrying ``tool``.

    Args:
        gravity: (3,) m/s2 in the base.
        calibrated_out: the controller knows the sag of arm and declared tool: it is taken off again,
            in base axes, with neutral joints (no gap, pre-loaded).
        complementary: False takes every load at the unloaded posture: no K_c.
        temperature: K above the reference temperature of the model.
    """

    def __init__(
        self,
        robot: Robot,
        effects: Sequence[Effect],
        values: Mapping[str, Numbers],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool = False,
        complementary: bool = True,
        temperature: float = 0.0,
    ) -> None:
        self.robot = robot
        self.values = values
        self.tool = tool
        self.calibrated_out = calibrated_out
        self.complementary = complementary
        self.temperature = temperature
        self.statics = Statics(robot, effects)
        self._p: dict[str, Values] = {e.name: {k: ca.SX(ca.DM(v)) for k, v in values[e.name].items()} for e in effects}
        self._tcp = ca.SX(ca.DM(tool.position))
        self._turn = constant(tool.rotation)
        extra = []
        if tool.mass and tool.com is not None:
            extra.append((robot.n, ca.SX(tool.mass), ca.SX(ca.DM(tool.com))))
        downward = ca.SX(ca.DM(gravity))
        self._declared = self.statics.loads_of_weight(downward, extra)
        self._weights = self.statics.loads_of_weight(downward, extra, self._p)

    def __repr__(self) -> str:
        return f"Predictor({self.statics!r}, tool {self.tool.name!r})"

    def forward(self, q: Floats, wrench: Floats, state: Floats) -> Prediction:
        """Equilibrium of commanded poses.

        Args:
            q: (N, n) rad.
            wrench: (N, 6) or (6,), on the robot, base axes, about the TCP.
            state: (N, m) or (m,) memory, ``PreloadState.middle`` or a bracket.

        Raises:
            EquilibriumError: no equilibrium: the arm is too soft for the load.
        """
        x = np.zeros((len(q), self._n_forward))
        for _ in range(MAX_SWEEP_CALLS):
            x, torque, residual, rotation, position = self._forward_kernel.run(q, wrench, state, x)
            if not np.any(~(residual <= TOLERANCE)):
                self._refuse_large_turns(x)
                return Prediction(_matrices(rotation), position, torque, residual[:, 0])
        worst = int(np.argmax(np.where(np.isfinite(residual[:, 0]), residual[:, 0], np.inf)))
        raise EquilibriumError(
            worst,
            f"no static equilibrium (last change {residual[worst, 0]:.2e} rad after "
            f"{MAX_SWEEP_CALLS} x {SWEEPS} sweeps): the load is too large for these stiffnesses; check their unit "
            "(N*m/rad)",
        )

    def _refuse_large_turns(self, x: Floats) -> None:
        """The statics holds for places that turn by small angles: beyond, its numbers are wrong and the arm absurd."""
        n, places = self.robot.n, len(self.statics.places)
        turns = np.abs(x[:, n : n + 6 * places].reshape(len(x), places, 6)[:, :, 3:]).max(axis=(1, 2), initial=0.0)
        if np.any(turns > LARGEST_TURN):
            row = int(np.argmax(turns))
            raise EquilibriumError(
                row,
                f"a place that yields turns by {turns[row]:.3f} rad, above {LARGEST_TURN:g}: too soft for this load; "
                "check the units of the compliances in the model (m/N, rad/(N*m))",
            )

    def nominal(self, q: Floats) -> tuple[Floats, Floats]:
        """TCP rotation (N, 3, 3) and position (N, 3) of the rigid, nominal arm: what a controller prints."""
        rotation, position = self._nominal_kernel.run(q)
        return _matrices(rotation), position

    def command(
        self, rotation: Floats, position: Floats, wrench: Floats, state: Floats, start: Floats, near: Near | None = None
    ) -> Command:
        """Commands whose deflected TCP stands at the wanted pose.

        Args:
            rotation, position: (N, 3, 3) and (N, 3) of the wanted TCP, base.
            wrench: (N, 6), base axes, about the TCP.
            state: (N, m).
            start: (N, n) rad, nominal inverse kinematics of the wanted poses: it decides the arm configuration.
            near: where to begin instead, for models that need Newton steps.
        """
        flat = _flat(rotation)
        exact = not self._newton_needed
        if near is not None and not exact:
            q, actual, extra = near.q.copy(), near.actual.copy(), near.extra.copy()
        else:
            q, actual, extra = start.copy(), start.copy(), np.zeros((len(start), self._n_extra))
            if not exact:
                q, extra, actual = self._opening_kernel.run(flat, position, wrench, state, actual, extra, q)
        torque, error = np.zeros_like(start), np.full(len(start), np.inf)
        rows, steps = np.arange(len(start)), 0
        while len(rows) and steps < MAX_STEPS:
            kernel = self._exact_kernel if exact and steps == 0 else self._newton_kernel
            given = (flat, position, wrench, state, actual, extra, q)
            new, new_extra, q_new, tau, e = kernel.run(*(_rows(array, rows, len(q)) for array in given))
            if self._implicit_in_command:
                e = np.maximum(e, np.abs(q_new - q[rows]).max(axis=1, keepdims=True))
            q[rows], torque[rows], error[rows] = q_new, tau, e[:, 0]
            open_rows = ~(e[:, 0] <= TOLERANCE)
            rows, steps = rows[open_rows], steps + 1
            q[rows] += new[open_rows] - actual[rows]  # the command goes along with the Newton step
            actual[rows], extra[rows] = new[open_rows], new_extra[open_rows]
        nominal_r, nominal_p = self.nominal(q)
        return Command(q, actual, torque, nominal_r, nominal_p, error, extra, steps - 1)

    def joint_deflection(self, q: Floats, torque: Floats, state: Floats) -> Floats:
        """dq (N, n) of the joint laws alone at known torques: what a change of state is worth."""
        (dq,) = self._joint_kernel.run(q, torque, state)
        return dq

    @cached_property
    def _joint_kernel(self) -> Kernel:
        q, tau = ca.SX.sym("q", self.robot.n), ca.SX.sym("tau", self.robot.n)
        state = ca.SX.sym("state", self.statics.n_state)
        dq = self.statics.joint_deflection(tau, q, state, self._p, self.temperature)
        return Kernel(ca.Function("joint", [q, tau, state], [_dense(dq)]))

    @property
    def _newton_needed(self) -> bool:
        return bool(self.statics.places) or self.calibrated_out or not self.complementary

    @property
    def _n_extra(self) -> int:
        return self.statics.n_x - self.robot.n + self.calibrated_out * self.statics.n_x

    @property
    def _n_forward(self) -> int:
        return self.statics.n_x * (1 + self.calibrated_out)

    @cached_property
    def _implicit_in_command(self) -> bool:
        """Whether anything but the actual posture enters the law: then the command has to settle too."""
        if self.calibrated_out or not self.complementary:
            return True
        return bool(np.any(ca.which_depends(self._law_of_angle[0], self._law_of_angle[1], 1, True)))

    @cached_property
    def _law_of_angle(self) -> tuple[ca.SX, ca.SX]:
        angle, q = ca.SX.sym("angle", self.robot.n), ca.SX.sym("q", self.robot.n)
        s = ca.SX.sym("s", self.statics.n_state)
        x = ca.SX.zeros(self.statics.n_x)
        law, _ = self.statics.law(self.statics.posture(q, x), angle, self._weights, (), s, self._p, self.temperature)
        return law, angle

    def _symbols(self) -> tuple[ca.SX, ca.SX, ca.SX, Load]:
        q, wrench = ca.SX.sym("q", self.robot.n), ca.SX.sym("wrench", 6)
        return q, wrench, ca.SX.sym("state", self.statics.n_state), Load(self.robot.n, self._tcp, wrench)

    def _tcp_of(self, posture: Posture) -> tuple[ca.SX, ca.SX]:
        flange = posture.links[-1]
        return ca.mtimes(flange.rotation, self._turn), flange.at(self._tcp)

    @cached_property
    def _nominal_kernel(self) -> Kernel:
        q = ca.SX.sym("q", self.robot.n)
        r, p = self._nominal(q)
        return Kernel(ca.Function("nominal", [q], [_dense(r), _dense(p)], ["q"], ["rotation", "position"]))

    @cached_property
    def _forward_kernel(self) -> Kernel:
        q, wrench, state, load = self._symbols()
        n_x = self.statics.n_x
        x = ca.SX.sym("x", self._n_forward)
        eq = self._equilibrium(q, x[:n_x], [load], state)
        r, p = self._tcp_of(eq.posture)
        coordinates, residual = eq.x, eq.residual
        if self.calibrated_out:
            sag = self._equilibrium(q, x[n_x:], None, None)
            straight_r, straight_p = self._tcp_of(self._straight(q))
            sag_r, sag_p = self._tcp_of(sag.posture)
            r, p = ca.mtimes(ca.mtimes(r, sag_r.T), straight_r), p - sag_p + straight_p
            coordinates, residual = ca.vertcat(eq.x, sag.x), largest(ca.vertcat(eq.residual, sag.residual))
        out = [_dense(v) for v in (coordinates, eq.torque, residual, r, p)]
        return Kernel(ca.Function("forward", [q, wrench, state, x], out))

    def _equilibrium(self, q: ca.SX, x: ca.SX, loads: Sequence[Load] | None, state: ca.SX | None) -> Equilibrium:
        """With ``loads``, or where None the sag that a controller may know: arm and declared tool alone."""
        weights = self._declared if loads is None else self._weights
        return self.statics.equilibrium(
            q,
            x,
            weights,
            loads or (),
            state,
            self._p,
            complementary=self.complementary,
            temperature=self.temperature,
        )

    def _nominal(self, q: ca.SX) -> tuple[ca.SX, ca.SX]:
        return self._tcp_of(self.statics.posture(q, ca.SX.zeros(self.statics.n_x)))

    def _straight(self, q: ca.SX) -> Posture:
        """The arm without any load, with the kinematic offsets that it has."""
        return self.statics.posture(q, self.statics.unloaded(q, self._p, self.temperature))

    def _sag(self, q: ca.SX, x: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """One sweep of the sag without process: coordinates, and TCP rotation and position with them."""
        at = self.statics.posture(q, x) if self.complementary else self._straight(q)
        new, _ = self.statics.law(at, q, self._declared, (), None, self._p, self.temperature)
        return new, *self._tcp_of(self.statics.posture(q, new))

    @cached_property
    def _exact_kernel(self) -> Kernel:
        return self._step_kernel(newton=False)

    @cached_property
    def _newton_kernel(self) -> Kernel:
        return self._step_kernel(newton=True)

    @cached_property
    def _opening_kernel(self) -> Kernel:
        """Several steps in one go."""
        step = self._newton_kernel.function
        given = [ca.SX.sym(name, step.numel_in(k)) for k, name in enumerate(step.name_in())]
        q, extra, commanded = given[4:]
        for _ in range(OPENING):
            new, new_extra, now, _, _ = step(*given[:4], q, extra, commanded)
            q, extra, commanded = new, new_extra, now + new - q
        return Kernel(ca.Function("opening", given, [_dense(v) for v in (commanded, extra, q)]))

    def _step_kernel(self, *, newton: bool) -> Kernel:
        """One step towards the command: every coordinate moves once, the largest move and miss is the error."""
        q, wrench, state, load = self._symbols()
        n, n_places = self.robot.n, self.statics.n_x - self.robot.n
        flat_r, target_p = ca.SX.sym("rotation", 9), ca.SX.sym("position", 3)
        extra, commanded = ca.SX.sym("extra", self._n_extra), ca.SX.sym("commanded", n)
        target_r = ca.reshape(flat_r, 3, 3)
        displacements, sag = extra[:n_places], extra[n_places:]
        posture = self.statics.posture(q, ca.vertcat(ca.SX.zeros(n), displacements))
        loaded = posture if self.complementary else self._straight(commanded)
        x, tau = self.statics.law(loaded, commanded, self._weights, [load], state, self._p, self.temperature)
        new_extra = x[n:]
        if self.calibrated_out:
            new_sag, sag_r, sag_p = self._sag(commanded, sag)
            straight_r, straight_p = self._tcp_of(self._straight(commanded))
            target_r, target_p_ = ca.mtimes(ca.mtimes(target_r, straight_r.T), sag_r), target_p + sag_p - straight_p
            new_extra = ca.vertcat(new_extra, new_sag)
        else:
            target_p_ = target_p
        r, p = self._tcp_of(posture)
        turn = ca.mtimes(target_r, r.T)
        off = ca.vertcat(target_p_ - p, _turned(turn))
        half_turn = (3 - ca.trace(turn)) / 2  # 1 - cos: the rotation vector above is zero for half a turn too
        error = largest(ca.vertcat(off, half_turn, new_extra - extra))
        new = q
        if newton:
            turning = zip(posture.axes, posture.joints, strict=True)
            columns = [ca.vertcat(ca.cross(a, p - j.origin), a) for a, j in turning]
            new = q + ca.solve(ca.horzcat(*columns), off)
        out = [_dense(v) for v in (new, new_extra, q - x[:n], tau, error)]
        given = [flat_r, target_p, wrench, state, q, extra, commanded]
        return Kernel(ca.Function("newton" if newton else "exact", given, out))


def _turned(turn: ca.SX) -> ca.SX:
    """Rotation vector of a small rotation matrix."""
    return 0.5 * ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])


def _dense(v: ca.SX) -> ca.SX:
    return ca.densify(ca.vec(v))


def _matrices(flat: Floats) -> Floats:
    """(N, 9) column-major -> (N, 3, 3)."""
    return np.swapaxes(flat.reshape(-1, 3, 3), 1, 2)


def _flat(matrices: Floats) -> Floats:
    return np.ascontiguousarray(np.swapaxes(matrices, 1, 2).reshape(-1, 9))


def _rows(array: Floats, rows: npt.NDArray[np.intp], count: int) -> Floats:
    return array if array.ndim == 1 or len(rows) == count else array[rows]
