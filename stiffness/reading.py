"""What a laser tracker would read: the same statics as prediction uses, with parameters left free.

A reading is the position of a reflector on some link under a load on some link. One CasADi function per kind of
reading gives position, torques, and the derivatives by parameters and by the wrench; it is run over all
readings of that kind at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers, Values
from stiffness.kernel import Kernel
from stiffness.predict import Tool
from stiffness.robot import Robot
from stiffness.statics import Load, Posture, Statics
from stiffness.unknowns import Unknowns

Floats = npt.NDArray[np.float64]

SWEEPS = 3  # per call, from the coordinates of the call before


@dataclass(frozen=True)
class Kind:
    """What readings of one kind share.

    Attributes:
        link: the reflector sits on.
        load_link: the load acts on.
        point_link: the point that its moment is taken about moves with (0: it does not move).
        tool_axes: the wrench is written in the axes of the tool (else of the base).
    """

    link: int
    load_link: int
    point_link: int
    tool_axes: bool


@dataclass(frozen=True, repr=False)
class Read:
    """Predicted readings of one kind.

    Attributes:
        x: (N, m) elastic coordinates, the start of the next call.
        torque: (N, n) N*m.
        position: (N, 3) m, base.
        by_parameter: (N, 3, P).
        by_wrench: (N, 3, 6).
        rotation: (N, 3, 3) of the reflector's link: derivative by the reflector's place.
    """

    x: Floats
    torque: Floats
    position: Floats
    by_parameter: Floats
    by_wrench: Floats
    rotation: Floats


class Reader:
    """Predicts readings of one robot with one tool, parameters free.

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
        self._kernels: dict[Kind, Kernel] = {}

    @property
    def n_x(self) -> int:
        """How many elastic coordinates a reading has."""
        return self.statics.n_x * (2 if self.calibrated_out else 1)

    @cached_property
    def _remembering(self) -> tuple[str, ...]:
        return tuple(e.name for e in self.statics.remembering)

    def read(
        self,
        kind: Kind,
        p: Floats,
        q: Floats,
        wrench: Floats,
        point: Floats,
        reflector: Floats,
        state: Floats,
        payload: Floats,
        warm: Floats,
        x: Floats,
    ) -> Read:
        """Readings of one kind.

        Args:
            p: (P,) parameters as the solver sees them.
            q: (N, n) rad. wrench: (N, 6). point: (N, 3) m in its link. reflector: (N, 3) m in its link.
            state: (N, m) memory as a share of its half range, -1 ... 1.
            payload: (N, 1) kg at the tool's centre of mass. warm: (N, 1) K above the reference temperature.
            x: (N, n_x) elastic coordinates to start from.
        """
        out = self._kernel(kind).run(q, wrench, point, reflector, state, payload, warm, p, x)
        new_x, torque, position, by_p, by_w, rotation = out
        return Read(
            new_x,
            torque,
            position,
            np.swapaxes(by_p.reshape(len(q), len(p), 3), 1, 2),
            np.swapaxes(by_w.reshape(len(q), 6, 3), 1, 2),
            np.swapaxes(rotation.reshape(len(q), 3, 3), 1, 2),
        )

    def _kernel(self, kind: Kind) -> Kernel:
        if kind not in self._kernels:
            self._kernels[kind] = self._built(kind)
        return self._kernels[kind]

    def _built(self, kind: Kind) -> Kernel:
        n, s = self.robot.n, self.statics
        q, w, point, reflector = (ca.SX.sym(k, m) for k, m in (("q", n), ("w", 6), ("point", 3), ("reflector", 3)))
        state, payload, warm = ca.SX.sym("state", s.n_state), ca.SX.sym("payload"), ca.SX.sym("warm")
        p, x = ca.SX.sym("p", len(self.unknowns)), ca.SX.sym("x", self.n_x)
        values = self.unknowns.values(p, self.fixed)
        full = [e.memory.bounds(values[e.name]) for e in s.remembering if e.memory]
        rad = state * ca.vertcat(*full) if full else state
        declared = self._weights(values, None)
        weights = self._weights(values, payload)
        coordinates, torque = x[: s.n_x], ca.SX.zeros(n)
        for _ in range(SWEEPS):
            posture = s.posture(q, coordinates)
            load = self._load(kind, posture, w, point)
            coordinates, torque = s.law(posture, q, weights, load, rad, values, warm)
        position = s.posture(q, coordinates).links[kind.link].at(reflector)
        rotation = s.posture(q, coordinates).links[kind.link].rotation
        new_x = coordinates
        if self.calibrated_out:
            sag = x[s.n_x :]
            for _ in range(SWEEPS):
                sag, _ = s.law(s.posture(q, sag), q, declared, (), None, values, warm)
            rigid = s.posture(q, ca.SX.zeros(s.n_x)).links[kind.link].at(reflector)
            position = position - s.posture(q, sag).links[kind.link].at(reflector) + rigid
            new_x = ca.vertcat(coordinates, sag)
        outputs = [new_x, torque, position, ca.jacobian(position, p), ca.jacobian(position, w), rotation]
        dense = [ca.densify(ca.vec(o)) for o in outputs]
        return Kernel(ca.Function("reading", [q, w, point, reflector, state, payload, warm, p, x], dense))

    def _weights(self, values: Mapping[str, Values], payload: ca.SX | None) -> list[tuple[int, ca.SX, ca.SX]]:
        extra = []
        com = ca.SX(ca.DM(self.tool.com)) if self.tool.com is not None else ca.SX.zeros(3)
        if self.tool.mass:
            extra.append((self.robot.n, ca.SX(self.tool.mass), com))
        if payload is None:
            return self.statics.loads_of_weight(self._gravity, extra)
        extra.append((self.robot.n, payload, com))
        return self.statics.loads_of_weight(self._gravity, extra, values)

    def _load(self, kind: Kind, posture: Posture, w: ca.SX, point: ca.SX) -> list[Load]:
        if kind.tool_axes:
            turn = ca.mtimes(posture.links[-1].rotation, ca.SX(ca.DM(self.tool.rotation)))
            w = ca.vertcat(ca.mtimes(turn, w[:3]), ca.mtimes(turn, w[3:]))
        return [Load(kind.load_link, point, w, kind.point_link)]
