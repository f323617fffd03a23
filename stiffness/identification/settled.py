"""Settled: of all solutions that the readings do not tell apart, the one that identify and diagnose give."""

from __future__ import annotations

from stiffness.identification.common_numbers import with_common_numbers
from stiffness.identification.drawing_scale import with_drawing_scale
from stiffness.identification.fit import Fit
from stiffness.identification.nearest import nearest_to_drawing


def settled(fit: Fit) -> tuple[Fit, tuple[str, ...]]:
    """The fit nearest to the drawing, with one number where one cause makes several, and notes of what was chosen.
    Comparisons of chi-square are over."""
    fit, near = with_drawing_scale(nearest_to_drawing(fit))
    fit, common = with_common_numbers(fit)
    return fit, (*near, *common)
