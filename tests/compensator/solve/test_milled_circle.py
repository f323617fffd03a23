"""The milled circle: bumps where joints turn back, gone once play is tracked (docs/milled-circle.md)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.compensator.milled_circle import GCODE, MODEL, Circle, bench, experiment, mill
from tests.plant.geometry import Array

HUNDREDTH = 10e-6  # m


def at(circle: Circle, degrees: Array) -> Array:
    """Radial error at angles on the circle, m."""
    return np.interp(degrees, np.degrees(circle.angle), circle.radial)


def bumps(circle: Circle) -> dict[tuple[int, int], float]:
    """(joint, nth reversal) -> change of the radial error in the 6 deg after it, less the 6 deg before."""
    out: dict[tuple[int, int], float] = {}
    for joint, angle in circle.reversals:
        a = np.degrees(angle)
        if 6 < a < 348:
            trend = at(circle, a) - at(circle, a - 6)
            n = sum(1 for j, _ in out if j == joint)
            out[joint, n] = float(abs(at(circle, a + 6) - at(circle, a) - trend))
    return out


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_bumps_at_reversals_are_gone(side: float, tmp_path: Path) -> None:
    circles = experiment(tmp_path, side, per_move=3)
    for circle in circles.values():
        assert abs(np.degrees(circle.angle[-1] - circle.angle[0]) - 360) < 0.1
        assert np.max(np.diff(circle.angle)) < np.radians(1)
    raw, plain, tracked = (circles[k] for k in ("uncompensated", "stiffness only", "stiffness and play"))
    # each of joints 1, 4, 5 and 6 turns back twice; the bumps stand there, stiffness or not
    for circle in (raw, plain):
        found = bumps(circle)
        assert {(j, n) for j in (1, 4, 5, 6) for n in (0, 1)} <= set(found)
        assert min(found[1, 0], found[1, 1], found[5, 0], found[5, 1]) > 50e-6
        assert np.ptp(circle.radial) > 300e-6
    # stiffness alone centres the circle, roughly, and leaves it as far from round as the play makes it
    assert abs(np.mean(plain.radial)) < 0.25 * np.ptp(plain.radial)
    # with play: the points of the program to micrometres (chords of the arc, 2 um, included)
    assert np.abs(tracked.radial[tracked.knot]).max() < 0.5 * HUNDREDTH
    assert np.abs(tracked.height[tracked.knot]).max() < 0.5 * HUNDREDTH
    # and the lines between them to a hundredth of a millimetre, flank changes included
    assert np.abs(tracked.radial).max() < HUNDREDTH


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_plant_without_play_has_no_bumps(side: float, tmp_path: Path) -> None:
    """The bumps come from the play: without it, stiffness alone makes the circle round."""
    path = tmp_path / "circle.nc"
    path.write_text(GCODE)
    stiff = replace(bench(tmp_path, side), effects={"joint-stiffness": MODEL["joint-stiffness"]})
    _, table = stiff.compensate(path)
    circle = mill(stiff, table, nominal=False, per_move=2)
    assert np.abs(circle.radial).max() < 3e-6
    _, raw = stiff.preview(path)
    assert np.ptp(mill(stiff, raw, nominal=True, per_move=1).radial) > 100e-6
