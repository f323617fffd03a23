"""Reducer: the data sheet of the gear in a joint; every figure holds at the output side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ARCMIN = np.pi / 180 / 60  # rad


@dataclass(frozen=True)
class Reducer:
    """Figures of a reducer; None where the sheet has no such figure.

    Attributes:
        rigidity: torsional, N*m/rad: one number, or the pieces K1, K2, ... from zero torque upwards.
        breaks: torque N*m at which each piece ends but the last.
        lost_motion: rad, of the middle of the hysteresis loop between -+ ``lost_motion_torque``; an upper bound.
        lost_motion_torque: N*m.
        backlash: rad, width of the loop at zero torque; an upper bound.
        gear_ratio: turns of the motor per turn of the joint.
        source: where the figures are from.
    """

    rigidity: tuple[float, ...]
    source: str
    breaks: tuple[float, ...] = ()
    lost_motion: float | None = None
    lost_motion_torque: float | None = None
    backlash: float | None = None
    gear_ratio: float | None = None

    def problem(self) -> str:
        """What is wrong with the figures together, beginning with the key; "" when nothing is."""
        pieces = len(self.rigidity)
        if len(self.breaks) != pieces - 1:
            return f"breaks_nm = {list(self.breaks)}: expected {pieces - 1}, one less than there are pieces of rigidity"
        if any(a >= b for a, b in zip(self.breaks, self.breaks[1:], strict=False)):
            return f"breaks_nm = {list(self.breaks)}: expected rising torques"
        if any(a > b for a, b in zip(self.rigidity, self.rigidity[1:], strict=False)):
            return "rigidity falls from one piece to the next: a reducer stiffens with torque; K1 comes first"
        if self.lost_motion_torque is not None and self.lost_motion is None:
            return "lost_motion_torque_nm is given without lost_motion_arcmin"
        return ""

    def windup(self, torque: float) -> float:
        """rad of the elastic curve at a torque (N*m) of at least zero: piece by piece."""
        ends = (*self.breaks, np.inf)
        starts = (0.0, *self.breaks)
        spans = zip(starts, ends, self.rigidity, strict=True)
        return float(sum(max(min(torque, end) - start, 0.0) / k for start, end, k in spans))
