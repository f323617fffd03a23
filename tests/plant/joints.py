"""Joint laws and the memory of flanks: plain Python, by the rules of the physics page, nothing shared.

Deflection of joint i = play_i + tau_i / K_i (K_i times ratio_i when tau_i is against the last rotation)
+ hardening_i(tau_i). tau is the generalised force of gravity and environment on the joint.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .geometry import Array

# (torque (n,) N*m, actual angle (n,) rad) -> added deflection (n,) rad
Extra = Callable[[Array, Array], Array]


def per_joint(value: ArrayLike | None, n: int, default: float) -> Array:
    """(n,) from None, a number or n numbers."""
    return np.array(np.broadcast_to(default if value is None else np.asarray(value, dtype=float), (n,)))


@dataclass(frozen=True)
class Memory:
    """What the joints remember of the path so far."""

    command: Array  # (n,) rad, last commanded angles
    turned_at: Array  # (n,) rad, command at which the last rotation was noticed
    direction: Array  # (n,) -1, 0 (unknown), +1: last rotation
    play: Array  # (n,) rad in [-gap/2, +gap/2]: where the link sits in its gap
    anchor: Array | None = None  # (n,) or, of several bearings side by side, (b,n) rad: deflection at which the dry
    # friction pulls nowhere; NaN, None: at rest

    @classmethod
    def fresh(cls, command: ArrayLike) -> Memory:
        """Nothing known: middle of the gap, no direction."""
        q = np.array(command, dtype=float)
        return cls(q, q.copy(), np.zeros(len(q)), np.zeros(len(q)))

    @classmethod
    def settled(
        cls, command: ArrayLike, direction: ArrayLike, gap: ArrayLike, side_sign: float = 1.0
    ) -> Memory:
        """After long moves in `direction` (n,)."""
        s = np.array(direction, dtype=float)
        return replace(cls.fresh(command), direction=s, play=side_sign * s * np.asarray(gap, dtype=float) / 2)


@dataclass(frozen=True)
class Friction:
    """A dry bearing on the link's side (Jenkins element): a spring `grip` to the ground that slips at `slip`.

    The drive, k rad per N*m, holds torque minus what the bearing holds: k d = tau - T, T = grip (d - anchor)
    within +-slip. So friction shifts the joint by T / k, at most slip / k, and T stays when the load has gone.
    lag: the link is dragged by the motor and stops short; False: the bearing is shaken loose after each move.
    """

    slip: Array  # (n,) N*m
    grip: Array  # (n,) grip over the stiffness of the drive
    lag: bool = True

    def torque(self, load: Array, stiffness: Array, anchor: Array | None) -> Array:
        """(n,) N*m that the bearing takes of a load."""
        if anchor is None:
            return np.zeros(len(load))
        stuck = self.grip / (1 + self.grip) * (load - stiffness * anchor)
        return np.clip(np.where(np.isnan(anchor), 0.0, stuck), -self.slip, self.slip)

    def dragged(self, load: Array, stiffness: Array, anchor: Array | None) -> Array:
        """(n,) rad: the anchor after the load has done what it can."""
        held = self.torque(load, stiffness, anchor)
        out: Array = (load - held) / stiffness - held / (self.grip * stiffness)
        return out

    def carried(self, memory: Memory, command: Array, still: float) -> Array | None:
        """(n,) rad: the anchor, which stays where it is, seen from a motor that has moved."""
        if memory.anchor is None:
            return None
        move = command - memory.command
        return np.where(np.abs(move) > still, memory.anchor - move if self.lag else np.nan, memory.anchor)


@dataclass(frozen=True)
class Bearings:
    """Several dry bearings side by side on the link (Iwan's parallel model): each a spring to the ground that slips.

    k d = tau - sum of T_b, T_b = grip_b k (d - anchor_b) within +-slip_b: solved for d by bisection, which needs no
    more than that the right side falls as d grows.
    """

    slip: Array  # (b,n) N*m
    grip: Array  # (b,n) over the stiffness of the drive

    def pulls(self, d: Array, stiffness: Array, anchor: Array | None) -> Array:
        """(b,n) N*m that the bearings take at a deflection."""
        if anchor is None:
            return np.zeros_like(self.slip)
        return np.clip(np.where(np.isnan(anchor), 0.0, self.grip * stiffness * (d - anchor)), -self.slip, self.slip)

    def torque(self, load: Array, stiffness: Array, anchor: Array | None) -> Array:
        """(n,) N*m that they take of a load together."""
        out: Array = self.pulls(self._rest(load, stiffness, anchor), stiffness, anchor).sum(axis=0)
        return out

    def _rest(self, load: Array, stiffness: Array, anchor: Array | None) -> Array:
        most = self.slip.sum(axis=0)
        low, high = (load - most) / stiffness, (load + most) / stiffness
        for _ in range(80):
            middle = (low + high) / 2
            over = stiffness * middle + self.pulls(middle, stiffness, anchor).sum(axis=0) > load
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        out: Array = (low + high) / 2
        return out

    def dragged(self, load: Array, stiffness: Array, anchor: Array | None) -> Array:
        """(b,n) rad: the anchors after the load has done what it can."""
        d = self._rest(load, stiffness, anchor)
        with np.errstate(invalid="ignore", divide="ignore"):
            stretch = self.pulls(d, stiffness, anchor) / (self.grip * stiffness)
        return np.where(self.slip > 0, d - stretch, d)

    def carried(self, memory: Memory, command: Array, still: float) -> Array | None:
        """(b,n) rad: the anchors, which stay where they are, seen from a motor that has moved."""
        if memory.anchor is None:
            return None
        move = command - memory.command
        return np.where(np.abs(move) > still, memory.anchor - move, memory.anchor)


@dataclass(frozen=True)
class Joints:
    """The laws of all n joints."""

    stiffness: Array  # (n,) N*m/rad; inf is rigid
    ratio: Array  # (n,) non-loaded stiffness / pre-loaded stiffness
    gap: Array  # (n,) rad, total lost motion
    breakaway: Array  # (n,) N*m; a torque beyond it carries the link to its own flank; inf: never
    side_sign: float = 1.0  # +1: after a move in direction s the link rests on side s
    hardening: Extra | None = None
    still: float = 1e-9  # rad: a smaller commanded move is no turn
    friction: Friction | Bearings | None = None

    def deflection(self, torque: Array, angle: Array, memory: Memory) -> Array:
        """(n,) rad: all of it, play and dry friction included."""
        held = 0.0 if self.friction is None else self.friction.torque(torque, self.stiffness, memory.anchor)
        return memory.play + self.elastic(torque - held, angle, memory.direction)

    def elastic(self, torque: Array, angle: Array, direction: Array) -> Array:
        """(n,) rad: everything but the play."""
        softer = np.where(torque * direction < 0, self.ratio, 1.0)
        out: Array = torque / (self.stiffness * softer)
        return out if self.hardening is None else out + self.hardening(torque, angle)

    def turned(self, memory: Memory, command: Array) -> Memory:
        """The memory after a commanded move, before any torque is looked at."""
        move = command - memory.turned_at
        moved = np.abs(move) > self.still
        play = memory.play + self.side_sign * (command - memory.command)
        return Memory(
            command=command.copy(),
            turned_at=np.where(moved, command, memory.turned_at),
            direction=np.where(moved, np.sign(move), memory.direction),
            play=np.clip(play, -self.gap / 2, self.gap / 2),
            anchor=memory.anchor if self.friction is None else self.friction.carried(memory, command, self.still),
        )

    def rested(self, memory: Memory, torque: Array) -> Memory:
        """The memory after the joints have come to rest under `torque`."""
        if self.friction is None:
            return memory
        return replace(memory, anchor=self.friction.dragged(torque, self.stiffness, memory.anchor))

    @property
    def load_matters(self) -> bool:
        """Whether a torque can move a link within its gap, or drag its friction along."""
        return self.friction is not None or bool(np.any((self.gap > 0) & np.isfinite(self.breakaway)))


@dataclass(frozen=True)
class Pieces:
    """A reducer in pieces, odd: tangent stiffness[:, j] for |torque| from breaks[:, j-1] to breaks[:, j]."""

    stiffness: Array  # (n,m) N*m/rad
    breaks: Array  # (n,m-1) N*m, rising

    def __call__(self, torque: Array, angle: Array) -> Array:
        n = len(self.stiffness)
        edges = np.hstack([np.zeros((n, 1)), self.breaks, np.full((n, 1), np.inf)])
        load = np.abs(torque)[:, None]
        inside = np.clip(load, edges[:, :-1], edges[:, 1:]) - edges[:, :-1]  # (n,m) torque in each piece
        out: Array = np.sign(torque) * np.sum(inside / self.stiffness, axis=1)
        return out


@dataclass(frozen=True)
class Stiffening:
    """Smooth: tangent stiffness k0 + slope |torque|; deflection = sign ln(1 + slope |tau| / k0) / slope."""

    k0: Array  # (n,) N*m/rad
    slope: Array  # (n,) 1/rad, above zero

    def __call__(self, torque: Array, angle: Array) -> Array:
        out: Array = np.sign(torque) * np.log1p(self.slope * np.abs(torque) / self.k0) / self.slope
        return out
