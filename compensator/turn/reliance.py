"""Reliance: how far a compensation relies on its model, posture by posture: predicted deflection, its standard
deviation, and what a joint that reverses moves the TCP by.

To first order a joint law that is off by delta moves the TCP by the lever of the joint times delta. The standard
deviations are those of the model; where it has none, SHARE of every number of the base model. Which flank a joint
rests on is taken to be wrong once in sixteen times: its standard deviation is DOUBT of what lies between the flanks.
Effects that are no joint laws are left out, and where the controller takes the sag off, what is wrong about that.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.cell.equipped_arm import EquippedArm
from compensator.path.planned_path import PlannedPath
from compensator.turn.turn_grid import CELLS, TurnGrid
from stiffness.effects.effect import Effect
from stiffness.kinematics.jacobian import geometric_jacobian
from stiffness.memory.preload import base_stiffness
from stiffness.memory.state_columns import state_columns
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from stiffness.statics.predictor import Predictor
from stiffness.statics.tool import Tool

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

SHARE = 0.1  # of every number of the base model, where no standard deviation is given: as compensator check has it
DOUBT = 0.25  # of what lies between two flanks: the wrong one in one case of sixteen
EDGE = 0.01  # m: of a cutter from its axis; a joint in line with the tool moves nothing else
_FAR = 1.0  # rad: a move that crosses every gap


@dataclass(frozen=True, repr=False, eq=False)
class Reliance:
    """Along M poses at T turns; NaN where the grid is not free.

    Attributes:
        deflection: (M, T) m, predicted size at neutral joint states.
        sd: (M, T) m, of the deflection, flanks included.
        crossing: (M, T, n) m by which the cutting edge moves where a joint reverses; 0 where its load holds the flank.
        lever: (M, T, n) m, way of the cutting edge for each rad of a joint.
        give: (M, T, n) rad, by which a correction moves each joint back.
        gap: (n,) rad, the largest way between the flanks of each joint; 0 where it has none.
    """

    deflection: Floats
    sd: Floats
    crossing: Floats
    lever: Floats
    give: Floats
    gap: Floats

    def __repr__(self) -> str:
        return f"Reliance({self.sd.shape[0]} poses x {self.sd.shape[1]} turns)"


def tool_reliances(arm: EquippedArm) -> dict[int, ToolReliance]:
    """Of every tool, by its number: made once where many grids are looked at."""
    return {tool: ToolReliance.of(arm, predictor) for tool, predictor in arm.predictors.items()}


def reliance(
    arm: EquippedArm,
    path: PlannedPath,
    grid: TurnGrid,
    wrench: Floats,
    *,
    tools: Mapping[int, ToolReliance] | None = None,
) -> Reliance:
    """The fields of a grid.

    Args:
        wrench: (N, 6) of the process along ``path``, on the robot, base axes, about the TCP; it does not turn with
            the tool.
        tools: as ``tool_reliances``, where they are made.
    """
    n = arm.robot.n
    deflection, sd = np.full(grid.status.shape, np.nan), np.full(grid.status.shape, np.nan)
    crossing, lever, give = (np.full((*grid.status.shape, n), np.nan) for _ in range(3))
    gap, where = np.zeros(n), np.argwhere(grid.free)
    number = path.toolpath.tool[grid.rows[where[:, 0]]]
    for tool, at in (tool_reliances(arm) if tools is None else tools).items():
        cells = where if arm.tools.any_number else where[number == tool]
        for begin in range(0, len(cells), CELLS):
            i, k = cells[begin : begin + CELLS].T
            rows = grid.rows[i]
            found = at.in_parts(grid.q[i, k], wrench[rows], path.tcp.take(rows).origin)
            deflection[i, k], sd[i, k], lever[i, k], give[i, k] = found[:4]
            crossing[i, k] = found[2] * found[4]
            gap = np.maximum(gap, found[4].max(axis=0, initial=0.0))
    return Reliance(deflection=deflection, sd=sd, crossing=crossing, lever=lever, give=give, gap=gap)


def left_out(arm: EquippedArm) -> list[str]:
    """Names of effects whose standard deviations take no part."""
    return [e.name for e in arm.effects if e.joint is None and arm.model.sd.get(e.name)]


def assumed(arm: EquippedArm) -> bool:
    """Whether the model has no standard deviation that takes part, so that SHARE is assumed."""
    return not any(arm.model.sd.get(e.name) for e in arm.effects if e.joint is not None and e.memory is None)


@dataclass(frozen=True, eq=False)
class ToolReliance:
    """One tool: the arm as the model has it, with each uncertain parameter moved, and the levers of its joints."""

    arm: EquippedArm
    predictor: Predictor
    moved: tuple[Predictor, ...]
    levers: Kernel

    @classmethod
    def of(cls, arm: EquippedArm, predictor: Predictor) -> ToolReliance:
        """Of an arm with one of its tools."""
        return cls(arm, predictor, tuple(_moved(arm, predictor)), Kernel(_levers(arm.robot, predictor.tool)))

    def of_postures(self, q: Floats, wrench: Floats, nominal: Floats) -> tuple[Floats, Floats, Floats]:
        """Deflection (K,), its standard deviation (K,), crossings (K, n), m.

        Args:
            q: (K, n) rad. wrench: (K, 6) base axes, about the TCP. nominal: (K, 3) m, the TCP without deflection.
        """
        deflection, sd, lever, _, between = self.in_parts(q, wrench, nominal)
        return deflection, sd, lever * between

    def in_parts(self, q: Floats, wrench: Floats, nominal: Floats) -> tuple[Floats, ...]:
        """Deflection (K,), its standard deviation (K,), levers (K, n), m; give and ways between flanks (K, n) rad.

        Args:
            q, wrench, nominal: as in ``of_postures``.
        """
        m = self.arm.unknown_state.low.shape[-1]
        still = np.zeros((len(q), m))
        found = self.predictor.forward(q, wrench, still)
        square, process = self.levers.run(q, wrench)
        torque = process if self.predictor.calibrated_out else found.torque
        here = self.predictor.joint_deflection(q, torque, still)
        variance = np.zeros(len(q))
        for other in self.moved:
            off = other.joint_deflection(q, torque, still) - here
            variance += np.sum(square * off**2, axis=1)
        between = self._between_flanks(q, found.torque)
        variance += DOUBT**2 * np.sum(square * between**2, axis=1)
        size = np.linalg.norm(found.position - nominal, axis=1)
        return size, np.sqrt(variance), np.sqrt(square + EDGE**2), here, between

    def _between_flanks(self, q: Floats, torque: Floats) -> Floats:
        """(K, n) rad between a joint that came from below and one that came from above, under this torque."""
        arm = self.arm
        columns = state_columns(arm.effects, arm.robot.n)
        if not columns:
            return np.zeros_like(q)
        stiffness = base_stiffness(arm.effects, arm.values, arm.robot.n)
        up, down = (np.zeros((len(q), arm.unknown_state.low.shape[-1])) for _ in range(2))
        for e in arm.effects:
            if e.memory:
                for state, move in ((up, _FAR), (down, -_FAR)):
                    clamp = e.memory.rule(np.full_like(q, move), torque, arm.values[e.name], stiffness)
                    state[:, columns[e.name]] = np.clip(clamp.shift, clamp.low, clamp.high)
        law = self.predictor.joint_deflection
        return np.asarray(np.abs(law(q, torque, up) - law(q, torque, down)))


def _moved(arm: EquippedArm, predictor: Predictor) -> Iterator[Predictor]:
    """The arm with each parameter of its joint laws moved by its standard deviation, at all joints together."""
    none_known = assumed(arm)
    for e in arm.effects:
        if e.joint is None or e.memory is not None:  # of what is remembered DOUBT is the measure
            continue
        for name, sd in _deviations(arm, e, none_known).items():
            values = arm.values[e.name]
            yield predictor.with_values({e.name: {**values, name: values[name] + sd}})


def _deviations(arm: EquippedArm, e: Effect, none_known: bool) -> dict[str, Floats]:
    if none_known:
        return {name: SHARE * v for name, v in arm.values[e.name].items()} if e.is_base else {}
    given = arm.model.sd.get(e.name, {})
    found = {name: np.nan_to_num(np.asarray(sd, dtype=float), posinf=0.0) for name, sd in given.items()}
    return {name: sd for name, sd in found.items() if np.any(sd > 0)}


def _levers(robot: Robot, tool: Tool) -> ca.Function:
    """(q (n) rad, wrench (6) about the TCP) -> squares (n) m2 of the way of the TCP per rad of each joint, and the
    torque (n) N*m of the wrench."""
    q, wrench = ca.SX.sym("q", robot.n), ca.SX.sym("wrench", 6)
    rotation, origin = robot.flange_symbolic(q)
    tip = origin + ca.mtimes(rotation, ca.DM(np.asarray(tool.position)))
    jacobian = geometric_jacobian(rotation, tip, q)
    outputs = [ca.sum1(jacobian[:3, :] ** 2).T, ca.mtimes(jacobian.T, wrench)]
    return ca.Function("levers", [q, wrench], [ca.densify(e) for e in outputs])
