"""What reports compute of a fit: residuals along the motion of a joint, torques, standardised residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.report.analysis.by_joint import joint_residuals
from compensator.report.analysis.loads import load_torque
from compensator.report.analysis.predicted import predicted_sessions
from compensator.report.analysis.standardised import standardised
from compensator.report.analysis.undeflected import undeflected
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from tests.plant.lab import Form
from tests.stiffness.bench_lab import Lab


def test_per_joint_the_rigid_arm_leaves_a_slope_and_the_fit_none(fitted: tuple[Fit, list[int]]) -> None:
    fit = fitted[0]
    for at in joint_residuals(fit, predicted_sessions(fit)):
        assert len(at.torque) > 10
        slope_rigid, slope_fitted = (at.torque @ v / (at.torque @ at.torque) for v in (at.rigid, at.fitted))
        assert slope_rigid > 0  # gives in along its torque
        assert abs(slope_fitted) < 0.05 * slope_rigid
        assert np.sqrt(np.mean(at.fitted**2)) < 0.1 * np.sqrt(np.mean(at.rigid**2))


def test_torque_of_a_load_is_that_of_the_jacobian(fitted: tuple[Fit, list[int]]) -> None:
    session = fitted[0].sessions[0].session
    s, robot = session.samples, session.robot
    torque = load_torque(session, undeflected(robot, s.q))
    loaded = np.flatnonzero(np.linalg.norm(s.load.wrench, axis=1) > 100)[::17]
    assert len(loaded) > 3
    for k in loaded:
        pose = robot.pose(s.q[k])
        at = pose[:3, 3] + pose[:3, :3] @ s.load.point[k]
        force, moment = s.load.wrench[k, :3], s.load.wrench[k, 3:]
        about = moment + np.cross(at - pose[:3, 3], force)
        assert torque[k] == pytest.approx(robot.jacobian(s.q[k]).T @ np.concatenate([force, about]), abs=1e-6)


def test_residuals_of_a_good_session_are_standard_normal(fitted: tuple[Fit, list[int]]) -> None:
    z = standardised(fitted[0])
    used = int(fitted[0].sessions[0].used.sum())
    assert 2 * used < len(z) < 3 * used  # a reading has three numbers, one of a reflector's states carries the offset
    assert np.std(z) == pytest.approx(1, abs=4 / np.sqrt(2 * len(z)))
    assert abs(np.mean(z)) < 4 / np.sqrt(len(z))


def test_a_session_that_is_not_registered(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 5, setups=10, form=Form(registered=False))
    fit = identify([session], ["joint-stiffness"])
    for at in joint_residuals(fit, predicted_sessions(fit)):
        assert at.torque @ at.rigid > 0 and np.sqrt(np.mean(at.fitted**2)) < 6e-5
