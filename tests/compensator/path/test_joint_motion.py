"""Speeds and accelerations of joints against a motion with known derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.path.joint_motion import RAMP, joint_motion
from tests.compensator.handmade_toolpaths import toolpath
from toolpaths.toolpath import Toolpath

FEED = 0.05  # m/s


def path(x: np.ndarray, y: np.ndarray | None = None, kind: str | None = None) -> Toolpath:
    return toolpath(np.stack([x, np.zeros_like(x) if y is None else y, np.zeros_like(x)], axis=1) * 1e3, kind)


def test_a_parabola_has_one_acceleration_however_it_is_sampled() -> None:
    """q = v t + a t2 / 2, its poses at uneven distances; chords of 1 to 4 ms cost less than a per cent."""
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.uniform(1e-3, 4e-3, 400))
    a, v = np.array([0.5, -2.0]), np.array([0.1, 0.3])
    q = v * t[:, None] + 0.5 * a * t[:, None] ** 2
    motion = joint_motion(path(FEED * t), q, np.full(len(t), FEED))
    inside = (t > t[0] + RAMP) & (t < t[-1] - RAMP)
    np.testing.assert_allclose(motion.acceleration[inside], np.abs(a) * np.ones((inside.sum(), 2)), rtol=0.01)
    assert not motion.acceleration[~inside].any()
    later = np.abs(v + a * (t + RAMP / 2)[:, None])
    earlier = np.abs(v + a * (t - RAMP / 2)[:, None])
    expected = np.maximum(earlier, later)
    np.testing.assert_allclose(motion.speed[inside], expected[inside], rtol=0.02)


def test_twice_the_feed_is_twice_the_speed_and_four_times_the_acceleration() -> None:
    x = np.linspace(0, 0.4, 4001)
    q = np.sin(20 * x)[:, None]
    slow, fast = (joint_motion(path(x), q, np.full(len(x), f)) for f in (FEED, 2 * FEED))
    middle = slice(1200, 2800)
    np.testing.assert_allclose(fast.speed[middle].max(), 2 * slow.speed[middle].max(), rtol=0.01)
    np.testing.assert_allclose(fast.acceleration[middle].max(), 4 * slow.acceleration[middle].max(), rtol=0.01)
    assert slow.acceleration[middle].max() == pytest.approx((20 * FEED) ** 2, rel=0.01)


def test_rapids_and_corners_are_not_counted() -> None:
    """A rapid in the middle; a right angle in the second cut, where the controller slows down."""
    x = np.r_[np.arange(0, 50), np.full(50, 49.0)] * 1e-3
    y = np.r_[np.zeros(50), np.arange(1, 51)] * 1e-3
    q = (x + 3 * y)[:, None]
    motion = joint_motion(path(x, y, "c" * 20 + "r" + "c" * 79), q, np.full(100, FEED))
    assert motion.speed[20, 0] == pytest.approx(FEED, rel=1e-9) and motion.stretch[19] != motion.stretch[20]
    assert motion.speed[80, 0] == pytest.approx(3 * FEED, rel=1e-9)
    assert motion.acceleration.max() < 1e-9
    smooth = joint_motion(path(np.linspace(0, 0.1, 100)), q, np.full(100, FEED))
    assert smooth.acceleration.max() > 1.0  # the same angles on a straight path
