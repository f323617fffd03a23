"""Flanks and directions of one joint, pose after pose, in the words of the physics page."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Gap:
    """A link with lost motion ``gap``; ``link`` is where it sits, in [-gap/2, gap/2]."""

    gap: float
    breakaway: float
    side: float
    link: float

    def go(self, move: float, torque: float) -> float:
        """After a commanded move in direction s the link rests on side s (side = 1) or lags behind (-1): it
        crosses with the move, never beyond a flank. A torque beyond breakaway (and beyond 0.01 N*m, which no
        gear notices) holds it on its own flank."""
        self.link += self.side * move
        if self.link > self.gap / 2:
            self.link = self.gap / 2
        if self.link < -self.gap / 2:
            self.link = -self.gap / 2
        if abs(torque) > self.breakaway and abs(torque) > 0.01:
            self.link = self.gap / 2 if torque > 0 else -self.gap / 2
        return self.link


@dataclass
class Direction:
    """Which way a joint last turned: a travel back of half a micro-radian from the furthest point is a reversal."""

    last: int
    at: float = 0.0
    furthest: float = 0.0

    def go(self, move: float) -> int:
        self.at += move
        if self.last * (self.at - self.furthest) >= 0:
            self.furthest = self.at
        elif abs(self.at - self.furthest) > 0.5e-6:
            self.last, self.furthest = -self.last, self.at
        return self.last
