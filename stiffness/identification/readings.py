"""Reading model: what a laser tracker would read, on the statics that prediction uses, with free parameters.

A reading is the position of a reflector on some link under a load on some link. One CasADi function per kind of
load gives the arm at rest, with the derivatives of its elastic coordinates by parameters, wrench and memory; it is
evaluated for all readings of that kind at once. Where a reflector then is, is kinematics (statics/point_motion.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers, ShownWrench, Values
from stiffness.identification.angle_tables import AngleTables
from stiffness.identification.unknowns import Unknowns
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.statics.deflected_arm import DeflectedArm
from stiffness.statics.load import Load
from stiffness.statics.point_motion import PointMotion
from stiffness.statics.statics import Statics
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

SWEEPS = 3  # per call, from the coordinates of the call before


@dataclass(frozen=True)
class LoadKind:
    """What loads of one kind have in common: they share one CasADi function.

    Attributes:
        link: the load acts on.
        point_link: the point that its moment is taken about moves with (0: it does not move).
        tool_axes: the wrench is written in the axes of the tool (else of the base).
    """

    link: int
    point_link: int
    tool_axes: bool


@dataclass(frozen=True, repr=False, eq=False)
class ArmLoads:
    """What loads N arms.

    Attributes:
        q: (N, n) rad, commanded.
        wrench: (N, 6) N and N*m, as the sensor shows it. point: (N, 3) m in its link, that the moment is about.
        state: (N, s) memory as a share of its half range, -1 ... 1.
        payload: (N, 1) kg at the tool's centre of mass. warm: (N, 1) K above the reference temperature.
    """

    q: Floats
    wrench: Floats
    point: Floats
    state: Floats
    payload: Floats
    warm: Floats

    def take(self, rows: Index) -> ArmLoads:
        """Some of them, in the given order."""
        return ArmLoads(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def table(self) -> Floats:
        """All numbers of an arm in one row: arms with equal rows deflect alike."""
        return np.concatenate([self.q, self.wrench, self.point, self.state, self.payload, self.warm], axis=1)


@dataclass(frozen=True, repr=False, eq=False)
class ArmEquilibria:
    """N arms at rest under their loads.

    Attributes:
        q: (N, n) rad.
        x: (N, m) elastic coordinates, the start of the next call; behind them those of the sag that a
            controller knows, and of the arm without any load.
        torque: (N, n) N*m.
        by_parameter, by_wrench, by_state, by_angle: (N, m, P), (N, m, 6), (N, m, s), (N, m, n) slopes of ``x``; P
            without the tables of laws of the angle alone, which act by way of ``by_angle``.
    """

    q: Floats
    x: Floats
    torque: Floats
    by_parameter: Floats
    by_wrench: Floats
    by_state: Floats
    by_angle: Floats

    def take(self, rows: Index) -> ArmEquilibria:
        """Some of them, in the given order."""
        return ArmEquilibria(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    @classmethod
    def gathered(cls, parts: Sequence[tuple[Index, ArmEquilibria]]) -> ArmEquilibria:
        """Arms under several kinds of load as one: each part with the rows (k,) that it takes."""
        count = sum(len(rows) for rows, _ in parts)
        out = {}
        for name in (f.name for f in fields(cls)):
            out[name] = np.empty((count, *getattr(parts[0][1], name).shape[1:]))
            for rows, part in parts:
                out[name][rows] = getattr(part, name)
        return cls(**out)


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
        self._kernels: dict[LoadKind, Kernel] = {}

    @property
    def n_x(self) -> int:
        """How many elastic coordinates a reading has."""
        return self.statics.n_x * (3 if self.calibrated_out else 1)

    @cached_property
    def motion(self) -> PointMotion:
        """Its kinematics."""
        return PointMotion(self.statics)

    def equilibria(self, kind: LoadKind, p: Floats, loads: ArmLoads, x: Floats) -> ArmEquilibria:
        """Equilibria under loads of one kind, for parameters ``p`` (P,) as the solver sees them, started from ``x``
        (N, n_x)."""
        if kind not in self._kernels:
            self._kernels[kind] = self._built(kind)
        error = self.tables.error(loads.q, p)
        given = (loads.q, loads.wrench, loads.point, loads.state, loads.payload, loads.warm)
        new, torque, *slopes = self._kernels[kind].run(*given, error, p[self.tables.core], x)
        count, m = len(loads.q), self.n_x
        widths = (len(self.tables.core), 6, self.statics.n_state, error.shape[1])
        by = [np.swapaxes(v.reshape(count, w, m), 1, 2) for v, w in zip(slopes, widths, strict=True)]
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

    def _built(self, kind: LoadKind) -> Kernel:
        n, s = self.robot.n, self.statics
        q, w, point = (ca.SX.sym(k, m) for k, m in (("q", n), ("w", 6), ("point", 3)))
        state, payload, warm = ca.SX.sym("state", s.n_state), ca.SX.sym("payload"), ca.SX.sym("warm")
        error = ca.SX.sym("error", n if self.tables else 0)
        core, x = ca.SX.sym("p", len(self.tables.core)), ca.SX.sym("x", self.n_x)
        values = self.unknowns.values(self.tables.whole(core), self.fixed)
        by_angle = error if self.tables else None
        full = [e.memory.bounds(values[e.name]) for e in s.remembering if e.memory]
        own = state * ca.vertcat(*full) if full else state
        weights = self.weights(values, payload)
        coordinates, torque = x[: s.n_x], ca.SX.zeros(n)
        for _ in range(SWEEPS):
            posture = s.posture(q, coordinates)
            load = self.acting(kind=kind, posture=posture, w=w, point=point, values=values)
            coordinates, torque = s.law(
                posture=posture,
                q=q,
                weights=weights,
                loads=load,
                state=own,
                values=values,
                temperature=warm,
                angle_error=by_angle,
            )
        new_x = coordinates
        if self.calibrated_out:
            sag, declared = x[s.n_x : 2 * s.n_x], self.weights(values, None)
            for _ in range(SWEEPS):
                sag, _ = s.law(
                    posture=s.posture(q, sag),
                    q=q,
                    weights=declared,
                    loads=(),
                    state=None,
                    values=values,
                    temperature=warm,
                    angle_error=by_angle,
                )
            straight = s.unloaded(q, values, warm, by_angle)
            new_x = ca.vertcat(coordinates, sag, straight)
        outputs = [new_x, torque, *(ca.jacobian(new_x, v) for v in (core, w, state, error))]
        dense = [ca.densify(ca.vec(o)) for o in outputs]
        return Kernel(ca.Function("equilibria", [q, w, point, state, payload, warm, error, core, x], dense))

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
        self, kind: LoadKind, posture: DeflectedArm, w: ca.SX, point: ca.SX, values: Mapping[str, Values]
    ) -> list[Load]:
        """The load that acts where the sensor shows ``w``."""
        turn = ca.mtimes(posture.links[-1].rotation, ca.SX(ca.DM(self.tool.rotation)))
        for e in self.statics.effects:
            if e.wrench_reading:
                to_tool = ca.SX.eye(3) if kind.tool_axes else turn.T
                w = e.wrench_reading(ShownWrench(w, to_tool), values[e.name])
        if kind.tool_axes:
            w = ca.vertcat(ca.mtimes(turn, w[:3]), ca.mtimes(turn, w[3:]))
        return [Load(kind.link, point, w, kind.point_link)]
