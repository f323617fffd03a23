"""Steps along a path: thin things are not jumped over, the bound of the motion holds, few looks are needed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.scene.body import TOOL, WORLD, Body
from compensator.scene.carrier_frames import link_frames
from compensator.scene.collider import Collider
from compensator.scene.motion_bound import motion_along
from compensator.scene.pairs import Pair
from compensator.scene.path_walk import ArmPath, PathWalk
from compensator.scene.shape import BoxShape, CapsuleShape
from stiffness.robot.load import load_robot
from toolpaths.frame import Frame

ROBOT = load_robot("abb-irb6600-175-255")
TIP = Body("tip", TOOL, CapsuleShape(0.01, 0.0), Frame(np.eye(3), np.array([0.0, 0.0, 0.3])), role="cutter")
PAIR = Pair(0, 1, slice(0, 6), None, margin=True)
HOME = Frame.identity()


def sheet(angle: float, thick: float) -> Body:
    """A sheet that stands where the tip is after joint 1 has turned by ``angle``, rad."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    place = Frame(turn, np.array([0.0, 0.0, 1.0]))
    return Body("sheet", WORLD, BoxShape(np.array([4.0, thick, 4.0])), place, role="scene")


def walked(around: Body, q: np.ndarray, step: float = 0.002):
    walk = PathWalk(Collider(ROBOT, (around, TIP), (PAIR,)), ArmPath(q, HOME), margin=0.01, step=step)
    return walk.measured(walk.approach(PAIR, np.ones(len(q), dtype=np.bool_)))


@pytest.mark.parametrize("angle", [0.2345, 0.777, 1.4])
def test_a_thin_sheet_between_two_far_poses_is_hit(angle: float) -> None:
    q = np.radians([[-10.0, 10, 10, 0, 30, 0], [100.0, 10, 10, 0, 30, 0]])  # three metres in one move
    found = walked(sheet(angle, 0.001), q)
    assert found.contacts == (1,)
    assert found.looks < 250  # 1,500 looks of 2 mm would be needed without the bound


def test_beside_the_sheet_the_distance_is_that_of_geometry() -> None:
    q = np.radians([[-10.0, 10, 10, 0, 30, 0], [20.0, 10, 10, 0, 30, 0]])
    tip = link_frames(ROBOT, q[1:])[6].at(TIP.placement.origin)[0]
    radius = np.hypot(tip[0], tip[1])
    angle = np.radians(25.0)
    expected = radius * np.sin(angle - np.arctan2(tip[1], tip[0])) - 0.0005 - 0.01
    found = walked(sheet(angle, 0.001), q)
    assert found.contacts == () and found.least is not None
    assert found.least[0] == pytest.approx(expected, abs=1e-6)
    assert found.least[1] == 1


def test_no_point_moves_further_than_the_bound() -> None:
    rng = np.random.default_rng(5)
    q = np.cumsum(rng.normal(0.0, 0.05, (200, 6)), axis=0)
    bound = motion_along(ROBOT, (sheet(0.0, 0.1), TIP), PAIR, q=q, moving={})
    tip = link_frames(ROBOT, q)[6].at(TIP.placement.origin)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tip, axis=0), axis=1))])
    assert np.all(way[1:] <= bound[1:])
    assert bound[-1] < 6.0 * way[-1]  # a bound that says something


def test_moves_that_do_not_count_are_left_out() -> None:
    q = np.radians([[-10.0, 10, 10, 0, 30, 0], [30.0, 10, 10, 0, 30, 0], [60.0, 10, 10, 0, 30, 0]])
    walk = PathWalk(Collider(ROBOT, (sheet(0.3, 0.001), TIP), (PAIR,)), ArmPath(q, HOME), margin=0.0, step=0.002)
    assert walk.approach(PAIR, np.array([True, True, True])).contacts == (1,)
    assert walk.approach(PAIR, np.array([False, False, True])).contacts == ()


def test_a_table_that_turns_carries_what_stands_on_it(tmp_path: Path) -> None:
    q = np.tile(np.radians([0.0, 10, 10, 0, 30, 0]), (2, 1))
    turns = [np.eye(3), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])]
    moving = {WORLD: Frame(np.array(turns), np.zeros((2, 3)))}
    post = Body("post", WORLD, BoxShape(np.array([4.0, 0.02, 4.0])), sheet(-0.8, 0.02).placement, role="scene")
    walk = PathWalk(Collider(ROBOT, (post, TIP), (PAIR,)), ArmPath(q, HOME, moving), margin=0.0, step=0.002)
    assert walk.approach(PAIR, np.ones(2, dtype=np.bool_)).contacts == (1,)  # the arm stands still
