"""What stands beside structure that is left, and which additions are only the rest of another law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, at_values_of, with_sites
from stiffness.diagnosis.alternatives import Alternatives, explained_at_last
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.diagnosis.searched_numbers import with_better_numbers
from stiffness.diagnosis.structure import _seen, standing, without_crumbs
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from tests.stiffness.diagnosis.sick import KUKA, UR, Sick, sick


def addition(name: str, *where: str) -> Addition:
    """The simple form of an effect at some sites, begun where its numbers begin."""
    effect = BY_NAME[name]
    sites = tuple(s for s in effect.sites(6) if not where or set(s.where) <= set(where))
    begun = {p.name: np.full(p.count(6), p.start) for p in effect.parameters}
    return with_sites(Addition(effect, sites, frozenset(), begun), 6)


def fitted(ill: Sick, *added: Addition) -> tuple[Fit, list[Addition]]:
    """With the numbers that no derivative leads to."""
    fit = ill.fits.fit(list(added), ill.base)
    found = at_values_of(fit, added)
    for _ in range(2):
        if (better := with_better_numbers(fit, found)) is None:
            break
        fit = ill.fits.fit(better, fit)
        found = at_values_of(fit, better)
    return fit, found


def above(fit: Fit) -> float:
    return fit.solution.chi2 - fit.solution.freedom


def test_no_effect_stands_beside_one_source_that_explains_all_of_it() -> None:
    """A base that yields takes a third of what a brake does at joint 2, which explains all of it without the base."""
    ill = sick("unknown brake", KUKA, seed=1)
    fit, found = fitted(ill, addition("base-compliance"))
    assert 0.2 < 1 - above(fit) / above(ill.base) < 0.6
    stand = standing(ill.search, base=ill.base, fit=fit, additions=found, found=[])
    assert stand.additions == [] and stand.structure.left
    assert stand.structure.sources[0].what == "joint-2"
    (note,) = stand.structure.notes
    assert "base-compliance" in note and "not added" in note


def test_a_true_effect_stands_beside_another_source() -> None:
    """The base does yield: what the brake does explains no more than its own part."""
    ill = sick("base-compliance + unknown brake", KUKA, seed=1)
    fit, found = fitted(ill, addition("base-compliance"))
    stand = standing(ill.search, base=ill.base, fit=fit, additions=found, found=[])
    assert [a.effect.name for a in stand.additions] == ["base-compliance"]
    assert stand.structure.left and stand.structure.sources[0].what == "joint-2"


def test_of_two_doubtful_effects_the_one_that_explains_less_goes_first() -> None:
    """A joint that drifts took a part of what the brake does; without it the base is no longer doubtful."""
    ill = sick("base-compliance + unknown brake", KUKA, seed=1)
    fit, found = fitted(ill, addition("base-compliance"), addition("thermal-drift", "joint-2"))
    stand = standing(ill.search, base=ill.base, fit=fit, additions=found, found=[])
    assert [a.effect.name for a in stand.additions] == ["base-compliance"]
    assert any("thermal-drift in joint-2" in n for n in stand.structure.notes)


def test_a_link_that_polishes_the_simple_law_of_the_tool_gives_way_to_the_richer_one() -> None:
    ill = sick("backlash joint-1 + tool-compliance", KUKA, seed=1)
    fit, found = fitted(
        ill, addition("backlash", "joint-1"), addition("tool-compliance"), addition("link-compliance", "link-5")
    )
    less, stand = without_crumbs(ill.search, fit, found, [Alternatives(found[2], 0.01, {})])
    assert {a.effect.name: len(a.extras) for a in stand} == {"backlash": 0, "tool-compliance": 1}
    assert less.solution.chi2 <= fit.solution.chi2


def test_a_small_cause_of_its_own_stays() -> None:
    """No richer law of the tool does what a link nearer to the base does."""
    ill = sick("link-compliance link-2", KUKA, seed=1)
    fit, found = fitted(ill, addition("tool-compliance"), addition("link-compliance", "link-2"))
    same, stand = without_crumbs(ill.search, fit, found, [Alternatives(found[1], 0.01, {})])
    assert [a.effect.name for a in stand] == ["tool-compliance", "link-compliance"]
    assert same.solution.chi2 == pytest.approx(fit.solution.chi2)


def test_no_sensor_takes_in_what_an_unknown_load_does() -> None:
    """An undeclared mass, without the effect of its own: zero shift, scale and misalignment of a sensor explain seven
    tenths of it, and no other effect half as much."""
    ill = sick("payload", UR, seed=1, size=6.0)
    sensor = addition("force-sensor-bias")
    askew = {**sensor.values, "in_tool_axes": np.ones(1)}
    fit, found = fitted(ill, replace(sensor, values=askew, extras=frozenset(sensor.sites)))
    assert 0.6 < 1 - above(fit) / above(ill.base) < 0.8
    ahead = Alternatives(found[0], 0.7, {}, held_out=0.7, runner_up=0.1)
    stand = standing(ill.search, base=ill.base, fit=fit, additions=found, found=[ahead])
    assert stand.additions == [] and stand.structure.left
    assert any("force-sensor-bias" in n and "not added" in n for n in stand.structure.notes)


def test_what_an_effect_explains_is_told_beside_those_that_stayed() -> None:
    """A tool that yields took part of what link 2 does, and was left out."""
    ill = sick("link-compliance link-2", KUKA, seed=1)
    fit, found = fitted(ill, addition("link-compliance", "link-2"))
    before = [Alternatives(found[0], 0.3, {}), Alternatives(addition("tool-compliance"), 0.01, {})]
    (own,) = explained_at_last(ill.search, fit, found, base=ill.base, found=before)
    assert own.addition is found[0]
    assert own.explains == pytest.approx((ill.base.solution.chi2 - fit.solution.chi2) / above(ill.base), rel=1e-9)
    assert explained_at_last(ill.search, fit, found, base=ill.base, found=before[:1])[0].explains == 0.3


def test_a_law_is_right_to_a_trifle_only_where_all_readings_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Readings that took no part in the choice are left with no more than those that did."""
    ill = sick("base-compliance", KUKA, seed=1)
    fit, found = fitted(ill, addition("base-compliance"))

    def leaving(noises: float) -> Fit:
        return replace(fit, solution=replace(fit.solution, chi2=noises**2 * fit.solution.freedom))

    slight, first = leaving(1.2), leaving(6.0)
    monkeypatch.setattr("stiffness.diagnosis.structure._sources", lambda search, fit: [ResidualSource("base", 0.9)])
    for of_all, stands in ((1.25, True), (1.5, False)):
        monkeypatch.setattr(
            "stiffness.diagnosis.structure.of_all_readings", lambda fits, *given, left=of_all: (fits, leaving(left))
        )
        now = _seen(ill.search, first, slight, found).structure
        assert any("not to the last digit" in note for note in now.notes) == stands
        assert now.left != stands
