"""Stepwise selection: against fits of every subset, known truths, exchanges, and the rate of false positives."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest
from scipy import stats

from stiffness.diagnosis import selection
from stiffness.diagnosis.candidates import Term
from stiffness.diagnosis.selection import CHANCE, STEADY, Selection, Selector, steady
from stiffness.effects import CATALOGUE
from tests.stiffness.diagnosis.random_columns import Columns

Floats = npt.NDArray[np.float64]
SITES = [(e, s) for e in CATALOGUE for s in e.sites(6)]


def terms(*columns: tuple[int, ...], positive: bool = False) -> list[Term]:
    """A term for each group of columns, each at a site of its own."""
    out = []
    for k, group in enumerate(columns):
        effect, site = SITES[k]
        out.append(
            Term(
                effect=effect,
                site=site,
                choice=0,
                extras=False,
                columns=group,
                positive=(positive,) * len(group),
            )
        )
    return out


def selector(data: Columns, *columns: tuple[int, ...]) -> Selector:
    """With the degrees of freedom that the nuisance leaves."""
    return Selector(data.equations(), terms(*columns), len(data.residual) - data.nuisance.shape[1])


def singles(count: int) -> list[tuple[int, ...]]:
    return [(k,) for k in range(count)]


def bic(data: Columns, columns: list[int]) -> float:
    """Difference of the criterion to no term, written out; the noise is widened where the residual asks for it."""
    cost, none = data.refit(columns)[2], data.refit([])[2]
    freedom = len(data.residual) - data.nuisance.shape[1]
    scale = max(1.0, cost / (freedom - len(columns)))
    return (none - cost) / scale - len(columns) * float(np.log(len(data.residual)))


@pytest.mark.parametrize("size", [0.2, 3.0])
def test_terms_together_are_an_explicit_fit(size: float) -> None:
    data = Columns.of(1, weight=np.array([size, 0, -size, 0, 0, size, 0, 0]))
    every = selector(data, (0, 1), (2,), (5, 6, 7))
    for chosen in ([], every.terms[:1], every.terms[1:], every.terms):
        columns = [c for t in chosen for c in t.columns]
        found = every.together(chosen)
        _, weight, cost = data.refit(columns)
        assert found.fit.weight == pytest.approx(weight, rel=1e-6)
        assert found.bic_gain == pytest.approx(bic(data, columns), rel=1e-6, abs=1e-6)
        assert found.scale == pytest.approx(max(1.0, cost / (len(data.residual) - 3 - len(columns))), rel=1e-6)
        for t in chosen:
            mine = [columns.index(c) for c in t.columns]
            assert found.weights(t) == pytest.approx(weight[mine], rel=1e-6)
    with pytest.raises(ValueError, match="not chosen"):
        every.together(every.terms[:1]).weights(every.terms[1])


def test_terms_are_ranked_by_what_they_add() -> None:
    weight = np.array([0.1, -0.6, 0.3, 0.0, 0.25, -0.15, 0.0, 0.45])
    data = Columns.of(4, weight=weight)
    every = selector(data, *singles(8))
    first = every.ranked(every.together([]))
    gains = [data.refit([])[2] - data.refit([t.columns[0] for t in s.terms])[2] for s in first]
    assert gains == sorted(gains, reverse=True)
    assert first[0].terms[0].columns == (1,)
    second = every.ranked(first[0])
    assert len(second) == 7
    assert all(s.terms[0] is first[0].terms[0] for s in second)
    best = min(combinations(range(8), 2), key=lambda c: data.refit(list(c))[2] if 1 in c else np.inf)
    assert {t.columns[0] for t in second[0].terms} == set(best)


@pytest.mark.parametrize("seed", range(8))
def test_the_truth_is_selected(seed: int) -> None:
    """Three of twelve, the weakest about ten standard deviations: these and no others."""
    weight = np.zeros(12)
    rng = np.random.default_rng(seed)
    truth = sorted(rng.choice(12, 3, replace=False).tolist())
    weight[truth] = [0.5, -0.8, 1.5]
    data = Columns.of(seed, weight=weight, count=12, blocks=60)
    found = selector(data, *singles(12)).forward()
    assert sorted(t.columns[0] for t in found.terms) == truth
    assert found.fit.weight[np.argsort([t.columns[0] for t in found.terms])] == pytest.approx(weight[truth], abs=0.25)


def test_a_decoy_that_came_first_is_exchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sum of two causes explains more than either alone; with the second in, the first is better than the sum."""
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(2, 600))
    decoy = a + b + 1.0 * rng.normal(size=600)
    columns = np.column_stack([a, b, decoy, rng.normal(size=(600, 5))])
    data = Columns.of(5, columns, np.array([0.6, 0.6, 0, 0, 0, 0, 0, 0]), blocks=60)
    every = selector(data, *singles(8))
    assert every.ranked(every.together([]))[0].terms[0].columns == (2,)
    assert sorted(t.columns[0] for t in every.forward().terms) == [0, 1]
    monkeypatch.setattr(selection, "MOST", 2)  # no third term that would make it superfluous
    assert sorted(t.columns[0] for t in every.forward().terms) == [0, 1]


def test_a_term_that_others_make_superfluous_is_removed() -> None:
    rng = np.random.default_rng(6)
    a, b = rng.normal(size=(2, 600))
    columns = np.column_stack([a, b, a + b + 0.05 * rng.normal(size=600)])
    data = Columns.of(6, columns, np.array([0.8, 0.8, 0.0]), blocks=60)
    every = selector(data, *singles(3))
    assert {t.columns[0] for t in every._without_superfluous(every.together(every.terms)).terms} in ({0, 1}, {2})


def test_of_clean_residuals_few_select_anything() -> None:
    """200 sets of noise, 30 terms each: the correction for the number tried holds the rate near CHANCE, and
    cross-validation brings it below."""
    found = sum(bool(selector(Columns.of(1000 + k, count=30), *singles(30)).forward().terms) for k in range(200))
    assert found <= stats.binom.ppf(0.999, 200, CHANCE)


def test_more_tried_ask_for_more() -> None:
    """The same term, beside nothing and beside many: significance is corrected for how many could have won."""
    for strength in (3.1, 3.3, 3.5):  # standard deviations, between the limits of one and of ninety terms
        data = Columns.of(3, count=90, blocks=60)
        exact = data.equations()
        sd = 1 / np.sqrt(exact.reduced.curvature[0, 0])
        shift = strength * sd - exact.fit([0], [False]).weight[0]
        moved = Columns(
            nuisance=data.nuisance,
            precision=data.precision,
            candidates=data.candidates,
            residual=data.residual + shift * data.candidates[:, 0],
            block=data.block,
            fold=data.fold,
        )  # fmt: skip
        alone, many = selector(moved, (0,)), selector(moved, *singles(90))
        assert 1 - stats.chi2.cdf(strength**2, 1) < CHANCE < 90 * stats.chi2.sf(strength**2, 1)
        assert not many.beats(many.together(many.terms[:1]), many.together([]))
        gain = alone.cross_validated([]) - alone.cross_validated(alone.terms)
        cheap = strength**2 > np.log(len(data.residual))
        assert alone.beats(alone.together(alone.terms), alone.together([])) == (steady(gain) and cheap)


def test_what_does_not_hold_in_cross_validation_is_not_selected() -> None:
    """A column that explains one fold alone is significant, and says nothing of the others."""
    data = Columns.of(8, blocks=60)
    one = np.where(data.fold == 2, 1.0, 0.0)[:, None] * np.random.default_rng(0).normal(size=(len(data.fold), 1))
    columns = np.hstack([one, data.candidates[:, 1:]])
    spoiled = Columns(
        nuisance=data.nuisance,
        precision=data.precision,
        candidates=columns,
        residual=data.residual + 1.5 * one[:, 0],
        block=data.block,
        fold=data.fold,
    )
    every = selector(spoiled, *singles(8))
    first, none = every.together(every.terms[:1]), every.together([])
    assert stats.chi2.sf(first.fit.gain, 1) * every.tried < 1e-6
    assert first.bic_gain > 0
    assert not every.beats(first, none)
    assert every.forward().terms == ()


def test_a_misfit_that_no_term_explains_widens_the_noise() -> None:
    """Of a residual three times the noise a term that would be significant beside the noise alone is not."""
    data = Columns.of(2, weight=np.array([0.3, 0, 0, 0, 0, 0, 0, 0]), blocks=60)
    wide = Columns(
        nuisance=data.nuisance,
        precision=data.precision,
        candidates=data.candidates,
        residual=3 * data.residual,
        block=data.block,
        fold=data.fold,
    )
    narrow_selector, wide_selector = selector(data, *singles(8)), selector(wide, *singles(8))
    for s in (narrow_selector, wide_selector):
        found = s.together(s.terms[:1])
        assert (found.fit.gain / found.scale) == pytest.approx(
            data.refit([])[2] - data.refit([0])[2], rel=0.2
        )
    assert wide_selector.together([]).scale == pytest.approx(9 * narrow_selector.together([]).scale, rel=0.1)


@pytest.mark.parametrize(
    ("gain", "expected"),
    [
        ([1.0, 1.0, 1.0], True),
        ([0.0, 0.0, 0.0], False),
        ([-1.0, -1.0, -1.0], False),
        ([10.0, 0.0, 0.0, 0.0, 0.0], False),  # one fold alone
        ([3.0], False),  # one fold tells nothing of its scatter
        ([1e5, 5.0, 4.0, 2.0, 4.0, 3.0, 4.0, 7.0], True),  # all gain, one beyond all measure
        ([1e5, 5.0, 4.0, 2.0, 4.0, -3.0, 4.0, 7.0], False),
        ([1e5, 5.0, 4.0, 2.0], False),  # four gain by chance once in 16 times
        ([1e5, 20.0, 4.0, 2.0, 0.1, 0.3, 4.0, 7.0], False),  # without the largest, not clearly
    ],
)
def test_steady_by_hand(gain: list[float], expected: bool) -> None:
    assert steady(np.array(gain)) is expected


def test_steady_counts_standard_errors_of_the_mean() -> None:
    rng = np.random.default_rng(3)
    for _ in range(200):
        gain = rng.normal(rng.uniform(-1, 2), 1.0, rng.integers(2, 12))
        rest = np.delete(gain, gain.argmax())
        every = len(gain) >= 7 and bool((gain > 0).all()) and rest.mean() > 2 * STEADY * stats.sem(rest)
        assert steady(gain) == (every or gain.mean() > STEADY * stats.sem(gain))


def test_a_selection_names_what_it_is_made_of() -> None:
    data = Columns.of(1)
    every = selector(data, (0,), (1,))
    found = every.together(every.terms)
    assert isinstance(found, Selection)
    assert [t.key for t in found.terms] == [(t.effect.name, t.site.where) for t in found.terms]
    assert str(found.terms[0]) == f"{found.terms[0].effect.name} in joint-1"
