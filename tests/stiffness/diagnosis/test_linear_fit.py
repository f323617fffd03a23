"""Linear fits from sums of products: against explicit refits of all the data, and of every fold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize

from stiffness.diagnosis.linear_fit import SINGULAR
from tests.stiffness.diagnosis.random_columns import Columns
from tests.stiffness.numerics.nist_strd import LONGLEY, LONGLEY_CERTIFIED, LONGLEY_RESIDUAL_SD, LONGLEY_SD

CHOICES = [[0], [3, 1], [0, 2, 5, 7], list(range(8))]


@pytest.mark.parametrize("columns", CHOICES, ids=str)
@pytest.mark.parametrize("seed", range(4))
def test_a_fit_is_that_of_an_explicit_refit(seed: int, columns: list[int]) -> None:
    data = Columns.of(seed, weight=np.linspace(-1, 1, 8) * 0.3)
    equations = data.equations()
    _, weight, cost = data.refit(columns)
    _, _, none = data.refit([])
    fit = equations.fit(columns, [False] * len(columns))
    assert fit.weight == pytest.approx(weight, rel=1e-7, abs=1e-9)
    assert fit.gain == pytest.approx(none - cost, rel=1e-7)
    assert fit.rank == len(columns)
    assert equations.reduced.chi2 == pytest.approx(none, rel=1e-9)
    assert equations.count == len(data.residual)


@pytest.mark.parametrize("columns", CHOICES, ids=str)
@pytest.mark.parametrize("seed", range(4))
def test_cross_validation_is_a_refit_without_each_fold(seed: int, columns: list[int]) -> None:
    data = Columns.of(seed, weight=np.linspace(-1, 1, 8) * 0.3)
    found = data.equations().cross_validated(columns, [False] * len(columns))
    assert found == pytest.approx([data.left_out(columns, k) for k in range(5)], rel=1e-7)
    assert found.sum() > data.refit(columns)[2]  # unseen readings are predicted less well


def test_cross_validation_without_columns_fits_the_nuisance_only() -> None:
    data = Columns.of(9)
    found = data.equations().cross_validated([], [])
    assert found == pytest.approx([data.left_out([], k) for k in range(5)], rel=1e-8)
    assert [f.count for f in data.equations().folds] == [int(np.sum(data.fold == k)) for k in range(5)]


def test_the_score_of_a_fold_holds_for_any_weights() -> None:
    data, columns = Columns.of(2), [1, 4]
    weight = np.array([0.7, -1.9])
    for k, fold in enumerate(data.equations().folds):
        assert fold.score(np.array(columns), weight) == pytest.approx(data.left_out(columns, k, weight), rel=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_what_cannot_be_negative_is_not(seed: int) -> None:
    """Against bounded least squares on independent columns, where the order in which they are dropped is no matter."""
    rng = np.random.default_rng(seed)
    truth = rng.normal(size=8)
    data = Columns.of(seed, weight=truth)
    equations, positive = data.equations(), [True, False] * 4
    fit = equations.fit(list(range(8)), positive)
    curvature, slope = equations.reduced.curvature, equations.reduced.slope
    root = np.linalg.cholesky(curvature).T
    low = np.where(positive, 0.0, -np.inf)
    exact = optimize.lsq_linear(root, np.linalg.solve(root.T, slope), (low, np.inf), tol=1e-14).x
    assert fit.weight == pytest.approx(exact, abs=1e-5)
    assert np.all(fit.weight[::2] >= 0) and (fit.weight[::2] == 0).any()
    kept = [k for k in range(8) if fit.weight[k] != 0]
    assert fit.gain == pytest.approx(equations.fit(kept, [False] * len(kept)).gain, rel=1e-9)
    assert fit.rank == len(kept)


def test_all_negative_leaves_nothing() -> None:
    data = Columns.of(1, weight=np.full(8, -2.0))
    fit = data.equations().fit([0, 1, 2], [True] * 3)
    assert (fit.gain, fit.rank) == (0.0, 0)
    assert np.all(fit.weight == 0)


def test_columns_that_depend_on_each_other_share_their_weight() -> None:
    """A column twice, once in other units; one that nuisance explains; one of zeros: rank and gain of what is left."""
    rng = np.random.default_rng(3)
    data = Columns.of(3, weight=np.eye(8)[0] * 0.8)
    same = 1e-4 * data.candidates[:, 0]
    known = data.nuisance[:, 1] * 0.01
    wide = np.column_stack([data.candidates, same, known, np.zeros(len(same))])
    more = Columns(
        nuisance=data.nuisance,
        precision=data.precision * 0 + 1e-12,
        candidates=wide,
        residual=data.residual,
        block=data.block,
        fold=data.fold,
    )
    equations = more.equations()
    alone, twice = equations.fit([0], [False]), equations.fit([0, 8], [False, False])
    assert (alone.rank, twice.rank) == (1, 1)
    assert twice.gain == pytest.approx(alone.gain, rel=1e-6)
    assert twice.weight[0] + 1e-4 * twice.weight[1] == pytest.approx(alone.weight[0], rel=1e-6)
    assert equations.fit([9], [False]).gain == pytest.approx(0, abs=1e-3)
    assert equations.fit([10], [False]).gain == 0.0
    slightly = data.candidates[:, 0] + 0.3 * np.sqrt(SINGULAR) * rng.normal(size=len(same))
    nearly = Columns(
        nuisance=data.nuisance,
        precision=data.precision,
        candidates=np.column_stack([data.candidates[:, 0], slightly]),
        residual=data.residual,
        block=data.block,
        fold=data.fold,
    ).equations()  # fmt: skip
    assert nearly.fit([0, 1], [False, False]).rank == 1


@pytest.mark.parametrize(("regressor", "rank"), [(1, 0), (2, 0), (3, 1), (4, 1), (5, 0), (6, 0)])
def test_nist_longley(regressor: int, rank: int) -> None:
    """One regressor as candidate, the other five and the intercept as nuisance, nearly collinear with it: the certified
    slope, and as gain the square of its certified t. Of four regressors less than SINGULAR is left."""
    design = np.column_stack([np.ones(16), LONGLEY[:, 1:]]) / LONGLEY_RESIDUAL_SD
    data = Columns(
        nuisance=np.delete(design, regressor, axis=1),
        precision=np.full(6, 1e-30),
        candidates=design[:, [regressor]],
        residual=LONGLEY[:, 0] / LONGLEY_RESIDUAL_SD,
        block=np.arange(16),
        fold=np.arange(16) % 2,
    )
    equations = data.equations()
    fit = equations.fit([0], [False])
    assert fit.rank == rank
    assert (equations.reduced.curvature[0, 0] < SINGULAR * equations.reduced.squares[0]) == (rank == 0)
    certified, sd = LONGLEY_CERTIFIED[regressor], LONGLEY_SD[regressor]
    assert fit.weight[0] == pytest.approx(certified if rank else 0.0, rel=1e-3)
    assert fit.gain == pytest.approx((certified / sd) ** 2 if rank else 0.0, rel=1e-3)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_what_is_left_of_the_equations_is_a_fit_of_both(seed: int) -> None:
    """The gain of a further column, in the equations given others, is what both together gain more."""
    data = Columns.of(seed)
    equations = data.equations()
    first = equations.fit([0, 3], [False, False])
    given = equations.given([0, 3], first.weight)
    more = equations.fit([1], [False], given)
    both = equations.fit([0, 3, 1], [False] * 3)
    assert more.gain == pytest.approx(both.gain - first.gain, rel=1e-6)
    assert more.gain > 0
    assert given.chi2 == pytest.approx(equations.reduced.chi2 - first.gain, rel=1e-9)
