"""Search: what it may look for, the linearised gain against a fit, sites that are left empty, and what it finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from stiffness.diagnosis.added_effects import Addition, ModelFits, at_values_of, merged, with_sites
from stiffness.diagnosis.adoption import adopted, pruned, site_chance
from stiffness.diagnosis.candidates import columns_of
from stiffness.diagnosis.linearisation import FOLDS, WARMED, folds
from stiffness.diagnosis.search import Search
from stiffness.diagnosis.searched_numbers import (
    searched_deviations,
    with_better_numbers,
    with_final_numbers,
    with_number,
)
from stiffness.effects import BASE, BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.session.session import Session
from tests.stiffness.diagnosis.sick import Sick, sick


def addition(name: str, *where: str) -> Addition:
    """An effect at named places, at values without effect."""
    effect = BY_NAME[name]
    sites = tuple(s for s in effect.sites(6) if set(s.where) <= set(where)) if where else effect.sites(6)
    begun = {p.name: np.full(p.count(6), p.start) for p in effect.parameters}
    return with_sites(Addition(effect, sites, frozenset(), begun), 6)


# ---- what may be looked for


def searched(session: Session, base: tuple[Effect, ...] = (BASE,)) -> set[str]:
    model = sick("clean").fits
    fits = ModelFits.of([session], base, model.values, [np.ones(len(session), dtype=bool)])
    return {e.name for e in Search(fits, (), lambda text: None).effects}


def test_only_what_the_sessions_could_show_is_looked_for() -> None:
    session = sick("clean").session
    s = session.samples
    every = searched(session)
    setups = len(np.unique(s.setup))
    shown = [e for e in CATALOGUE if not e.is_base and e.scope != "process"]  # no process acts in a session
    assert every == {e.name for e in shown if all(p.each <= setups for p in e.parameters if not p.extra)}
    timeless = replace(session, samples=replace(s, time=np.full(len(s), np.nan)))
    assert every - searched(timeless) == {"tracker-drift"}
    even = replace(session, samples=replace(s, temperature=20 + 0.9 * WARMED * (np.arange(len(s)) % 2)))
    assert every - searched(even) == {e.name for e in CATALOGUE if e.thermal}
    unloaded = replace(session, wrench_frame=None)
    assert every - searched(unloaded) == {"force-sensor-bias"}


def test_what_the_model_has_is_not_looked_for() -> None:
    gap = BY_NAME["backlash"]
    whole = sick("clean")
    values = {**whole.fits.values, "backlash": gap.neutral(6)}
    fits = ModelFits(
        data=whole.fits.data,
        base=(BASE, gap),
        values=values,
        used=whole.fits.used,
        allowed=whole.fits.allowed,
    )
    assert "backlash" not in {e.name for e in Search(fits, (), lambda text: None).effects}


def test_setups_are_dealt_to_folds_in_turn() -> None:
    session = sick("clean").session
    setup = session.samples.setup
    order = list(dict.fromkeys(setup.tolist()))
    for row in range(0, len(session), 13):
        assert folds(session)[row] == order.index(int(setup[row])) % FOLDS


# ---- the linearised model


@pytest.mark.parametrize(
    ("scenario", "term"),
    [("base-compliance", ("base-compliance", "base")), ("payload", ("payload", "tool")),
     ("backlash joint-3", ("backlash", "joint-3"))],
)  # fmt: skip
def test_the_linearised_gain_is_about_that_of_a_fit(scenario: str, term: tuple[str, str]) -> None:
    ill = sick(scenario)
    linear = ill.search.linearisation.at(ill.base, [])
    name, where = term
    terms = [t for t in linear.selector.terms if t.effect.name == name and where in t.site.where and not t.extras]
    chosen = max((linear.selector.together([t]) for t in terms), key=lambda c: c.fit.gain)
    more, fit = adopted(ill.fits, linear, chosen, [])
    gained = ill.base.solution.chi2 - fit.solution.chi2
    assert chosen.fit.gain > 100
    assert chosen.fit.gain == pytest.approx(gained, rel=0.12)
    assert [(a.effect.name, a.where) for a in more] == [(name, terms[0].site.where)]
    assert all(np.array_equal(more[0].values[k], v) for k, v in fit.values()[name].items())


def test_a_linearisation_leaves_the_fit_as_it_is() -> None:
    ill = sick("payload")
    before = [s.x.copy() for s in ill.base.states]
    linear = ill.search.linearisation.at(ill.base, [])
    assert all(np.array_equal(a, s.x) for a, s in zip(before, ill.base.states, strict=True))
    assert linear.fit is not ill.base and linear.fit.solution is ill.base.solution
    again = ill.search.linearisation.at(ill.base, [])
    assert again.selector.equations.reduced.chi2 == linear.selector.equations.reduced.chi2
    # the residual's own chi-square, with a little freedom for the numbers of the fit
    assert linear.selector.equations.reduced.chi2 == pytest.approx(ill.base.solution.chi2, rel=1e-3)
    assert linear.selector.equations.count == ill.base.solution.count


def test_what_was_added_is_no_term_any_more() -> None:
    ill = sick("base-compliance")
    added = [addition("base-compliance", "base")]
    fit = ill.fits.fit(added, ill.base)
    linear = ill.search.linearisation.at(fit, at_values_of(fit, added))
    left = [t for t in linear.selector.terms if t.effect.name == "base-compliance"]
    assert all(linear.columns[k].number.parameter.extra for t in left for k in t.columns)
    assert {t.effect.name for t in linear.selector.terms} >= {"backlash", "payload"}


# ---- pruning


def test_empty_sites_are_pruned_and_the_true_one_stays() -> None:
    ill = sick("backlash joint-3")
    found = [addition("backlash", "joint-3", "joint-5"), addition("payload", "tool")]
    fit = ill.fits.fit(found, ill.base)
    kept, less = pruned(ill.fits, at_values_of(fit, found), fit)
    assert [(a.effect.name, a.where) for a in kept] == [("backlash", ("joint-3",))]
    assert less.solution.chi2 - fit.solution.chi2 < stats.chi2.isf(1e-3, 3) * fit.solution.misfit**2
    assert len(less.unknowns) == 6 + 1


def test_the_chance_of_a_site_is_that_of_the_chi_square_that_it_saves() -> None:
    """Wald's statistic against the likelihood ratio of the fit without it."""
    clean = sick("clean")
    found = [addition("payload", "tool")]
    fit = clean.fits.fit(found, clean.base)
    chance = site_chance(clean.fits, fit, found[0], found[0].sites[0])
    saved = clean.base.solution.chi2 - fit.solution.chi2
    assert chance == pytest.approx(stats.chi2.sf(saved, 1), abs=0.05)
    assert chance > 1e-3


# ---- what it finds


@pytest.mark.parametrize(
    ("scenario", "expected"),
    [
        ("clean", []),
        ("base-compliance", [("base-compliance", ("base",))]),
        ("backlash joint-3", [("backlash", ("joint-3",))]),
    ],
)
def test_a_search_adds_what_is_there(scenario: str, expected: list[tuple[str, tuple[str, ...]]]) -> None:
    told: list[str] = []
    ill: Sick = sick(scenario)
    search = Search(ill.fits, (), told.append)
    linear = search.linearisation.at(ill.base, [])
    fit, additions = search.run(linear, search.beginnings(linear))
    assert [(a.effect.name, a.where) for a in additions] == expected
    assert bool(told) == bool(expected)
    if expected:
        assert fit.solution.misfit == 1.0
        assert fit.solution.chi2 < 0.7 * ill.base.solution.chi2
    else:
        assert fit.solution is ill.base.solution


# ---- additions


def test_values_are_neutral_wherever_an_addition_is_not() -> None:
    a = addition("backlash", "joint-2", "joint-4")
    assert (a.values["gap_rad"] > 0).tolist() == [False, True, False, True, False, False]
    less = a.without(a.sites[0], 6)
    assert less is not None and less.where == ("joint-4",)
    assert (less.values["gap_rad"] > 0).tolist() == [False, False, False, True, False, False]
    assert less.without(less.sites[0], 6) is None
    assert [str(u) for u in less.numbers(6)] == ["backlash.gap_rad[4]"]


def test_a_term_is_merged_into_an_addition_of_its_effect() -> None:
    columns, terms = columns_of([BY_NAME["backlash"]], 6, np.full(6, 100.0))
    first, second = (next(t for t in terms if t.site.where == (j,)) for j in ("joint-4", "joint-1"))
    more = merged(old=[], term=first, columns=columns, weight=np.array([3e-5]), joints=6)
    more = merged(old=more, term=second, columns=columns, weight=np.array([1e-5]), joints=6)
    (one,) = more
    assert one.where == ("joint-1", "joint-4")
    assert one.values["gap_rad"] == pytest.approx([1e-5, 0, 0, 3e-5, 0, 0])


def test_fits_share_what_they_can_and_hold_what_they_are_told() -> None:
    ill = sick("backlash joint-3")
    found = [addition("backlash", "joint-3")]
    free = ill.fits.fit(found, ill.base)
    (gap,) = (k for k, u in enumerate(free.unknowns.free) if u.effect == "backlash")
    assert len(free.unknowns) == 7
    fixed = ill.fits.fit(found, ill.base, base_fixed=True)
    assert {u.effect for u in fixed.unknowns.free} == {"backlash"}
    assert fixed.values()[BASE.name]["k_nm_per_rad"].tolist() == ill.fits.values[BASE.name]["k_nm_per_rad"].tolist()
    # a profile: chi-square rises by the square of the distance in standard deviations
    rises = []
    for share in (0.95, 1.05):
        other = [with_number(found[0], "gap_rad", 2, share * float(free.parameters[gap]))]
        held = ill.fits.fit(other, free, held=("backlash",))
        assert {u.effect for u in held.unknowns.free} == {BASE.name}
        rises.append(held.solution.chi2 - free.solution.chi2)
    away = 0.05 * free.parameters[gap] / np.sqrt(free.solution.covariance[gap, gap])
    assert min(rises) > 0.5 * away**2
    assert np.mean(rises) == pytest.approx(away**2, rel=0.15)


def test_values_that_an_effect_does_not_allow_are_moved_and_held() -> None:
    """A tool compliance whose matrix is not positive is moved to the nearest that is; all else is fitted to it."""
    clean = sick("clean")
    tool = BY_NAME["tool-compliance"]
    fit = clean.fits.fit([addition("tool-compliance")], clean.base)
    assert tool.nearest is not None
    wrong = bool(tool.check(fit.values()["tool-compliance"]))
    allowed = clean.fits.within_limits(fit, [addition("tool-compliance")])
    assert wrong == (allowed is not fit)
    assert tool.check(allowed.values()["tool-compliance"]) == ""
    if wrong:
        assert {u.effect for u in allowed.unknowns.free} == {BASE.name}


# ---- switching torques


def test_a_switching_torque_is_found_between_the_torques_that_were_read() -> None:
    """Any torque carries the truth's gap across; begun with a torque that never does, the search lowers it."""
    ill = sick("backlash joint-1 any torque carries")
    wrong = with_number(addition("backlash", "joint-1"), "breakaway_nm", 0, 1e4)
    fit = ill.fits.fit([wrong], ill.base)
    better = with_better_numbers(fit, at_values_of(fit, [wrong]))
    assert better is not None
    torque = np.abs(fit.sessions[0].predicted.torque[:, 0])
    found = float(better[0].values["breakaway_nm"][0])
    felt = torque[torque > 1e-6]
    assert 0 < found < np.quantile(felt, 0.3)
    again = ill.fits.fit(better, fit)
    assert again.solution.chi2 < fit.solution.chi2 - 100
    # none of a comb of values, each fitted, is much better
    tried = [with_number(better[0], "breakaway_nm", 0, float(t)) for t in np.quantile(felt, [0.1, 0.5, 0.9])]
    comb = [ill.fits.fit([t], fit) for t in tried]
    assert again.solution.chi2 < min(f.solution.chi2 for f in comb) + 0.02 * fit.solution.chi2
    assert np.array_equal(wrong.values["breakaway_nm"][:1], [1e4])


def test_where_nothing_switches_there_is_nothing_to_search() -> None:
    clean = sick("clean")
    found = [addition("payload", "tool")]
    fit = clean.fits.fit(found, clean.base)
    assert with_better_numbers(fit, found) is None


def test_a_torque_that_no_reading_reaches_is_known_from_below() -> None:
    """No torque carries the gap: the interval of the breakaway torque goes down to the largest torque, not further."""
    ill = sick("backlash joint-5 no torque carries")
    found = [addition("backlash", "joint-5")]
    found[0].values["breakaway_nm"][4] = 1e5
    fit = ill.fits.fit(found, ill.base)
    sd = searched_deviations(fit, at_values_of(fit, found))["backlash"]["breakaway_nm"][4]
    largest = np.abs(fit.sessions[0].predicted.torque[:, 4]).max()
    assert 0.0 <= 1e5 - 1.96 * sd < 1.01 * largest


def test_the_interval_of_a_searched_number_is_that_of_refits() -> None:
    """Half the range of breakaway torques whose refit is within 3.84 of the best chi-square, over 1.96."""
    ill = sick("backlash joint-3")
    found = [addition("backlash", "joint-3")]
    fit = ill.fits.fit(found, ill.base)
    for _ in range(2):
        better = with_better_numbers(fit, at_values_of(fit, found))
        if better is None:
            break
        found, fit = better, ill.fits.fit(better, fit)
    sd = searched_deviations(fit, at_values_of(fit, found))["backlash"]
    torque = np.unique(np.abs(fit.sessions[0].predicted.torque[:, 2]))
    low, high = torque[:-1], torque[1:]
    near = np.abs(low - found[0].values["breakaway_nm"][2]) < 6 * max(float(sd["breakaway_nm"][2]), 1.0)
    inside = []
    for a, b in zip(low[near], high[near], strict=True):
        trial = [with_number(found[0], "breakaway_nm", 2, float(0.5 * (a + b)))]
        if ill.fits.fit(trial, fit).solution.chi2 < fit.solution.chi2 + 3.84 * fit.solution.misfit**2:
            inside += [a, b]
    width = (max(inside) - min(inside)) / (2 * 1.96)
    assert 0.5 * width < sd["breakaway_nm"][2] < 4 * width  # linearised, and of ranges that hold several torques
    assert sd["breakaway_nm"][2] < 0.2 * torque[-1]
    assert np.all(sd["breakaway_nm"][[0, 1, 3, 4, 5]] == 0)
    assert sd["side"][2] in (0.0, pytest.approx(1 / 1.96, rel=1e-3))  # a choice is known, or it is open


def test_a_switching_torque_stands_in_the_middle_of_those_that_leave_as_little() -> None:
    """Begun at the lower end: between two torques of the readings nothing tells values apart."""
    ill = sick("backlash joint-3")
    found = [addition("backlash", "joint-3")]
    fit = ill.fits.fit(found, ill.base)
    found = with_final_numbers(fit, at_values_of(fit, found)) or found
    fit = ill.fits.fit(found, fit)
    torque = np.unique(np.abs(fit.sessions[0].predicted.torque[:, 2]))
    own = int(np.searchsorted(torque, found[0].values["breakaway_nm"][2]))
    alike = []
    for k in range(max(own - 8, 1), min(own + 8, len(torque))):
        trial = [with_number(found[0], "breakaway_nm", 2, float(0.5 * (torque[k - 1] + torque[k])))]
        if ill.fits.fit(trial, fit).solution.chi2 < fit.solution.chi2 + fit.solution.misfit**2:
            alike += [torque[k - 1], torque[k]]
    low, high = min(alike), max(alike)
    begun = [with_number(found[0], "breakaway_nm", 2, float(0.99 * low + 0.01 * high))]
    again = with_final_numbers(ill.fits.fit(begun, fit), begun)
    assert again is not None
    middle = float(again[0].values["breakaway_nm"][2])
    assert middle == pytest.approx(0.5 * (low + high), abs=0.25 * (high - low))
