"""Reversals, levers and how well gaps are told, against closed forms, Pinocchio and plain least squares."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.planning.lever import tcp_levers
from stiffness.planning.reversals import gap_sd, reversals, sides
from stiffness.robot.load import builtin_robots, load_robot
from stiffness.statics.tool import Tool


@pytest.mark.parametrize("name", builtin_robots())
def test_levers_are_the_jacobian(name: str) -> None:
    robot = load_robot(name)
    tool = Tool(np.eye(3), np.array([0.03, -0.02, 0.25]))
    q = np.random.default_rng(2).uniform(-1.0, 1.0, (5, robot.n))
    levers = tcp_levers(robot, tool, q)
    for row, lever in zip(q, levers, strict=True):
        linear, turn = np.split(robot.jacobian(row), 2)  # of the flange, by Pinocchio
        arm = robot.pose(row)[:3, :3] @ tool.position
        np.testing.assert_allclose(lever, (linear + np.cross(turn.T, arm).T).T, atol=1e-9)


def test_reversals_of_harmonics() -> None:
    along = np.radians(np.arange(0, 361.0))
    q = 0.2 * np.column_stack([np.cos(along), np.sin(along), np.cos(along - np.radians(25)), 0 * along, along])
    lever = np.tile([1.0, -0.5, 0.5, 1.0, 1.0], (len(along), 1))
    found = [(r.joint, round(np.degrees(r.along)), round(np.degrees(r.apart))) for r in reversals(along, q, lever)]
    assert found == [(2, 25, 65), (1, 90, 65), (0, 180, 25), (2, 205, 25), (1, 270, 65)]
    first = reversals(along, q, lever)[0]
    assert first.angle == pytest.approx(0.2) and first.lever == 0.5 and first.row == 25


def test_a_joint_without_a_lever_hides_none_and_a_tremble_is_no_reversal() -> None:
    along = np.radians(np.arange(0, 181.0))
    q = 0.2 * np.column_stack([np.sin(along), np.sin(along), along])
    q[50, 2] -= 2e-3 * 0.2  # less than what crosses a gap
    lever = np.tile([1.0, 0.02, 1.0], (len(along), 1))
    found = {r.joint: r.apart for r in reversals(along, q, lever)}
    assert set(found) == {0, 1} and found[0] == np.inf and found[1] == 0.0


def test_sides() -> None:
    q = np.array([[0.0, 5.0], [0.0, 5.0], [0.1, 5.0], [0.1, 5.0], [0.0, 5.0]])
    assert sides(q).tolist() == [[1, 0], [1, 0], [1, 0], [1, 0], [-1, 0]]


def test_gap_sd_is_that_of_least_squares() -> None:
    rng = np.random.default_rng(5)
    rows, beside = rng.normal(size=(60, 3)), rng.normal(size=(60, 4))
    rows = np.column_stack([rows, np.zeros(60), beside[:, 0]])  # one is never seen, one looks like the centre
    found = gap_sd([rows[:25], rows[25:]], [beside[:25], beside[25:]], 2.0)
    full = np.hstack([rows[:, :3], beside])
    expected = 2.0 * np.sqrt(np.diag(np.linalg.inv(full.T @ full)))[:3]
    assert found[:3] == pytest.approx(expected) and found[3:].tolist() == [np.inf, np.inf]
