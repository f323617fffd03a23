"""Textbook rigid-body motion along a day in the lab: what small turns and shifts do to a reading, by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .cell_design import CELLS, Cell, design, form
from .geometry import Array
from .lab import Notes, measure
from .sizing import QUIET
from .wear import Wear
from .worn_plant import WornPlant

G = 9.80665


@dataclass(frozen=True)
class Day:
    """A few set-ups, measured without noise on any cell of one arm. Rows of arrays are readings."""

    arm: str = "abb-irb6600-175-255"
    setups: int = 7
    seed: int = 5

    @property
    def cell(self) -> Cell:
        return CELLS[self.arm]

    def measured(self, wear: Wear) -> Notes:
        """Notes of the day with this cell, tracker and sensor included."""
        plan = design(self.cell, self.setups, self.seed)
        plant = WornPlant(self.cell.arm, wear)
        shape = replace(form(self.cell, plan, self.seed), length="m", angle="rad", again=1)
        return measure(
            plant, plan, self.cell.targets, noise=QUIET, form=shape, tracker=wear.tracker, sensor=wear.sensor
        )

    @cached_property
    def healthy(self) -> Notes:
        return self.measured(self.cell.healthy)

    def column(self, *names: str, notes: Notes | None = None) -> Array:
        """(N,c) of the file."""
        return np.array([[row[c] for c in names] for row in (notes or self.healthy).rows], dtype=float)

    def change(self, wear: Wear) -> Array:
        """(N,3) m: what the tracker shows of this cell minus what it shows of the healthy one."""
        return self.column(*"xyz", notes=self.measured(wear)) - self.column(*"xyz")

    @cached_property
    def point(self) -> Array:
        """(N,3) m, where the reflectors are."""
        return self.healthy.truth.position

    @cached_property
    def on(self) -> Array:
        """(N,) the link of the reflector read."""
        return np.array([self.cell.targets[t].link for t in self.healthy.truth.target])

    @cached_property
    def frames(self) -> Array:
        """(N,n+1,4,4) link frames."""
        return self.healthy.truth.walk.links[self.healthy.truth.at]

    @cached_property
    def q(self) -> Array:
        return self.healthy.truth.walk.q_cmd[self.healthy.truth.at]

    @cached_property
    def direction(self) -> Array:
        """(N,n) last rotation."""
        return self.column(*(f"approach{k}" for k in range(1, 7)))

    def axis(self, k: int) -> tuple[Array, Array]:
        """Origin (N,3) and direction (N,3) of joint k."""
        joint = self.frames[:, k - 1] @ self.cell.arm.before[k - 1]
        return joint[:, :3, 3], joint[:, :3, :3] @ self.cell.arm.axis[k - 1]

    def at(self, link: int, point: Array) -> Array:
        """(N,3) m, a point of a link."""
        return (self.frames[:, link] @ np.append(point, 1.0))[:, :3]

    def turned(self, k: int, angle: Array) -> Array:
        """(N,3) m: displacement of the points read when joint k turns by (N,) rad more."""
        origin, axis = self.axis(k)
        moved = np.cross(axis, self.point - origin) * np.broadcast_to(angle, len(axis))[:, None]
        return np.where((self.on >= k)[:, None], moved, 0.0)

    def loads(self, link: int) -> list[tuple[Array, Array]]:
        """Forces (N,3) N and where they pull (N,3) m: weights of `link` and beyond, and the load with its moment."""
        arm = self.cell.arm
        down = np.array([0.0, 0.0, -G])
        out = [
            (np.broadcast_to(arm.mass[k - 1] * down, self.point.shape), self.at(k, arm.com[k - 1]))
            for k in range(max(link, 1), 7)
        ]
        out.append((np.broadcast_to(arm.tool.mass * down, self.point.shape), self.at(6, np.asarray(arm.tool.com))))
        return out

    def wrench(self, link: int, about: Array) -> tuple[Array, Array]:
        """Force (N,3) and moment (N,3) about points (N,3) of all that hangs on `link` and beyond, process included."""
        truth = self.healthy.truth
        force, moment = truth.wrench[:, :3].copy(), truth.wrench[:, 3:].copy()
        moment += np.cross(truth.point - about, force)
        for pull, where in self.loads(link):
            force += pull
            moment += np.cross(where - about, pull)
        return force, moment

    def torque(self, k: int) -> Array:
        """(N,) N*m about joint k, of weights and load."""
        origin, axis = self.axis(k)
        return np.sum(axis * self.wrench(k, origin)[1], axis=1)
