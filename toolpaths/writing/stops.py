"""Stops: postures that a robot drives to one after the other, and waits at: to be measured in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from toolpaths.writing.names import plain

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class Stops:
    """A program of joint moves.

    Attributes:
        robot: name. remarks: of the head.
        joints: (N, 6) rad. words: what is shown where the robot waits; empty: it passes through.
        speed: percent of the largest joint speeds.
    """

    robot: str
    remarks: tuple[str, ...]
    joints: Floats
    words: tuple[str, ...]
    speed: int

    def __repr__(self) -> str:
        return f"Stops({self.robot!r}, {len(self.joints)} postures)"

    @property
    def head(self) -> tuple[str, ...]:
        """Remarks of the head, as plain text."""
        return tuple(plain(text) for text in (f"Postures to measure {self.robot or 'the robot'} in", *self.remarks))

    @property
    def degrees(self) -> list[list[float]]:
        """Joint angles, deg, without negative zeros."""
        rows: list[list[float]] = (np.round(np.degrees(self.joints), 6) + 0.0).tolist()
        return rows
