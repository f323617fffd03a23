"""What to measure next: postures over the range of a joint, none of them twice."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.planning.next_setups import WANTED, spread
from tests.stiffness.diagnosis.sick import sick


@pytest.mark.parametrize("joint", [None, 0, 4])
def test_no_posture_is_asked_for_twice(joint: int | None) -> None:
    session = sick("clean").session
    found = spread(session, joint, "why")
    q = np.array([s.q for s in found])
    assert len(found) == WANTED
    assert len(np.unique(q.round(9), axis=0)) == WANTED
    assert np.all((q >= session.robot.lower) & (q <= session.robot.upper))
    if joint is not None:  # a fifth of the range apart, about
        low, high = max(session.robot.lower[joint], -np.pi), min(session.robot.upper[joint], np.pi)
        assert np.ptp(q[:, joint]) > 0.5 * (high - low)


def test_a_narrow_pool_gives_each_posture_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """All postures of the pool stand alike in the joint: the nearest one is not given again."""
    from stiffness.planning import next_setups

    session = sick("clean").session
    pool = next_setups.reachable_postures(session.robot, session.tool.tool(), next_setups.POOL, next_setups.SEED)
    pool.q[:, 2] = 0.3
    monkeypatch.setattr(next_setups, "reachable_postures", lambda *given: pool)
    q = np.array([s.q for s in spread(session, 2, "why")])
    assert len(np.unique(q.round(9), axis=0)) == WANTED
