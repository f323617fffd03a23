"""Chosen turn: what choosing the turn about the tool axis along a path was worth."""

from __future__ import annotations

from dataclasses import dataclass

from toolpaths.finding import Finding


@dataclass(frozen=True)
class TurnValue:
    """What a turn along a path costs, means over the cut.

    Attributes:
        variance: m2, of the deflection that the compensation relies on.
        crossings: m2, of joints that cross their gaps.
        acceleration: m2, of joint accelerations at the programmed feed.
        reversals: of all joints in the cut; a way back counts as far as it goes beyond what a joint gives anyway.
        sd: m, mean standard deviation.
        lean: m2, the price of leaning.
        axes: m2, the price of rails that move in the cut.
    """

    variance: float
    crossings: float
    acceleration: float
    reversals: float
    sd: float
    lean: float = 0.0
    axes: float = 0.0

    @property
    def cost(self) -> float:
        """m2, the sum that is made small."""
        return self.variance + self.crossings + self.acceleration + self.lean + self.axes


@dataclass(frozen=True)
class LeanWorth:
    """What leaning the tool axis was worth beside turning about it.

    Attributes:
        upright: what the path costs whose tool does not lean; None: it cannot be followed.
        most: rad, of the lean; mean: rad, over the cut.
        cone: rad, what the cell allows.
        place: where the lean is largest, as messages have it.
    """

    upright: TurnValue | None
    most: float
    mean: float
    cone: float
    place: str


@dataclass(frozen=True)
class ChosenTurn:
    """How the turn along a path was chosen.

    Attributes:
        constant: what the constant turn costs that the path would have had; None: no constant turn serves.
        chosen: what the chosen one costs.
        windows: of the refinement that led to it, and those that failed and kept their start.
        findings: of the choice.
        lean: None: the tool does not lean.
    """

    constant: TurnValue | None
    chosen: TurnValue
    windows: tuple[int, int]
    findings: tuple[Finding, ...]
    lean: LeanWorth | None = None
