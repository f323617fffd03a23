"""Offsets of the geometry: at the drawing where the readings find the robot there, else where they are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.identification.drawing_scale import with_drawing_scale
from stiffness.identification.fit import Fit
from stiffness.identification.nearest import nearest_to_drawing
from stiffness.identification.registration import with_registration
from stiffness.identification.robust import named_effects, robust_fit
from stiffness.identify import identify
from stiffness.session.session import Session
from tests.stiffness.bench_lab import Lab

NAMES = ["joint-stiffness", "kinematic-offset"]
ROBOTS = ["ur10", "abb-irb6600-175-255"]


def turned(session: Session, zero: np.ndarray) -> Session:
    """The session of an arm whose joints stand ``zero`` (n,) rad further than the controller shows."""
    return replace(session, samples=replace(session.samples, q=session.samples.q - zero))


def offsets(fit: Fit) -> np.ndarray:
    return np.concatenate([v.ravel() for v in fit.values()["kinematic-offset"].values()])


@pytest.mark.parametrize("robot", ROBOTS)
def test_an_arm_like_its_drawing_is_given_as_drawn(robot: str, tmp_path: Path) -> None:
    session, _ = Lab(robot).session(tmp_path, 3)
    free = nearest_to_drawing(with_registration(robust_fit([session], named_effects(NAMES), None)))
    fit = identify([session])
    assert np.abs(offsets(free)).max() > 3e-6
    assert np.abs(offsets(fit)).max() < 1e-8
    (note,) = (n for n in fit.notes if n.startswith("kinematic-offset: held at the drawing"))
    assert "mm and mrad off" in note
    # of directions that no reading tells, nobody knows more than the drawing
    assert fit.sd == pytest.approx(free.sd, rel=1e-3)
    off = (fit.parameters[:6] - 1 / Lab(robot).stiffness) / fit.sd[:6]  # the solver sees compliances
    assert np.abs(off).max() < 3.5
    again, notes = with_drawing_scale(fit)
    assert offsets(again) == pytest.approx(offsets(fit), abs=1e-9)
    assert len(notes) == 1


@pytest.mark.parametrize("robot", ROBOTS)
def test_zeros_of_an_arm_that_nobody_calibrated_stay(robot: str, tmp_path: Path) -> None:
    session, _ = Lab(robot).session(tmp_path, 4)
    zero = np.array([0.0, 1.1e-3, -0.8e-3, 1.6e-3, -0.9e-3, 0.0])
    ill = turned(session, zero)
    free = nearest_to_drawing(with_registration(robust_fit([ill], named_effects(NAMES), None)))
    fit = identify([ill])
    # nearer than a tenth of its noise to what it was
    assert np.abs(offsets(fit) - offsets(free)).max() < 3e-5
    assert np.abs(offsets(fit)).max() > 5e-4


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_fit_with_that_prior_gives_the_same(robot: str, tmp_path: Path) -> None:
    """The linear step against least squares with the offsets held at the drawing."""
    session, _ = Lab(robot).session(tmp_path, 5)
    free = nearest_to_drawing(robust_fit([session], named_effects(NAMES), None))
    held, _ = with_drawing_scale(free)
    offset = [k for k, u in enumerate(free.unknowns.free) if u.effect == "kinematic-offset"]
    firm = free.problem.parameter_sd.copy()
    firm[offset] *= 1e-5
    solution, _ = replace(free.problem, parameter_sd=firm).solved(free.states, free.solution.vector)
    off = (solution.vector - held.solution.vector)[: len(free.unknowns)] / free.sd
    moved = (free.solution.vector - held.solution.vector)[: len(free.unknowns)] / free.sd
    assert np.abs(off).max() < 0.01
    assert np.abs(np.delete(moved, offset)).max() > 0.1
