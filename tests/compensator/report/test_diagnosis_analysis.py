"""What reports compute of a diagnosis: the pattern of an addition, motion of a state, loads on a place."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.report.analysis.added_pattern import added_patterns
from compensator.report.analysis.loads import place_wrench
from compensator.report.analysis.session_residuals import session_residuals
from compensator.report.analysis.state_motion import joint_rotation, place_displacement
from tests.compensator.conftest import Sick


def test_the_pattern_of_backlash_is_a_step_that_is_gone_after(loose: Sick) -> None:
    d = loose.done.diagnosis
    (p,) = added_patterns(d, session_residuals(d, loose.model), d.added[0])
    gap = float(d.added[0].parameters["gap_rad"][0][0]) * 1e6
    assert p.x_name == "torque of joint 1, N·m" and p.y_name == "rotation of joint 1, µrad"
    assert np.abs(p.explained).max() == pytest.approx(gap / 2, rel=0.02)  # either flank is half a gap away
    assert p.before == pytest.approx(p.after + p.explained, abs=1e-9)
    assert np.sqrt(np.mean(p.after**2)) < 0.35 * np.sqrt(np.mean(p.before**2))


def test_motion_of_a_state_is_found_from_its_residuals(loose: Sick) -> None:
    """Made-up residuals: a joint turned by 1 mrad; a place moved and turned."""
    (seen,) = session_residuals(loose.done.diagnosis, loose.model)
    g, rows = seen.arm, np.arange(len(seen.sound))
    link = np.array([r.link for r in seen.session.reflectors])[seen.session.samples.reflector]
    for j in (0, 2, 4):
        moved = 1e-3 * np.cross(g.axis[:, j], seen.reflector - g.pivot[:, j]) * (link > j)[:, None]
        angle, told = joint_rotation(seen, rows, j, moved)
        assert told.sum() > 10 and angle[told] == pytest.approx(np.full(told.sum(), 1e-3), rel=1e-9)
    shift, rotation = np.array([2e-4, -1e-4, 3e-4]), np.array([1e-4, 2e-4, -3e-4])
    moved = shift + np.cross(rotation, seen.reflector)
    found, _, told = place_displacement(seen, rows, 0, moved)
    assert told.all() and found == pytest.approx(np.tile([*shift, *rotation], (len(found), 1)), abs=1e-9)


def test_load_on_the_base_carries_the_weight_of_the_arm(loose: Sick) -> None:
    (seen,) = session_residuals(loose.done.diagnosis, loose.model)
    session, g = seen.session, seen.arm
    wrench = place_wrench(session, g, 0)
    robot, load = session.robot, session.samples.load
    assert robot.mass is not None
    weight = 9.80665 * (float(robot.mass.sum()) + (session.tool.mass or 0.0))
    assert wrench[:, 2] - load.wrench[:, 2] == pytest.approx(np.full(len(wrench), -weight), rel=1e-12)
    # about joint 1's axis, which is the base's z, no weight turns: only the load does
    tcp = g.link(-1).at(session.tool.position)
    moment = load.wrench[:, 5] + np.cross(tcp, load.wrench[:, :3])[:, 2]
    assert not load.in_tool.any() and wrench[:, 5] == pytest.approx(moment, abs=1e-9)
