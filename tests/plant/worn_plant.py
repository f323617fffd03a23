"""An elastic robot with everything that `Wear` can name. The controller knows nothing of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .arm import Arm
from .geometry import Array, rot_z
from .joints import Memory
from .moment import REFERENCE, Moment
from .plant import Plant
from .scene import Load, Scene
from .wear import Situation, Wear
from .worn_scene import WornScene


class WornPlant(Plant):
    """`walk` also takes a Moment per row; without one every moment is the same: time 0, reference temperature."""

    def __init__(self, arm: Arm, wear: Wear, *, gravity_on: bool = True, still: float = 1e-9) -> None:
        super().__init__(
            arm,
            stiffness=wear.stiffness,
            ratio=wear.ratio,
            gap=wear.gap,
            breakaway=wear.breakaway,
            friction=wear.friction,
            still=still,
            gravity_on=gravity_on,
        )
        self.wear = wear
        self.believed = Scene(arm, gravity=False)
        self.scene: WornScene = WornScene(_true(arm, wear), wear, gravity_on)
        self._yield = [np.asarray(f.compliance, dtype=float) for f in wear.flexures]
        self.moment = Moment()

    # ---- what the controller believes

    def nominal(self, q: ArrayLike) -> Array:
        """(4,4) TCP of the arm of the file."""
        self.believed.move(np.asarray(q, dtype=float))
        return self.believed.tcp()

    def inverse(self, pose: Array, seed: ArrayLike) -> Array:
        """As Plant.inverse, on the arm of the file."""
        worn, self.scene = self.scene, self.believed  # type: ignore[assignment]
        try:
            return super().inverse(pose, seed)
        finally:
            self.scene = worn

    # ---- what the arm does

    def _now(self, moment: Moment | None) -> None:
        self.moment = moment or Moment()
        self.scene.warm(self.moment.temperature - REFERENCE)

    def _more(self, torque: Array, q: Array, angle: Array, memory: Memory) -> Array:
        here = Situation(torque, q, angle, memory.direction, self.moment)
        return sum((law(here) for law in self.wear.laws), np.zeros(self.arm.n))

    def equilibrium(self, q: Array, loads: Sequence[Load], memory: Memory, guess: Array | None = None) -> Array:
        """As Plant.equilibrium."""
        self.scene.relax(q)
        return super().equilibrium(q, loads, memory, guess)

    def _row(self, q: Array, loads: Sequence[Load], memory: Memory, z: Array) -> dict[str, Array]:
        n = self.arm.n
        torque, links = self.scene.forces(loads)[:n], self.scene.links()
        nominal = self.nominal(q)
        rigid = self.believed.links()
        return {
            "q_act": q + z[:n],
            "elastic": z[n:],
            "torque": torque,
            "play": memory.play,
            "direction": memory.direction,
            "links": links,
            "rigid": rigid,
            "sag": rigid,
            "tcp": links[n] @ self.arm.tool.pose,
            "nominal": nominal,
        }


def _true(arm: Arm, wear: Wear) -> Arm:
    """The arm whose joints stand `zeros` beside what they show."""
    if not np.any(wear.zeros):
        return arm
    before = arm.before.copy()
    for k, zero in enumerate(wear.zeros):
        # a turn about the joint's own axis before the joint; axes of robot files are +-z
        sign = float(arm.axis[k] @ [0.0, 0.0, 1.0])
        if abs(abs(sign) - 1) > 1e-12:
            raise ValueError(f"{arm.name}: joint {k + 1} does not turn about z")
        before[k] = before[k] @ rot_z(sign * zero)
    return replace(arm, before=before)
