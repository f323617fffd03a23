"""Alternatives: what explains the same readings as well, and every effect by itself, against fits of each."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.diagnosis.added_effects import Addition, at_values_of, with_sites
from stiffness.diagnosis.alternatives import BETTER, ODDS, candidates, with_alternatives, within
from stiffness.diagnosis.candidates import Term
from stiffness.diagnosis.search import Linearised
from stiffness.diagnosis.selection import Selector
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from tests.stiffness.diagnosis.random_columns import Columns
from tests.stiffness.diagnosis.sick import Sick, sick


def addition(name: str, *where: str) -> Addition:
    effect = BY_NAME[name]
    sites = tuple(s for s in effect.sites(6) if not where or set(s.where) <= set(where))
    begun = {p.name: np.full(p.count(6), p.start) for p in effect.parameters}
    extras = frozenset(sites if any(p.extra for p in effect.parameters) else ())
    return with_sites(Addition(effect, sites, extras, begun), 6)


def bic(fit: Fit, misfit: float) -> float:
    return fit.solution.chi2 / misfit**2 + len(fit.unknowns) * float(np.log(fit.solution.count))


def added(ill: Sick, *found: Addition) -> tuple[Fit, list[Addition]]:
    fit = ill.fits.fit(list(found), ill.base)
    return fit, at_values_of(fit, found)


# ---- every effect by itself


def ranking(data: Columns, owner: list[str]) -> Linearised:
    """A linearised model whose columns belong to named effects, one site each."""
    terms, seen = [], dict[str, int]()
    for k, name in enumerate(owner):
        effect = BY_NAME[name]
        site = effect.sites(6)[seen.setdefault(name, 0)]
        seen[name] += 1
        terms.append(
            Term(effect=effect, site=site, choice=0, extras=False, columns=(k,), positive=(False,))
        )
    selector = Selector(data.equations(), terms, len(data.residual) - 3)
    return Linearised(sick("clean").base, (), selector)


OWNER = ["backlash", "backlash", "payload", "base-compliance", "joint-friction", "joint-friction"]
OWNER += ["thermal-drift", "tracker-drift"]


def test_every_effect_is_ranked_by_what_it_predicts_of_left_out_folds() -> None:
    weight = np.array([0.5, 0.7, 0.2, 0, 0, 0.4, 0, 0])
    data = Columns.of(3, weight=weight, blocks=60)
    linear = ranking(data, OWNER)
    names = list(dict.fromkeys(OWNER))
    found, none = candidates([BY_NAME[n] for n in names], linear)
    folds = range(5)
    noise = float(np.sqrt(np.mean(np.concatenate([s.samples.sd[s.used] for s in linear.fit.sessions]) ** 2)))

    def rms(columns: list[int]) -> float:
        return noise * float(np.sqrt(sum(data.left_out(columns, k) for k in folds) / len(data.residual)))

    assert none == pytest.approx(rms([]), rel=1e-8)
    mine = {c.effect: [k for k, n in enumerate(OWNER) if n == c.effect] for c in found}
    for c in found:
        used = [k for k in mine[c.effect] if linear.selector.terms[k].site.where[0] in c.where]
        assert c.heldout_rms == pytest.approx(rms(used), rel=1e-8)
    assert [c.heldout_rms for c in found] == sorted(c.heldout_rms for c in found)
    assert found[0].effect == "backlash" and len(found[0].where) == 2
    assert next(c for c in found if c.effect == "tracker-drift").heldout_rms >= none
    assert all(c.confused_with == () for c in found if c.effect == "backlash")


def test_effects_with_the_same_column_are_not_told_apart() -> None:
    rng = np.random.default_rng(1)
    one = rng.normal(size=(900, 8))
    one[:, 3] = one[:, 0] + 0.01 * rng.normal(size=900)
    data = Columns.of(1, one, np.array([0.6, 0, 0, 0, 0, 0, 0, 0]), blocks=60)
    found, _ = candidates([BY_NAME[n] for n in dict.fromkeys(OWNER)], ranking(data, OWNER))
    confused = {c.effect: c.confused_with for c in found}
    assert "base-compliance" in confused["backlash"] and "backlash" in confused["base-compliance"]
    assert "payload" not in confused["backlash"]


def test_sites_of_an_effect_are_taken_while_they_lower_the_criterion() -> None:
    data = Columns.of(5, weight=np.array([0.6, 0, 0, 0, 0.05, 0.5, 0, 0]), blocks=60)
    owner = ["backlash"] * 6 + ["payload", "tracker-drift"]
    linear = ranking(data, owner)
    chosen = within(linear.selector, BY_NAME["backlash"])
    columns = sorted(t.columns[0] for t in chosen.terms)
    assert columns[0] == 0 and columns[-1] == 5
    cost = np.log(len(data.residual))
    here = data.refit(columns)[2]
    for k in range(6):
        other = sorted({*columns, k}) if k not in columns else [c for c in columns if c != k]
        assert data.refit(other)[2] + cost * (len(other) - len(columns)) > here - 1e-6
    assert within(linear.selector, BY_NAME["joint-hardening"]).terms == ()


# ---- in an addition's place


@pytest.mark.parametrize("scenario", ["base-compliance"])
def test_what_stands_is_compared_with_all_others_in_its_place(scenario: str) -> None:
    ill = sick(scenario)
    fit, found = added(ill, addition("base-compliance", "base"))
    after, kept, alternatives = with_alternatives(ill.search, fit, found, ill.base)
    assert after is fit and kept is found
    (one,) = alternatives
    assert one.addition is found[0]
    above = ill.base.solution.chi2 - ill.base.solution.freedom
    assert one.explains == pytest.approx(min((ill.base.solution.chi2 - fit.solution.chi2) / above, 1.0))
    assert one.explains > 0.95
    for name, other in one.fits.items():
        assert name != "base-compliance"
        assert {u.effect for u in other.unknowns.free} == {"joint-stiffness", name}
        assert bic(other, fit.solution.misfit) < bic(fit, fit.solution.misfit) + ODDS


def test_a_better_effect_takes_the_place() -> None:
    """A payload is put where the base yields: the base explains more, and takes its place."""
    ill = sick("base-compliance")
    fit, found = added(ill, addition("payload", "tool"))
    after, kept, alternatives = with_alternatives(ill.search, fit, found, ill.base)
    assert [a.effect.name for a in kept] == ["base-compliance"]
    assert bic(after, fit.solution.misfit) < bic(fit, fit.solution.misfit) - BETTER
    assert after.solution.chi2 < 0.8 * fit.solution.chi2
    (one,) = alternatives
    assert one.addition.effect.name == "base-compliance"
    assert "payload" not in one.fits
    assert found[0].effect.name == "payload"  # what was given is as it was


def test_of_two_additions_each_is_compared_beside_the_other() -> None:
    ill = sick("base-compliance")
    fit, found = added(ill, addition("base-compliance", "base"), addition("backlash", "joint-2"))
    _, kept, alternatives = with_alternatives(ill.search, fit, found, ill.base)
    explains = {a.addition.effect.name: a.explains for a in alternatives}
    assert explains["base-compliance"] > 0.9
    assert explains["backlash"] < 0.05
    assert [a.where for a in kept] == [("base",), ("joint-2",)]
