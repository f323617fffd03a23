"""Statics: the equation of the deflected arm, from loads and effects to the frames of all links, once, in CasADi.

    x = law(load(q + dq, [d; phi]))        x = (dq, [d; phi] of every place that yields)

is solved by sweeps torque -> deflection -> posture from a start value. The load is taken at the DEFLECTED
posture, so the complementary stiffness K_c (Chen & Kao, IJRR 19 (2000) 835) is in it; on real
robots a sweep gains about two digits. ``residual`` is what the last sweep still moved.

Every function takes SX or DM: prediction puts numbers where identification puts symbols.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, JointInput, PlaceInput, Values
from stiffness.memory.state_columns import state_columns
from stiffness.robot.robot import Robot, axis_rotation, constant
from stiffness.statics.deflected_arm import DeflectedArm, LinkFrame
from stiffness.statics.load import Load, with_loads
from stiffness.statics.small_rotation import generalised_moment, rotation

Floats = npt.NDArray[np.float64]

SWEEPS = 6  # contraction 0.01 per sweep on real robots: 6 reach rounding


@dataclass(frozen=True)
class Equilibrium:
    """Result of the statics: ``x`` (m,) elastic coordinates, ``torque`` (n,), ``posture``, ``residual``."""

    x: ca.SX
    torque: ca.SX
    posture: DeflectedArm
    residual: ca.SX


def largest(v: ca.SX) -> ca.SX:
    """Largest magnitude; NaN where any element is, which the infinity norm would drop."""
    return ca.if_else(ca.dot(v, v) >= 0, ca.norm_inf(v), float("nan"))


class Statics:
    """The equation for one robot and one set of effects.

    Elastic coordinates ``x``: n joint deflections, then six (m, rad) for every place that yields.
    Memory ``s``: of every effect with memory its states joint by joint, in the order of the effects.
    """

    def __init__(self, robot: Robot, effects: Sequence[Effect]) -> None:
        self.robot = robot
        self.effects = tuple(effects)
        n = robot.n
        self.yielding = {k: tuple(e for e in effects if e.place and k in e.places(n)) for k in range(n + 1)}
        self.places = tuple(k for k, es in self.yielding.items() if es)
        self.remembering = tuple(e for e in effects if e.memory)
        self.columns = state_columns(effects, n)
        self.n_x = n + 6 * len(self.places)
        self.n_state = n * sum(e.memory.states for e in self.remembering if e.memory)

    def __repr__(self) -> str:
        return f"Statics({self.robot.name}, {[e.name for e in self.effects]}, {self.n_x} coordinates)"

    def posture(self, q: ca.SX, x: ca.SX) -> DeflectedArm:
        """Frames of the arm at joint angles q + x[:n] with places displaced by x[n:]."""
        n = self.robot.n
        frame = LinkFrame(ca.SX.eye(3), ca.SX.zeros(3))
        links, joints, axes, places = [], [], [], [frame]
        frame = self._displaced(frame, 0, x)
        links.append(frame)
        for k in range(n):
            before, after = constant(self.robot.before[k]), constant(self.robot.after[k])
            frame = frame.then(before[:3, :3], before[:3, 3])
            joints.append(frame)
            axes.append(ca.mtimes(frame.rotation, constant(self.robot.axis[k])))
            frame = frame.then(axis_rotation(self.robot.axis[k], q[k] + x[k]), ca.SX(3, 1))
            frame = frame.then(after[:3, :3], after[:3, 3])
            places.append(frame)
            frame = self._displaced(frame, k + 1, x)
            links.append(frame)
        displacements = {k: self._displacement(k, x) for k in self.places}
        return DeflectedArm(
            angles=q + x[:n],
            displacements=displacements,
            links=tuple(links),
            joints=tuple(joints),
            axes=tuple(axes),
            places=tuple(places),
        )

    def _displaced(self, frame: LinkFrame, place: int, x: ca.SX) -> LinkFrame:
        if place not in self.places:
            return frame
        displacement = self._displacement(place, x)
        return frame.then(rotation(displacement[3:]), displacement[:3])

    def _displacement(self, place: int, x: ca.SX) -> ca.SX:
        at = self.robot.n + 6 * self.places.index(place)
        return x[at : at + 6]

    def loads_of_weight(
        self, gravity: ca.SX, extra: Sequence[tuple[int, ca.SX, ca.SX]] = (), values: Mapping[str, Values] | None = None
    ) -> list[tuple[int, ca.SX, ca.SX]]:
        """Weights as (link, point, force in base axes): the robot's links and ``extra`` (link, mass, com).

        With ``values`` also the masses that effects add: what no controller knows.
        """
        weights = []
        if self.robot.mass is not None and self.robot.com is not None:
            for k in range(self.robot.n):
                weights.append((k + 1, ca.SX(ca.DM(self.robot.com[k])), self.robot.mass[k] * gravity))
        weights += [(link, com, mass * gravity) for link, mass, com in extra]
        if values is not None:
            for e in self.effects:
                masses = e.mass(self.robot.n, values[e.name]) if e.mass else ()
                weights += [(m.link, m.com, m.mass * gravity) for m in masses]
        return weights

    def law(
        self,
        posture: DeflectedArm,
        q: ca.SX,
        weights: Sequence[tuple[int, ca.SX, ca.SX]],
        loads: Sequence[Load],
        state: ca.SX | None,
        values: Mapping[str, Values],
        temperature: ca.SX | float = 0.0,
        angle_error: ca.SX | None = None,
    ) -> tuple[ca.SX, ca.SX]:
        """One sweep: the loads at a posture, and the elastic coordinates they cause.

        Args:
            q: (n,) rad commanded.
            temperature: K above the model's reference.
            angle_error: (n,) rad that the laws of the angle alone make; None: they are worked out here.

        Returns:
            x (n_x,), torque (n,) of gravity and environment on each joint.
        """
        n = self.robot.n
        force, moment = ca.SX.zeros(3), ca.SX.zeros(3)  # of all outward of a place, about the base origin
        torque: list[ca.SX] = [ca.SX(0)] * n
        displacements: dict[int, ca.SX] = {}
        for k in range(n, -1, -1):
            force, moment = with_loads((force, moment), posture, k, weights=weights, loads=loads)
            if k in self.places:
                turn = posture.places[k].rotation.T
                about = moment - ca.cross(posture.links[k].origin, force)
                about = generalised_moment(posture.displacements[k][3:], ca.mtimes(turn, about))
                displacements[k] = self._yielded(k, ca.vertcat(ca.mtimes(turn, force), about), values, temperature)
            if k > 0:
                about = moment - ca.cross(posture.joints[k - 1].origin, force)
                torque[k - 1] = ca.dot(posture.axes[k - 1], about)
        tau = ca.vertcat(*torque)
        tau = sum((e.torque(posture.angles, values[e.name]) for e in self.effects if e.torque), tau)
        dq = self.joint_deflection(tau, q, state, values=values, temperature=temperature, angle_error=angle_error)
        return ca.vertcat(dq, *(displacements[k] for k in self.places)), tau

    def unloaded(
        self,
        q: ca.SX,
        values: Mapping[str, Values],
        temperature: ca.SX | float = 0.0,
        angle_error: ca.SX | None = None,
    ) -> ca.SX:
        """Elastic coordinates (n_x,) of an arm that carries nothing: kinematic offsets, growth by heat."""
        none = ca.SX.zeros(self.robot.n)
        dq = self.joint_deflection(none, q, None, values=values, temperature=temperature, angle_error=angle_error)
        return ca.vertcat(dq, *(self._yielded(k, ca.SX.zeros(6), values, temperature) for k in self.places))

    def _yielded(self, place: int, wrench: ca.SX, values: Mapping[str, Values], temperature: ca.SX | float) -> ca.SX:
        inner, outer = self._span(place)
        given = PlaceInput(place=place, wrench=wrench, temperature=ca.SX(temperature), inner=inner, outer=outer)
        return sum((e.place(given, values[e.name]) for e in self.yielding[place] if e.place), ca.SX.zeros(6))

    def _span(self, place: int) -> tuple[Floats, Floats]:
        """Where the link of a place begins and ends: its joint and the next one (3,), in the axes of the place."""
        inner, outer = np.zeros(3), np.zeros(3)
        if place > 0:
            after = self.robot.after[place - 1]
            inner = -after[:3, :3].T @ after[:3, 3]
        if place < self.robot.n:
            outer = self.robot.before[place][:3, 3]
        return inner, outer

    def angle_error(self, q: ca.SX, values: Mapping[str, Values]) -> ca.SX:
        """dq (n,) rad that the laws of the angle alone make, whatever the load.

        Such a law may be a long table: who asks for several sweeps at one ``q`` works it out once and hands it on.
        """
        none = ca.SX.zeros(self.robot.n)
        return sum((e.angle(q, values[e.name]) for e in self.effects if e.angle), none)

    def joint_deflection(
        self,
        tau: ca.SX,
        q: ca.SX,
        state: ca.SX | None,
        values: Mapping[str, Values],
        temperature: ca.SX | float = 0.0,
        angle_error: ca.SX | None = None,
    ) -> ca.SX:
        """dq (n,) that all joint laws together make of a torque; without ``state`` those without memory."""
        n = self.robot.n
        none = ca.SX.zeros(n)
        base = next((e for e in self.effects if e.is_base), None)
        at_rest = JointInput(
            torque=none, elastic=none, compliance=none, angle=q, state=none, temperature=ca.SX(temperature)
        )

        def springs(torque: ca.SX) -> ca.SX:
            if base is None or base.joint is None:
                return none
            return base.joint(replace(at_rest, torque=torque), values[base.name])

        elastic, compliance = springs(tau), springs(ca.SX.ones(n))
        dq = self.angle_error(q, values) if angle_error is None else angle_error
        loaded, columns = replace(at_rest, torque=tau, elastic=elastic, compliance=compliance), self.columns
        for e in self.effects:
            if e.memory and state is None:
                continue
            own = none if state is None or not e.memory else state[columns[e.name]]
            if e.joint:
                dq = dq + e.joint(replace(loaded, state=own), values[e.name])
        return dq

    def equilibrium(
        self,
        q: ca.SX,
        x: ca.SX,
        weights: Sequence[tuple[int, ca.SX, ca.SX]],
        loads: Sequence[Load],
        state: ca.SX | None,
        values: Mapping[str, Values],
        *,
        sweeps: int = SWEEPS,
        complementary: bool = True,
        temperature: ca.SX | float = 0.0,
        angle_error: ca.SX | None = None,
    ) -> Equilibrium:
        """Static equilibrium at commanded angles ``q``, from the start value ``x``.

        Args:
            complementary: False takes the load at the unloaded posture (no K_c; paper, Eq. 26).
            angle_error: as in ``law``.
        """
        error = self.angle_error(q, values) if angle_error is None else angle_error
        law = partial(
            self.law,
            q=q,
            weights=weights,
            loads=loads,
            state=state,
            values=values,
            temperature=temperature,
            angle_error=error,
        )
        if not complementary:
            rigid = self.posture(q, self.unloaded(q, values, temperature, error))
            x, tau = law(rigid)
            return Equilibrium(x, tau, self.posture(q, x), ca.SX(0))
        residual, tau = ca.SX(0), ca.SX.zeros(self.robot.n)
        for _ in range(sweeps):
            new, tau = law(self.posture(q, x))
            residual = largest(new - x)
            x = new
        return Equilibrium(x, tau, self.posture(q, x), residual)
