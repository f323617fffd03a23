"""Uncertainty along a path of effects that were identified over part of a joint's range only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.solve.command_bounds import unidentified_loads
from compensator.solve.compensation import Compensation
from stiffness.effects.effect import Effect, Numbers
from stiffness.numerics.kernel import Kernel
from stiffness.robot.robot import Robot
from toolpaths.finding import NOTE, Finding

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Index = npt.NDArray[np.intp]

UNLEARNED = 0.9  # share of the standard deviation without any data, from which on an angle counts as not learned
NEGLIGIBLE = 0.1  # share of its own standard deviation that a value there may have
PROBE = np.radians(0.5)  # between two poses the joint's angles are looked at in steps of this


@dataclass(frozen=True)
class NotLearned:
    """Angles of a path at which an effect was not identified.

    Attributes:
        effect: its name. joint: counted from 1.
        low, high: rad, the commanded angles there.
        poses: how many, ``of`` so many. sd: m, the largest standard deviation of the TCP there.
    """

    effect: str
    joint: int
    low: float
    high: float
    poses: int
    of: int
    sd: float

    @property
    def share(self) -> float:
        """Of all poses."""
        return self.poses / max(self.of, 1)

    def as_dict(self) -> dict[str, Any]:
        """As in the JSON report."""
        return {
            "effect": self.effect,
            "joint": self.joint,
            "from_deg": float(np.degrees(self.low)),
            "to_deg": float(np.degrees(self.high)),
            "poses": self.poses,
            "share_of_poses": self.share,
            "sd_mm": self.sd * 1e3,
        }

    def __str__(self) -> str:
        low, high = (f"{np.degrees(a):.1f}" for a in (self.low, self.high))
        where = f"at {low} deg" if low == high else f"between {low} and {high} deg"
        share = f"{100 * self.share:.3g} % of the poses"
        return (
            f"{self.effect} of joint {self.joint} was not learned {where}: it contributes nothing there ({share}), and "
            f"the TCP is uncertain by {self.sd * 1e3:.2g} mm (one sd) more"
        )


class AngleUncertainty:
    """Standard deviation that ``effects`` with these values leave at joints and TCP, angle by angle."""

    def __init__(
        self, robot: Robot, effects: Sequence[Effect], values: Mapping[str, Numbers], sd: Mapping[str, Numbers]
    ) -> None:
        self.robot, self.values, self.sd = robot, values, sd
        self.effects = tuple(e for e in effects if e.angle_sd)

    def __repr__(self) -> str:
        return f"AngleUncertainty({', '.join(e.name for e in self.effects) or 'nothing'})"

    def angles(self, effect: Effect, q: Floats) -> Floats:
        """(N, n) rad: standard deviation of every joint at commanded angles (N, n)."""
        if effect.angle_sd is None:
            return np.zeros_like(q)
        return effect.angle_sd(q, self.values[effect.name], self.sd.get(effect.name, {}))

    def at_tcp(self, q: Floats, tcp: Floats) -> Floats:
        """(N,) m: root sum square over effects and joints; ``tcp`` (N, 3) m in the flange."""
        if not self.effects:
            return np.zeros(len(q))
        variance = sum(self.angles(e, q) ** 2 for e in self.effects)
        return np.asarray(np.sqrt(np.sum(levers(self.robot, q, tcp) ** 2 * variance, axis=1)))

    def not_learned(self, q: Floats, tcp: Floats) -> list[NotLearned]:
        """Angles of poses that no reading covered, by effect, joint and angle."""
        if not self.effects or not len(q):
            return []
        lever = levers(self.robot, q, tcp)
        return [found for e in self.effects for found in self._of(e, q, self.angles(e, q), lever)]

    def _of(self, effect: Effect, q: Floats, own: Floats, lever: Floats) -> list[NotLearned]:
        out = []
        unlearned, sd = self._unlearned(effect, q, own), own * lever
        for j in np.flatnonzero(unlearned.any(axis=0)).tolist():
            for rows in self._stretches(effect, j, q, unlearned[:, j]):
                angle = q[rows, j]
                out.append(
                    NotLearned(
                        effect=effect.name, joint=j + 1, low=float(angle.min()), high=float(angle.max()),
                        poses=len(rows), of=len(q), sd=float(sd[rows, j].max()),
                    )
                )  # fmt: skip
        return out

    def _unlearned(self, effect: Effect, q: Floats, own: Floats) -> Bools:
        """(N, n) where data hardly reduced the prior standard deviation and the effect is negligible.

        Args:
            own: (N, n) rad, its ``angles``.
        """
        if effect.angle_sd is None:
            return np.zeros(q.shape, dtype=bool)
        n = self.robot.n
        unseen = {p.name: np.full(p.count(n), p.prior_sd) for p in effect.parameters if p.extra and p.prior_sd}
        prior = effect.angle_sd(q, effect.neutral(n), unseen)
        unlearned = (prior > 0) & (own >= UNLEARNED * prior)
        rows = np.flatnonzero(unlearned.any(axis=1))
        if effect.name in self._errors and len(rows):
            (error,) = self._errors[effect.name].run(q[rows])
            unlearned[rows] &= np.abs(error) <= NEGLIGIBLE * own[rows]
        return unlearned

    @cached_property
    def _errors(self) -> dict[str, Kernel]:
        """By effect: joint angles (n,) rad -> what it adds to them (n,) rad."""
        out = {}
        for effect in self.effects:
            if effect.angle:
                symbol = ca.SX.sym("q", self.robot.n)
                values = {k: ca.SX(ca.DM(v)) for k, v in self.values[effect.name].items()}
                error = ca.densify(effect.angle(symbol, values))
                out[effect.name] = Kernel(ca.Function("errors", [symbol], [error]))
        return out

    def _stretches(self, effect: Effect, joint: int, q: Floats, unlearned: Bools) -> list[Index]:
        """Poses of every stretch of angles that was not learned, in the order of the angle."""
        rows = np.flatnonzero(unlearned)
        rows = rows[np.argsort(q[rows, joint], kind="stable")]
        angle = q[rows, joint]
        probes = np.zeros((int(np.ceil((angle[-1] - angle[0]) / PROBE)), self.robot.n))
        probes[:, joint] = angle[0] + PROBE * np.arange(len(probes))
        learned = ~self._unlearned(effect, probes, self.angles(effect, probes))[:, joint]
        ends = np.r_[probes[learned, joint], q[~unlearned, joint]]
        cuts = np.unique(np.searchsorted(angle, ends))
        return [part for part in np.split(rows, cuts) if len(part)]


def levers(robot: Robot, q: Floats, tcp: Floats) -> Floats:
    """(N, n) m/rad: how far a turn of every joint moves the TCP, (N, 3) m in the flange."""
    angle, point = ca.SX.sym("q", robot.n), ca.SX.sym("tcp", 3)
    rotation, origin = robot.flange_symbolic(angle)
    slope = ca.jacobian(origin + ca.mtimes(rotation, point), angle)
    kernel = Kernel(ca.Function("levers", [angle, point], [ca.densify(ca.sqrt(ca.sum1(slope**2)).T)]))
    return kernel.run(np.ascontiguousarray(q), tcp)[0]


@dataclass(frozen=True, repr=False)
class OpenAngles:
    """What the effects of a model leave open at the cutting poses of a path.

    Attributes:
        not_learned: angles that the path goes through and no reading told of.
        sd: (M,) m at the TCP of each cutting pose, one standard deviation.
        loads: warnings of loads on joints whose stiffness is not identified.
    """

    not_learned: tuple[NotLearned, ...]
    sd: Floats
    loads: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        return f"OpenAngles({len(self.not_learned)} not learned, {len(self.sd)} poses)"

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The warnings, and a note for each stretch of angles."""
        return self.loads + tuple(Finding(NOTE, "", str(part)) for part in self.not_learned)


def open_angles(c: Compensation, q: Floats) -> OpenAngles:
    """What is left open where a path cuts, with the commands ``q`` (N, n) rad."""
    arm, cut = c.job.arm, c.cutting
    unsure = AngleUncertainty(arm.robot, arm.effects, arm.values, arm.model.sd)
    loads = tuple(unidentified_loads(c))
    if not unsure.effects:
        return OpenAngles((), np.zeros(int(cut.sum())), loads)
    number = c.path.toolpath.tool[cut]
    tcp = np.array([arm.tools.tool(int(k)).position for k in number]).reshape(-1, 3)
    return OpenAngles(tuple(unsure.not_learned(q[cut], tcp)), unsure.at_tcp(q[cut], tcp), loads)
