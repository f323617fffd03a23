"""Reading model: what a laser tracker would read, on the statics that prediction uses, with free parameters.

A reading is the position of a reflector on some link under a load on some link. One CasADi function per kind of
load gives the arm at rest, with the derivatives of its elastic coordinates by parameters, wrench and memory; it is
evaluated for all readings of that kind at once. Where a reflector then is, is kinematics (statics/point_motion.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Numbers, ProgrammedWrench, ShownWrench, Values, acting_wrench
from stiffness.identification.angle_tables import AngleTables
from stiffness.identification.arm_loads import ArmEquilibria, ArmLoads, LoadKind
from stiffness.identification.equilibrium_kernel import STEPS, EquilibriumKernel
from stiffness.identification.unknowns import Unknowns, every_number, start_values
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.statics.deflected_arm import DeflectedArm
from stiffness.statics.load import Load
from stiffness.statics.point_motion import PointMotion
from stiffness.statics.statics import Statics
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

KEPT = 24  # kernels


@dataclass(frozen=True, repr=False, eq=False)
class ReflectorPositions:
    """Predicted positions of reflectors on one link, with their derivatives.

    Attributes:
        position: (N, 3) m, base.
        by_parameter: (N, 3, P).
        by_wrench: (N, 3, 6), of what the sensor shows.
        by_state: (N, 3, s), by the memory as a share of its half range.
        by_angle: (N, 3, n), by an error of the joints' angles.
        rotation: (N, 3, 3) of the reflector's link: derivative by the reflector's place.
    """

    position: Floats
    by_parameter: Floats
    by_wrench: Floats
    by_state: Floats
    by_angle: Floats
    rotation: Floats


class ReadingModel:
    """Predicts the readings of one robot with one tool; its parameters are free. Constant: only kernels are kept.

    Args:
        gravity: (3,) m/s2 in the base.
        calibrated_out: readings carry no sag of arm and declared tool without load.
    """

    def __init__(
        self,
        robot: Robot,
        unknowns: Unknowns,
        fixed: Mapping[str, Numbers],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool,
    ) -> None:
        self.robot, self.unknowns, self.fixed, self.tool = robot, unknowns, fixed, tool
        self.calibrated_out = calibrated_out
        self.statics = Statics(robot, unknowns.effects)
        self._gravity = ca.SX(ca.DM(gravity))
        self.tables = AngleTables(robot.n, unknowns, fixed)
        self._every = every_number(unknowns.effects, robot.n)
        self.sweep = SweepKey.of(robot, unknowns.effects, fixed, tool, gravity=gravity, calibrated_out=calibrated_out)

    @property
    def n_x(self) -> int:
        """How many elastic coordinates a reading has."""
        return self.statics.n_x * (3 if self.calibrated_out else 1)

    @cached_property
    def _own(self) -> Index:
        """Where its free numbers stand among all that a kernel has slopes by."""
        place = {u: k for k, u in enumerate(self._every.free)}
        return np.array([place[self.unknowns.free[k]] for k in self.tables.core], dtype=np.intp)

    @cached_property
    def motion(self) -> PointMotion:
        """Its kinematics."""
        return PointMotion(self.statics)

    def equilibria(
        self, kind: LoadKind, p: Floats, loads: ArmLoads, x: Floats, steps: int = STEPS
    ) -> ArmEquilibria:
        """Equilibria under loads of one kind, for parameters ``p`` (P,) as the solver sees them, started from ``x``
        (N, n_x); ``steps``: of Newton at most."""
        values = self.unknowns.values(p, self.fixed)
        error = self.tables.error(loads.q, p)
        inputs = (loads.q, loads.wrench, loads.point, loads.state, loads.payload, loads.warm, error)
        given = [*inputs, self._every.start(values), loads.axes]
        new, torque, by = equilibrium_kernel(self.sweep, kind).run(given, x, self._own, steps)
        return ArmEquilibria(loads.q, new, torque, *by)

    def unloaded_torque(self, p: Floats, q: Floats, payload: Floats, warm: Floats) -> Floats:
        """(N, n) N*m that the joints carry without load, at the undeflected posture; arguments as in ``ArmLoads``."""
        s = self.statics
        core = self.tables.core
        given = [ca.SX.sym(name, m) for name, m in (("q", s.robot.n), ("payload", 1), ("warm", 1), ("p", len(core)))]
        values = self.unknowns.values(self.tables.whole(given[3]), self.fixed)
        at = s.posture(given[0], ca.SX.zeros(s.n_x))
        none, weights = ca.SX.zeros(s.robot.n), self.weights(values, given[1])
        _, torque = s.law(
            posture=at,
            q=given[0],
            weights=weights,
            loads=(),
            state=None,
            values=values,
            temperature=given[2],
            angle_error=none,
        )
        (out,) = Kernel(ca.Function("unloaded_torque", given, [ca.densify(torque)])).run(q, payload, warm, p[core])
        return out

    def positions(self, arms: ArmEquilibria, link: int, reflector: Floats) -> ReflectorPositions:
        """Where reflectors (N, 3), m in their link, are in the base."""
        m = self.statics.n_x
        position, slope, rotation = self._position(arms.q, arms.x[:, :m], link, reflector)
        slopes = [slope @ by[:, :m] for by in (arms.by_parameter, arms.by_wrench, arms.by_state, arms.by_angle)]
        if self.calibrated_out:
            sag, by_sag, _ = self._position(arms.q, arms.x[:, m : 2 * m], link, reflector)
            straight, by_straight, _ = self._position(arms.q, arms.x[:, 2 * m :], link, reflector)
            position = position - sag + straight
            for k, by in ((0, arms.by_parameter), (3, arms.by_angle)):
                slopes[k] = slopes[k] - by_sag @ by[:, m : 2 * m] + by_straight @ by[:, 2 * m :]
        return ReflectorPositions(
            position=position,
            by_parameter=slopes[0],
            by_wrench=slopes[1],
            by_state=slopes[2],
            by_angle=slopes[3],
            rotation=rotation,
        )

    def _position(self, q: Floats, x: Floats, link: int, reflector: Floats) -> tuple[Floats, Floats, Floats]:
        """Position (N, 3), its slopes (N, 3, n_x), and the rotation (N, 3, 3) of the link."""
        frames = self.motion.frames(q, x)
        rotation = frames.rotation[:, link]
        position = frames.origin[:, link] + np.einsum("nij,nj->ni", rotation, reflector)
        return position, self.motion.slopes(frames, link, position), rotation

    def built(self, kind: LoadKind) -> EquilibriumKernel:
        """Arms at rest under loads of one kind, with slopes by all numbers, wrench, memory and angle error."""
        n, s = self.robot.n, self.statics
        q, w, point = (ca.SX.sym(k, m) for k, m in (("q", n), ("w", 6), ("point", 3)))
        state, payload, warm = ca.SX.sym("state", s.n_state), ca.SX.sym("payload"), ca.SX.sym("warm")
        error = ca.SX.sym("error", n if self.tables else 0)
        core, x = ca.SX.sym("p", len(self.tables.core)), ca.SX.sym("x", self.n_x)
        axes = ca.SX.sym("axes", 9 if kind.programmed else 0)
        values = self.unknowns.values(self.tables.whole(core), self.fixed)
        by_angle = error if self.tables else None
        full = [e.memory.bounds(values[e.name]) for e in s.remembering if e.memory]
        posture = s.posture(q, x[: s.n_x])
        new, torque = s.law(
            posture=posture,
            q=q,
            weights=self.weights(values, payload),
            loads=self.acting(kind=kind, posture=posture, w=w, point=point, values=values, path_axes=axes),
            state=state * ca.vertcat(*full) if full else state,
            values=values,
            temperature=warm,
            angle_error=by_angle,
        )
        if self.calibrated_out:
            sag, _ = s.law(
                posture=s.posture(q, x[s.n_x : 2 * s.n_x]),
                q=q,
                weights=self.weights(values, None),
                loads=(),
                state=None,
                values=values,
                temperature=warm,
                angle_error=by_angle,
            )
            new = ca.vertcat(new, sag, s.unloaded(q, values, warm, by_angle))
        inputs = [q, w, point, state, payload, warm, error, core, axes]
        return EquilibriumKernel.of(inputs, wanted=(7, 1, 3, 6), x=x, sweep=new, torque=torque)

    def weights(self, values: Mapping[str, Values], payload: ca.SX | None) -> list[tuple[int, ca.SX, ca.SX]]:
        """Weights (link, point, force): with ``payload`` kg all there are, for None what the controller knows."""
        extra = []
        com = ca.SX(ca.DM(self.tool.com)) if self.tool.com is not None else ca.SX.zeros(3)
        if self.tool.mass:
            extra.append((self.robot.n, ca.SX(self.tool.mass), com))
        if payload is None:
            return self.statics.loads_of_weight(self._gravity, extra)
        extra.append((self.robot.n, payload, com))
        return self.statics.loads_of_weight(self._gravity, extra, values)

    def acting(
        self,
        kind: LoadKind,
        posture: DeflectedArm,
        w: ca.SX,
        point: ca.SX,
        values: Mapping[str, Values],
        path_axes: ca.SX,
    ) -> list[Load]:
        """The load that acts where the sensor shows, or the process says, ``w``; ``path_axes`` (9,) of a process."""
        if kind.programmed:
            given = ProgrammedWrench(w, ca.reshape(path_axes, 3, 3).T)
            return [Load(kind.link, point, acting_wrench(self.statics.effects, given, values), kind.point_link)]
        turn = ca.mtimes(posture.links[-1].rotation, ca.SX(ca.DM(self.tool.rotation)))
        for e in self.statics.effects:
            if e.wrench_reading:
                to_tool = ca.SX.eye(3) if kind.tool_axes else turn.T
                w = e.wrench_reading(ShownWrench(w, to_tool), values[e.name])
        if kind.tool_axes:
            w = ca.vertcat(ca.mtimes(turn, w[:3]), ca.mtimes(turn, w[3:]))
        return [Load(kind.link, point, w, kind.point_link)]


@dataclass(frozen=True)
class SweepKey:
    """What a sweep of the statics is made of but for its free numbers: arms of equal keys share their kernels."""

    robot: Robot
    effects: tuple[Effect, ...]
    given: tuple[tuple[str, str, tuple[float, ...]], ...]
    tool: tuple[tuple[float, ...], ...]
    gravity: tuple[float, ...]
    calibrated_out: bool

    @classmethod
    def of(
        cls,
        robot: Robot,
        effects: tuple[Effect, ...],
        fixed: Mapping[str, Numbers],
        tool: Tool,
        *,
        gravity: Floats,
        calibrated_out: bool,
    ) -> SweepKey:
        """Of a robot with a tool; of ``fixed`` only numbers count that no derivative leads to."""
        given = [
            (e.name, p.name, tuple(map(float, fixed[e.name][p.name])))
            for e in effects
            for p in e.parameters
            if p.fit == "given" and not e.memory  # those of a memory are its rule's alone
        ]
        com = () if tool.com is None else tuple(tool.com)
        held = (tuple(tool.position), tuple(tool.rotation.ravel()), (tool.mass,), com)
        return cls(
            robot=robot,
            effects=effects,
            given=tuple(given),
            tool=held,
            gravity=tuple(map(float, gravity)),
            calibrated_out=calibrated_out,
        )

    def model(self) -> ReadingModel:
        """With all numbers free."""
        n = self.robot.n
        fixed = start_values(self.effects, n)
        for effect, name, numbers in self.given:
            fixed[effect][name] = np.array(numbers)
        position, rotation, (mass,), com = self.tool
        held = Tool(np.array(rotation).reshape(3, 3), np.array(position), mass, np.array(com) if com else None)
        return ReadingModel(
            self.robot,
            every_number(self.effects, n),
            fixed,
            held,
            gravity=np.array(self.gravity),
            calibrated_out=self.calibrated_out,
        )


@lru_cache(maxsize=KEPT)
def equilibrium_kernel(sweep: SweepKey, kind: LoadKind) -> EquilibriumKernel:
    """Built once for all fits of one set of effects."""
    return sweep.model().built(kind)
