"""ArmFunctions: the statics of one arm with one tool as CasADi functions, which a Predictor runs over many poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers, Values
from stiffness.robot.robot import Robot, constant
from stiffness.statics.deflected_arm import DeflectedArm, LinkFrame
from stiffness.statics.load import Load
from stiffness.statics.small_rotation import vector_of
from stiffness.statics.statics import Statics, largest
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]

OPENING = 4  # Newton steps without a look at the error, where nothing better than the nominal pose is known


class ArmFunctions:
    """The equation with the numbers of a model; the arguments are those of ``Predictor``.

    Attributes:
        statics: the equation.
        n_forward: how many elastic coordinates ``forward`` solves for.
        n_extra: how many ``step`` solves for beside the joints: those of places that yield, and of the sag.
    """

    def __init__(
        self,
        robot: Robot,
        effects: Sequence[Effect],
        values: Mapping[str, Numbers],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool,
        complementary: bool,
        temperature: float,
    ) -> None:
        self.statics = Statics(robot, effects)
        self.calibrated_out = calibrated_out
        self.complementary = complementary
        self._temperature = temperature
        self._p: dict[str, Values] = {e.name: {k: ca.SX(ca.DM(v)) for k, v in values[e.name].items()} for e in effects}
        self._tcp, self._turn = ca.SX(ca.DM(tool.position)), constant(tool.rotation)
        extra = []
        if tool.mass and tool.com is not None:
            extra.append((robot.n, ca.SX(tool.mass), ca.SX(ca.DM(tool.com))))
        downward = ca.SX(ca.DM(gravity))
        self._declared = self.statics.loads_of_weight(downward, extra)
        self._weights = self.statics.loads_of_weight(downward, extra, self._p)
        self._n, self._n_x = robot.n, self.statics.n_x
        self.n_forward = self._n_x * (1 + calibrated_out)
        self.n_extra = self._n_x - robot.n + calibrated_out * self._n_x

    def nominal(self) -> ca.Function:
        """q (n,) -> rotation (9,) and origin (3,) of the TCP of the rigid arm."""
        q = ca.SX.sym("q", self._n)
        tcp = self._tcp_of(self.statics.posture(q, ca.SX.zeros(self._n_x)))
        return ca.Function("nominal", [q], [_dense(tcp.rotation), _dense(tcp.origin)], ["q"], ["rotation", "position"])

    def links(self) -> ca.Function:
        """q (n,), x of ``forward`` -> rotations (9 a link) and origins (3 a link) of links 0..n, rigid and deflected.

        Where the controller takes the sag off, the links are displaced by what is left of it.
        """
        q, x = ca.SX.sym("q", self._n), ca.SX.sym("x", self.n_forward)
        moved = x[: self._n_x]
        if self.calibrated_out:
            moved = moved - x[self._n_x :] + self.statics.unloaded(q, self._p, self._temperature)
        arms = (self.statics.posture(q, ca.SX.zeros(self._n_x)).links, self.statics.posture(q, moved).links)
        frames = [parts for arm in arms for parts in zip(*((f.rotation, f.origin) for f in arm), strict=True)]
        return ca.Function("links", [q, x], [ca.vertcat(*map(_dense, parts)) for parts in frames])

    def joint_deflection(self) -> ca.Function:
        """q (n,), torque (n,), state -> deflection (n,) that the joint laws make of it."""
        q, tau = ca.SX.sym("q", self._n), ca.SX.sym("tau", self._n)
        state = ca.SX.sym("state", self.statics.n_state)
        dq = self.statics.joint_deflection(tau, q, state, values=self._p, temperature=self._temperature)
        return ca.Function("joint", [q, tau, state], [_dense(dq)])

    def forward(self) -> ca.Function:
        """q, wrench, state, x -> x after some sweeps, torque, residual, and rotation and origin of the TCP."""
        q, wrench, state, load = self._symbols()
        x = ca.SX.sym("x", self.n_forward)
        error = self.statics.angle_error(q, self._p)
        equilibrium = partial(
            self.statics.equilibrium,
            q,
            values=self._p,
            complementary=self.complementary,
            temperature=self._temperature,
            angle_error=error,
        )
        eq = equilibrium(x[: self._n_x], weights=self._weights, loads=[load], state=state)
        tcp, coordinates, residual = self._tcp_of(eq.posture), eq.x, eq.residual
        if self.calibrated_out:
            sag = equilibrium(x[self._n_x :], weights=self._declared, loads=(), state=None)
            straight, sagged = self._tcp_of(self._straight(q, error)), self._tcp_of(sag.posture)
            tcp = LinkFrame(
                ca.mtimes(ca.mtimes(tcp.rotation, sagged.rotation.T), straight.rotation),
                tcp.origin - sagged.origin + straight.origin,
            )
            coordinates, residual = ca.vertcat(eq.x, sag.x), largest(ca.vertcat(eq.residual, sag.residual))
        out = [_dense(v) for v in (coordinates, eq.torque, residual, tcp.rotation, tcp.origin)]
        return ca.Function("forward", [q, wrench, state, x], out)

    def step(self, *, newton: bool) -> ca.Function:
        """One step towards the command: every coordinate moves once, the largest move and miss is the error.

        Wanted rotation (9,) and position (3,), wrench, state, actual q, extra, commanded q -> the next three of them,
        torque and error.
        """
        q, wrench, state, load = self._symbols()
        flat, position = ca.SX.sym("rotation", 9), ca.SX.sym("position", 3)
        extra, commanded = ca.SX.sym("extra", self.n_extra), ca.SX.sym("commanded", self._n)
        error = self.statics.angle_error(commanded, self._p)
        beside = self._n_x - self._n
        target = LinkFrame(ca.reshape(flat, 3, 3), position)
        arm = self.statics.posture(q, ca.vertcat(ca.SX.zeros(self._n), extra[:beside]))
        loaded = arm if self.complementary else self._straight(commanded, error)
        x, tau = self._law(loaded, commanded, error, weights=self._weights, loads=[load], state=state)
        new_extra = x[self._n :]
        if self.calibrated_out:
            new_sag, target = self._with_sag(target, commanded, error, extra[beside:])
            new_extra = ca.vertcat(new_extra, new_sag)
        tcp = self._tcp_of(arm)
        turn = ca.mtimes(target.rotation, tcp.rotation.T)
        off = ca.vertcat(target.origin - tcp.origin, vector_of(turn))
        half_turn = (3 - ca.trace(turn)) / 2  # 1 - cos: the rotation vector above is zero for half a turn too
        left = largest(ca.vertcat(off, half_turn, new_extra - extra))
        new = q + ca.solve(_jacobian(arm, tcp.origin), off) if newton else q
        out = [_dense(v) for v in (new, new_extra, q - x[: self._n], tau, left)]
        given = [flat, position, wrench, state, q, extra, commanded]
        return ca.Function("newton" if newton else "exact", given, out)

    def opening(self, step: ca.Function) -> ca.Function:
        """Several Newton steps in one go; the same arguments, the next three of them."""
        given = [ca.SX.sym(name, step.numel_in(k)) for k, name in enumerate(step.name_in())]
        q, extra, commanded = given[4:]
        for _ in range(OPENING):
            new, new_extra, now, _, _ = step(*given[:4], q, extra, commanded)
            q, extra, commanded = new, new_extra, now + new - q
        return ca.Function("opening", given, [_dense(v) for v in (commanded, extra, q)])

    @property
    def implicit_in_command(self) -> bool:
        """Whether anything but the actual posture enters the law: then the command has to settle too."""
        if self.calibrated_out or not self.complementary:
            return True
        angle, q = ca.SX.sym("angle", self._n), ca.SX.sym("q", self._n)
        state = ca.SX.sym("s", self.statics.n_state)
        arm = self.statics.posture(q, ca.SX.zeros(self._n_x))
        error = self.statics.angle_error(angle, self._p)
        law, _ = self._law(arm, angle, error, weights=self._weights, loads=(), state=state)
        return bool(np.any(ca.which_depends(law, angle, 1, True)))

    def _symbols(self) -> tuple[ca.SX, ca.SX, ca.SX, Load]:
        q, wrench = ca.SX.sym("q", self._n), ca.SX.sym("wrench", 6)
        return q, wrench, ca.SX.sym("state", self.statics.n_state), Load(self._n, self._tcp, wrench)

    def _tcp_of(self, arm: DeflectedArm) -> LinkFrame:
        return arm.links[-1].then(self._turn, self._tcp)

    def _law(
        self,
        arm: DeflectedArm,
        q: ca.SX,
        angle_error: ca.SX,
        *,
        weights: Sequence[tuple[int, ca.SX, ca.SX]],
        loads: Sequence[Load],
        state: ca.SX | None,
    ) -> tuple[ca.SX, ca.SX]:
        return self.statics.law(
            arm,
            q,
            weights=weights,
            loads=loads,
            state=state,
            values=self._p,
            temperature=self._temperature,
            angle_error=angle_error,
        )

    def _straight(self, q: ca.SX, angle_error: ca.SX) -> DeflectedArm:
        """The arm without any load, with the kinematic offsets that it has."""
        return self.statics.posture(q, self.statics.unloaded(q, self._p, self._temperature, angle_error))

    def _with_sag(self, target: LinkFrame, q: ca.SX, angle_error: ca.SX, x: ca.SX) -> tuple[ca.SX, LinkFrame]:
        """One sweep of the sag without process, and the target with the sag that the controller takes off."""
        straight = self._straight(q, angle_error)
        arm = self.statics.posture(q, x) if self.complementary else straight
        new, _ = self._law(arm, q, angle_error, weights=self._declared, loads=(), state=None)
        sagged, tcp = self._tcp_of(self.statics.posture(q, new)), self._tcp_of(straight)
        rotation = ca.mtimes(ca.mtimes(target.rotation, tcp.rotation.T), sagged.rotation)
        return new, LinkFrame(rotation, target.origin + sagged.origin - tcp.origin)


def _jacobian(arm: DeflectedArm, point: ca.SX) -> ca.SX:
    """(6, n) of a point that moves with the flange, by the joint angles: linear rows first, base axes."""
    turning = zip(arm.axes, arm.joints, strict=True)
    return ca.horzcat(*(ca.vertcat(ca.cross(axis, point - joint.origin), axis) for axis, joint in turning))


def _dense(v: ca.SX) -> ca.SX:
    return ca.densify(ca.vec(v))
