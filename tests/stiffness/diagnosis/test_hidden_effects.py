"""Hidden effects: intervals of a default identify that hold the truth though the model lacks something."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.hidden_effects import with_hidden
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import Session
from tests.plant.cell_design import CELLS
from tests.stiffness.diagnosis.sick import UR, sick

Floats = npt.NDArray[np.float64]


def off(fit: Fit, sd: Floats) -> Floats:
    """(6,) distances of compliances from the truth, in standard deviations of stiffness ``sd``."""
    k, truth = fit.values()["joint-stiffness"]["k_nm_per_rad"], np.array(CELLS[UR].stiffness)
    return np.abs((1 / k - 1 / truth) / (sd / k**2))


def own(fit: Fit) -> Floats:
    """(6,) standard deviations of stiffness without what is hidden."""
    springs = fit.unknowns.springs
    return fit.sd[springs] / fit.parameters[springs] ** 2


def printed(fit: Fit) -> Floats:
    return fit.deviations()["joint-stiffness"]["k_nm_per_rad"]


def blind(session: Session) -> Session:
    """Without approach columns."""
    return replace(session, samples=replace(session.samples, approach=np.zeros_like(session.samples.approach)))


@pytest.mark.parametrize("scenario", ["tool-compliance", "payload"])
def test_what_is_missing_is_in_the_intervals(scenario: str) -> None:
    """Springs far off for their own standard deviations are not for those that are printed; of a joint that no
    explanation moves the interval stays narrow."""
    for session in (ill := sick(scenario, size=6.0).session, blind(ill)):
        fit = identify([session])
        assert fit.lacks and [e.name for e in fit.unknowns.effects] == ["joint-stiffness", "kinematic-offset"]
        sd = printed(fit)
        assert off(fit, own(fit)).max() > 3 > 2 > off(fit, sd).max()
        assert (sd / np.array(CELLS[UR].stiffness)).min() < 0.05


def test_what_has_been_refuted_widens_nothing() -> None:
    """A fit that explains all counts alone; where none does, the farthest counts, and what the best still lacks."""
    ill = sick("payload", size=6.0)
    base = ill.base
    assert base.lacks

    def moved(by: float, left: float) -> Fit:
        """Parameters moved, chi-square multiplied."""
        s = base.solution
        vector = s.vector.copy()
        vector[: len(base.unknowns)] *= by
        return replace(base, solution=replace(s, vector=vector, chi2=s.chi2 * left))

    noise = 1 / base.solution.misfit**2
    alone = with_hidden(base, [moved(1.1, noise)]).hidden
    both = with_hidden(base, [moved(1.1, noise), moved(2.0, 0.9)]).hidden
    neither = with_hidden(base, [moved(1.1, 0.8), moved(2.0, 0.9)]).hidden
    assert alone is not None and both is not None and neither is not None
    np.testing.assert_array_equal(alone, both)
    assert np.all(alone >= 0.1 * np.abs(base.parameters) * (1 - 1e-9))
    assert np.all(neither >= np.abs(base.parameters) * (1 - 1e-9))
    assert with_hidden(base, []).hidden is None
