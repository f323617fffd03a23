"""What is written of a diagnosis is what was judged: springs that begin wrong, and numbers that no effect allows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.reported import beyond_limits
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from stiffness.identification.nearest import nearest_to_drawing
from tests.stiffness.diagnosis.sick import ABB, KUKA, UR, sick

SCENARIO = "base-compliance"


@pytest.mark.parametrize("arm", [ABB, KUKA])
def test_a_spring_that_is_known_with_the_base_only_is_not_held_where_it_begins(arm: str) -> None:
    """No reflector tells the base from joint 1, whose spring begins half as stiff: held there, the base would have to
    push back."""
    ill = sick(SCENARIO, arm, seed=1)
    begun = {name: {k: np.array(v) for k, v in p.items()} for name, p in ill.fits.values.items()}
    begun["joint-stiffness"]["k_nm_per_rad"][0] *= 0.5
    hand = np.array([r.link == 6 for r in ill.session.reflectors])[ill.session.samples.reflector]
    effect = BY_NAME[SCENARIO]
    base = Addition(effect, effect.sites(6), frozenset(effect.sites(6)), effect.neutral(6))
    fit = replace(ill.fits, values=begun, used=(hand,), allowed=(hand,)).fit([base])
    assert fit.determined()[:6].tolist() == [False, *[True] * 5]
    near = nearest_to_drawing(fit)
    assert near.solution.chi2 < 1.1 * fit.solution.chi2
    assert not BY_NAME[SCENARIO].check(near.allowed_values()[SCENARIO])


def test_what_limits_cost_is_told_in_noises() -> None:
    ill = sick("joint-hardening joint-2", UR, size=6.0)
    left = float(np.sqrt(ill.base.solution.chi2 / ill.base.solution.freedom))
    assert left > 1.5
    assert beyond_limits(ill.base, [ill.base]) == ""
    quiet = replace(ill.base, solution=replace(ill.base.solution, chi2=0.9 * ill.base.solution.freedom))
    assert beyond_limits(quiet, [quiet]) == ""
    note = beyond_limits(quiet, [quiet, ill.base])
    assert "(1.00 times the noise is left)" in note and f"allowed {left:.2f} times" in note


def test_an_explanation_that_its_effect_does_not_allow_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    ill = sick("joint-hardening joint-2", UR, size=6.0)
    healthy = ill.base.model("ur10", {})
    assert diagnose([ill.session], healthy).verdict == "explained"

    def hardly(self: ModelFits, fit: Fit, additions: Sequence[Addition]) -> Fit:
        less = [
            replace(a, values={k: 0.1 * v for k, v in a.values.items()}, held=True)
            for a in at_values_of(fit, additions)
        ]
        return self.fit(less, fit, held=tuple(a.effect.name for a in less))

    monkeypatch.setattr(ModelFits, "within_limits", hardly)
    found = diagnose([ill.session], healthy)
    assert found.verdict == "unexplained"
    assert [a.effect for a in found.added] == ["joint-hardening"]
    assert any("beyond what their effects allow" in note for note in found.notes)
    assert not any("law is right" in note for note in found.notes)
