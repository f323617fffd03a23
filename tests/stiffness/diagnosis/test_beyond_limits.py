"""What is written of a diagnosis is what was judged: springs that begin wrong, and numbers that no effect allows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.refined_model import refined_model
from stiffness.diagnosis.reported import contradicted, worse
from stiffness.diagnosis.result import HeldOutScores
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from stiffness.identification.nearest import nearest_to_drawing
from stiffness.identification.scores import Score
from stiffness.identify import identify
from stiffness.numerics.least_squares import EXACT
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
    written = refined_model(ill.base.model(arm, {}), fit=fit, free=fit, additions=[base], removed=[])
    assert written.identified["joint-stiffness"].tolist() == [False, *[True] * 5]
    assert written.provenance["not_identified"] == fit.not_identified() != []
    near = nearest_to_drawing(fit)
    assert near.solution.chi2 < 1.1 * fit.solution.chi2
    assert not BY_NAME[SCENARIO].check(near.allowed_values()[SCENARIO])
    # wherever the base begins, it is stiff about the axis of joint 1, whose spring is the sum of both and as sure
    begun = {**base.values, "angular_rad_per_nm": np.full(3, 3e-7)}
    far = replace(ill.fits, used=(hand,), allowed=(hand,)).fit([replace(base, values=begun)])
    again = nearest_to_drawing(far)
    for one in (near, again):
        values, sd = one.values(), one.deviations()
        k, yaw = values["joint-stiffness"]["k_nm_per_rad"][0], values[SCENARIO]["angular_rad_per_nm"][2]
        true = ill.fits.values["joint-stiffness"]["k_nm_per_rad"][0]
        assert abs(yaw) < 0.01 / k and k == pytest.approx(true, rel=0.05)
        assert sd["joint-stiffness"]["k_nm_per_rad"][0] < 0.02 * k and sd[SCENARIO]["angular_rad_per_nm"][2] > 1 / k
        assert one.determined()[0]


def test_a_law_that_bends_with_its_numbers_is_not_held_at_nothing() -> None:
    """Of a balancing spring the readings leave a combination of moment and lengths open: no way straight from where the
    fit ended to no spring at all stays within it."""
    ill = sick("gravity-compensator", KUKA, seed=1)
    effect = BY_NAME["gravity-compensator"]
    begun = {p.name: np.full(p.count(6), -1.0 if p.name == "angle_rad" else p.start) for p in effect.parameters}
    fit = ill.fits.fit([Addition(effect, effect.sites(6), frozenset(effect.sites(6)), begun)], ill.base)
    assert fit.solution.misfit < 1.02 and not fit.gauge.told.all()
    near = nearest_to_drawing(fit).values()["gravity-compensator"]
    for name, value in fit.values()["gravity-compensator"].items():
        assert near[name] == pytest.approx(value, rel=0.05) and abs(value[0]) > 0.1


def test_what_is_written_and_leaves_more_is_told_in_noises_with_its_cause() -> None:
    ill = sick("joint-hardening joint-2", UR, size=6.0)
    bad, left = ill.base, float(np.sqrt(ill.base.solution.chi2 / ill.base.solution.freedom))
    assert left > 1.5
    good = replace(bad, solution=replace(bad.solution, chi2=0.9 * bad.solution.freedom))
    assert contradicted(bad, bad, bad, bad) == contradicted(good, good, good, good) == ""
    for written in ((bad, good, good), (good, good, bad)):
        note = contradicted(good, *written)
        assert "(1.00 times the noise is left)" in note and f"allowed {left:.2f} times" in note
    note = contradicted(good, good, bad, bad)
    assert f"leave {left:.2f} times the noise of all" in note and "allow" not in note


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


def test_what_is_fitted_again_within_limits_is_settled_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit of all numbers but those that were held leaves noise in the offsets of the geometry."""
    ill = sick("joint-hardening joint-2", UR, size=6.0)
    model, again = identify([ill.session]).model("ur10", {}), list[Fit]()

    def once_more(self: ModelFits, fit: Fit, additions: Sequence[Addition]) -> Fit:
        if self.ending is not EXACT or again:
            return fit
        again.append(self.fit(at_values_of(fit, additions), fit))
        return again[0]

    monkeypatch.setattr(ModelFits, "within_limits", once_more)
    found = diagnose([ill.session], model)
    offsets = [np.abs(np.concatenate([*f.values["kinematic-offset"].values()])).max() for f in (model, found.model)]
    noise = np.abs(np.concatenate([*again[0].values()["kinematic-offset"].values()])).max()
    assert found.verdict == "explained"
    assert min(noise, offsets[0]) > 3e-6 and offsets[1] < 1e-8
    assert sum(note.startswith("kinematic-offset: held at the drawing") for note in found.notes) == 1


def test_a_model_that_stays_is_not_said_to_be_another() -> None:
    """Nothing is missing: what all readings would choose in it is not written, and no note tells of it."""
    ill = sick("clean", UR)
    fit = identify([ill.session])
    assert any("drawing" in note for note in fit.notes)
    found = diagnose([ill.session], fit.model("ur10", {}))
    assert found.verdict == "adequate"
    assert not any("drawing" in note for note in found.notes)


def test_what_predicts_worse_than_the_model_at_hand_is_not_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """On readings that took no part, of either kind, against the model as it was and fitted anew."""

    def scores(before: float, refitted: float, after: float) -> HeldOutScores:
        three = (1e-3 * rms for rms in (before, refitted, after))
        return HeldOutScores(*(Score(rms, 2 * rms, 3 * rms, 2e-5, {}, 24) for rms in three))

    fine = scores(0.3, 0.2, 0.21)
    ill = sick("payload", UR, size=6.0)
    base = ill.base
    good = replace(base, solution=replace(base.solution, chi2=0.5 * base.solution.chi2))
    assert worse({"displacement": fine, "absolute": None}, base, base) == worse({}, base, good) == ""
    assert "times the noise of all readings, the model at hand" in worse({"absolute": fine}, good, base)
    for bad in (scores(0.3, 0.2, 0.25), scores(0.2, 0.3, 0.25)):
        note = worse({"displacement": fine, "absolute": bad}, base, base)
        assert "absolute: 0.250 mm, 0.200 mm without" in note and "nothing is added" in note
    model = base.model(UR, {})
    right = diagnose([ill.session], model)
    assert right.verdict == "explained" and [a.effect for a in right.added] == ["payload"]
    monkeypatch.setattr("stiffness.diagnosis.diagnose.worse", lambda *given: "worse")
    said = diagnose([ill.session], model)
    assert said.verdict == "unexplained" and not (said.added or said.changed or said.removed)
    assert said.model is model and "worse" in said.notes and said.residual_sources == right.residual_sources
    after = said.scores["displacement"]
    assert after is not None and after.after == after.before
