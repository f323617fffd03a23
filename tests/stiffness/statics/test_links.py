"""Links of a predicted arm, rigid and deflected, against an oracle that shares no code with it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.elastic_arm import ElasticArm, Push
from tests.stiffness import arms


@pytest.mark.parametrize("calibrated_out", [False, True])
def test_every_link_stands_where_the_oracle_has_it(calibrated_out: bool) -> None:
    """Where the controller knows the sag, the joints give way by what is left of it."""
    predictor = arms.predictor(calibrated_out=calibrated_out)
    arm, tool, q = arms.robot(), arms.tool(), arms.postures(arms.robot(), 3, 9)
    wrench = arms.wrenches(3, 900.0)
    oracle = ElasticArm(arm, lambda tau, a: tau / arms.STIFFNESS, masses=((6, tool.mass, tool.com),))
    rigid, deflected = predictor.links(q, wrench, np.zeros((3, 0)))
    assert rigid.origin.shape == (3, 7, 3) and deflected.rotation.shape == (3, 7, 3, 3)
    for k in range(3):
        push = Push(6, tool.position, wrench[k])
        x = oracle.solve(q[k], [push])[0] - (oracle.solve(q[k], [])[0] if calibrated_out else 0.0)
        assert np.abs(x).max() > 2e-4
        for frames, at in ((rigid, np.zeros_like(x)), (deflected, x)):
            for link, expected in enumerate(oracle.links(q[k], at)):
                assert frames.rotation[k, link] == pytest.approx(expected[:3, :3], abs=1e-11)
                assert frames.origin[k, link] == pytest.approx(expected[:3, 3], abs=1e-11)
