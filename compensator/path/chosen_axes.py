"""Chosen axes: where rails and tables stand along a path, and what choosing it was worth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from compensator.path.chosen_turn import TurnValue
from toolpaths.finding import Finding


@dataclass(frozen=True)
class AxisUse:
    """What a path asks of one axis, in its unit.

    Attributes:
        name: as the cell has it. unit: mm or deg. carries: robot or part.
        range: that it may stand in.
        least, greatest: where it stands.
        travel: all its ways along the path. fastest: of them, unit/s, at the programmed feeds.
        limits: speed and acceleration at most, unit/s and unit/s2; None: it is set once.
    """

    name: str
    unit: str
    carries: str
    range: tuple[float, float]
    least: float
    greatest: float
    travel: float
    fastest: float
    limits: tuple[float, float] | None

    @property
    def moves(self) -> bool:
        """Whether it moves along the path."""
        return self.travel > 0


@dataclass(frozen=True)
class ChosenAxes:
    """How the axes of a path were chosen.

    Attributes:
        uses: of every axis.
        constant: what the best places cost that stay for the whole path; None: none serves.
        constant_places: name -> those places.
        chosen: what the chosen ones cost.
        windows: of the refinement that led to them, and those that failed and kept their start.
        findings: of the choice.
    """

    uses: tuple[AxisUse, ...]
    constant: TurnValue | None
    constant_places: Mapping[str, float]
    chosen: TurnValue
    windows: tuple[int, int]
    findings: tuple[Finding, ...]
