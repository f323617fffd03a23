"""Least squares: against NIST's certified values, against scipy, and the statistics against brute force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from scipy import linalg, optimize, stats

from stiffness.numerics.least_squares import (
    EXACT,
    SETTLED,
    Solution,
    bounded_minimum,
    inverse,
    solve,
)
from stiffness.numerics.whitened import STACKED, Whitened, deletion_statistics, whitened
from tests.stiffness.numerics.nist_strd import (
    LONGLEY,
    LONGLEY_CERTIFIED,
    LONGLEY_RESIDUAL_SD,
    LONGLEY_SD,
    NONLINEAR,
    NistProblem,
)

Floats = npt.NDArray[np.float64]
Model = Callable[[Floats], tuple[Floats, Floats]]


def white(rows: npt.NDArray[np.intp], residual: Floats, jacobian: Floats, sd: float) -> Whitened:
    return whitened(rows, residual, jacobian, sd**2 * np.eye(len(residual)))


def solved(
    blocks: Callable[[Floats], Sequence[Whitened]],
    start: Floats,
    prior: Floats | None = None,
    prior_sd: Floats | None = None,
    bounds: tuple[Floats, Floats] | None = None,
    spent: int = 0,
) -> Solution:
    """``solve`` for blocks without a state; without a prior, or a bound, unless given."""
    infinite = np.full(len(start), np.inf)
    low, high = (-infinite, infinite) if bounds is None else bounds
    solution, _ = solve(
        lambda v, state: (blocks(v), state),
        start,
        None,
        prior=np.zeros(len(start)) if prior is None else prior,
        prior_sd=infinite if prior_sd is None else prior_sd,
        low=low,
        high=high,
        spent=spent,
    )
    return solution


# ---- NIST StRD


def nist_fit(nist: NistProblem, start: int) -> Solution:
    """With the certified residual standard deviation as noise, so that chi-square is the degrees of freedom."""
    sd = np.sqrt(nist.squares / nist.freedom)
    rows = np.arange(len(nist.y))

    def blocks(b: Floats) -> list[Whitened]:
        value, jacobian = nist.model(b, nist.x)
        return [white(part, (nist.y - value)[part], jacobian[part], sd) for part in np.array_split(rows, 5)]

    return solved(blocks, np.array(nist.starts[start], dtype=float))


REACHED = [(nist, start) for nist in NONLINEAR for start in (0, 1) if (nist.name, start) != ("Lanczos3", 0)]


@pytest.mark.parametrize(("nist", "start"), REACHED, ids=lambda p: p.name if isinstance(p, NistProblem) else str(p))
def test_nist_nonlinear_regression(nist: NistProblem, start: int) -> None:
    sd = np.sqrt(nist.squares / nist.freedom)
    found = nist_fit(nist, start)
    off = (found.vector - np.array(nist.certified)) / np.array(nist.sd)
    assert np.abs(off).max() < 0.02  # in standard deviations: far below what the data can tell
    assert found.chi2 * sd**2 == pytest.approx(nist.squares, rel=1e-4)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(np.array(nist.sd), rel=0.02)
    assert found.freedom == pytest.approx(nist.freedom, abs=1e-4)
    assert found.count == len(nist.y)
    assert found.converged
    assert found.misfit == 1.0


def test_steps_run_out_where_a_start_is_too_far() -> None:
    """Lanczos3 from the first start creeps along a valley: all steps are used, and the residual shows it."""
    (lanczos,) = (p for p in NONLINEAR if p.name == "Lanczos3")
    found = nist_fit(lanczos, 0)
    assert found.steps == EXACT.steps
    assert not found.converged
    assert found.chi2 > 2 * lanczos.freedom


def test_nist_longley() -> None:
    """Six regressors, nearly collinear."""
    y, design = LONGLEY[:, 0], np.column_stack([np.ones(16), LONGLEY[:, 1:]])
    found = solved(lambda b: [white(np.arange(16), y - design @ b, design, LONGLEY_RESIDUAL_SD)], np.zeros(7))
    assert found.vector == pytest.approx(LONGLEY_CERTIFIED, rel=1e-6)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(LONGLEY_SD, rel=1e-6)
    assert found.chi2 == pytest.approx(9, rel=1e-8)


# ---- scipy


@dataclass(frozen=True)
class Random:
    """Exponentials and waves with correlated noise in blocks of several sizes; N*(k) numbers, P = 5."""

    time: tuple[Floats, ...]
    measured: tuple[Floats, ...]
    covariance: tuple[Floats, ...]
    start: Floats
    mean: Floats
    sd: Floats

    @classmethod
    def of(cls, seed: int, blocks: int = 12, noise: float = 0.05) -> Random:
        rng = np.random.default_rng(seed)
        truth = np.array([2.0, 0.7, 1.5, 2.2, -0.4]) * rng.uniform(0.8, 1.2, 5)
        time, measured, covariance = [], [], []
        for _ in range(blocks):
            k = int(rng.integers(1, 9))
            t = np.sort(rng.uniform(0, 4, k))
            root = noise * (np.eye(k) + 0.8 * rng.normal(size=(k, k)) / np.sqrt(k))
            time.append(t)
            covariance.append(root @ root.T)
            measured.append(values(truth, t)[0] + root @ rng.normal(size=k))
        sd = rng.uniform(0.003, 0.03, 5)
        mean = truth + sd * rng.normal(size=5)
        return cls(
            time=tuple(time),
            measured=tuple(measured),
            covariance=tuple(covariance),
            start=truth * rng.uniform(0.9, 1.1, 5),
            mean=mean,
            sd=sd,
        )

    def blocks(self, b: Floats) -> list[Whitened]:
        out = []
        for t, y, c in zip(self.time, self.measured, self.covariance, strict=True):
            value, jacobian = values(b, t)
            out.append(whitened(np.arange(len(t)), y - value, jacobian, c))
        return out

    def residual(self, b: Floats, prior: bool) -> Floats:
        """What scipy minimises, written independently: inverse square roots by eigenvalues."""
        parts = []
        for t, y, c in zip(self.time, self.measured, self.covariance, strict=True):
            size, axes = np.linalg.eigh(c)
            parts.append((axes / np.sqrt(size)).T @ (y - values(b, t)[0]))
        return np.concatenate([*parts, (b - self.mean) / self.sd] if prior else parts)


def values(b: Floats, t: Floats) -> tuple[Floats, Floats]:
    decay, wave = np.exp(-b[1] * t), np.sin(b[3] * t)
    value = b[0] * decay + b[2] * wave + b[4] * t
    jacobian = np.stack([decay, -b[0] * t * decay, wave, b[2] * t * np.cos(b[3] * t), t], axis=1)
    return value, jacobian


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("prior", [False, True])
def test_correlated_blocks_and_a_prior_as_scipy_has_it(seed: int, prior: bool) -> None:
    data = Random.of(seed)
    found = solved(data.blocks, data.start, *((data.mean, data.sd) if prior else (None, None)))
    scipy = optimize.least_squares(data.residual, data.start, args=(prior,), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    curvature = scipy.jac.T @ scipy.jac
    sd = np.sqrt(np.diag(np.linalg.inv(curvature)))
    assert np.abs((found.vector - scipy.x) / sd).max() < 5 * SETTLED
    assert found.covariance == pytest.approx(np.linalg.inv(curvature), rel=1e-3, abs=1e-3 * np.outer(sd, sd).max())
    measured = data.residual(scipy.x, False)
    assert found.chi2 == pytest.approx(measured @ measured, rel=1e-5)
    assert found.count == len(measured)
    known = curvature - np.diag(data.sd**-2.0) if prior else curvature
    assert found.information == pytest.approx(known, rel=1e-3, abs=1e-3 * np.abs(curvature).max())
    # degrees of freedom: numbers that a prior holds are not taken from the data
    taken = np.trace(np.linalg.inv(curvature) @ known)
    assert found.freedom == pytest.approx(len(measured) - taken, abs=1e-3)
    assert taken == pytest.approx(5, abs=1e-6) if not prior else taken < 4.9


def bounded(seed: int, cut: Sequence[int]) -> tuple[Solution, Floats, tuple[Floats, Floats]]:
    """The fit, scipy's, and bounds that cut off the optimum: the first of ``cut`` from below, the others from above."""
    data = Random.of(seed)
    free = optimize.least_squares(data.residual, data.start, args=(True,), xtol=1e-12, ftol=1e-12).x
    low, high = free - 1.0, free + 1.0
    low[cut[0]] = free[cut[0]] + 0.03
    high[list(cut[1:])] = free[list(cut[1:])] - 0.03
    start = np.clip(data.start, low + 1e-3, high - 1e-3)
    found = solved(blocks=data.blocks, start=start, prior=data.mean, prior_sd=data.sd, bounds=(low, high))
    scipy = optimize.least_squares(
        data.residual, start, args=(True,), bounds=(low, high), xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    return found, scipy.x, (low, high)


CUTS = [((k,), seed) for k in range(5) for seed in range(5)]
CUTS += [((1, 2), 0), ((1, 2), 4), ((0, 3), 0), ((0, 3), 1), ((2, 3, 4), 0), ((2, 3, 4), 4)]
RELEASED = [((1, 2), 3), ((0, 3), 4), ((2, 3, 4), 2), ((2, 3, 4), 3)]


@pytest.mark.parametrize(("cut", "seed"), [*CUTS, *RELEASED])
def test_bounds_as_scipy_has_them(cut: tuple[int, ...], seed: int) -> None:
    found, scipy, (low, high) = bounded(seed, cut)
    sd = np.sqrt(np.diag(found.covariance))
    assert np.abs((found.vector - scipy) / sd).max() < 10 * SETTLED
    assert np.all((low <= found.vector) & (found.vector <= high))
    for k in np.flatnonzero((scipy - low < 1e-9) | (high - scipy < 1e-9)):
        assert found.vector[k] == (low[k] if scipy[k] - low[k] < 1e-9 else high[k])  # exactly on its bound


@pytest.mark.parametrize("seed", range(40))
def test_the_smallest_of_a_quadratic_between_bounds_as_scipy_has_it(seed: int) -> None:
    """Twenty numbers that depend on each other, most of them at bounds; some are held by equal bounds."""
    rng = np.random.default_rng(seed)
    count = 20
    x = rng.normal(size=(count + 5, count)) + 3 * rng.normal(size=(count + 5, 1))
    y = 5 * rng.normal(size=count + 5)
    units = 10 ** rng.uniform(-6, 6, count)  # units make no difference
    low, high = -rng.exponential(0.2, count), rng.exponential(0.2, count)
    high[0] = low[0]
    found = bounded_minimum((x / units).T @ (x / units), (x / units).T @ y, low * units, high * units) / units
    # scipy takes no equal bounds: the number that they hold goes to the right-hand side
    exact = optimize.lsq_linear(x[:, 1:], y - x[:, 0] * low[0], (low[1:], high[1:]), tol=1e-15, method="bvls").x
    assert found[0] == pytest.approx(low[0], rel=1e-12)
    assert found[1:] == pytest.approx(exact, abs=1e-9)
    assert np.sum((found <= low + 1e-12) | (found >= high - 1e-12)) >= 5


def test_a_linear_problem_with_a_bound_takes_one_step() -> None:
    """In the step that meets the bound the other numbers already answer to it."""
    rng = np.random.default_rng(7)
    x = rng.normal(size=(50, 3)) + 0.9 * rng.normal(size=(50, 1))  # columns that depend on each other
    y = x @ [1.0, -2.0, 3.0] + rng.normal(size=50)
    high = np.array([np.inf, np.inf, 1.5])
    bounds = np.full(3, -np.inf), high
    found = solved(lambda b: [white(np.arange(50), y - x @ b, x, 1.0)], np.zeros(3), bounds=bounds)
    exact = optimize.lsq_linear(x, y, bounds, tol=1e-14).x
    assert found.vector == pytest.approx(exact, rel=1e-6)
    assert found.vector[2] == 1.5
    assert found.steps == 2  # the second is the one that is too short to be taken


def test_a_number_held_by_its_bounds_leaves_the_fit_of_the_others() -> None:
    """What a profile likelihood asks for."""
    data, others = Random.of(3), [0, 1, 2, 4]
    free = solved(data.blocks, data.start)
    for away in (-3.0, 3.0):
        held = float(free.vector[3] + away * np.sqrt(free.covariance[3, 3]))
        start = data.start.copy()
        start[3] = held
        low, high = np.full(5, -np.inf), np.full(5, np.inf)
        low[3] = high[3] = held
        found = solved(data.blocks, start, bounds=(low, high))
        assert found.vector[3] == held

        def rest(v: Floats, at: float = held) -> Floats:
            return data.residual(np.insert(v, 3, at), False)

        scipy = optimize.least_squares(rest, start[others], xtol=1e-12, ftol=1e-12)
        sd = np.sqrt(np.diag(np.linalg.inv(scipy.jac.T @ scipy.jac)))
        assert np.abs((found.vector[others] - scipy.x) / sd).max() < 5 * SETTLED
        assert found.chi2 == pytest.approx(2 * scipy.cost, rel=1e-5)
        assert found.chi2 - free.chi2 == pytest.approx(9, rel=0.1)  # three standard deviations away


def test_many_blocks_are_summed_as_few() -> None:
    """Blocks are stacked for speed; where the stacks end makes no difference."""
    rng = np.random.default_rng(1)
    x, y = rng.normal(size=(2 * STACKED + 7, 3)), rng.normal(size=2 * STACKED + 7)
    one = solved(lambda b: [white(np.arange(len(y)), y - x @ b, x, 0.7)], np.zeros(3))
    each = [np.array([k]) for k in range(len(y))]
    every = solved(lambda b: [white(k, y[k] - x[k] @ b, x[k], 0.7) for k in each], np.zeros(3))
    exact = np.linalg.lstsq(x, y, rcond=None)[0]
    assert one.vector == pytest.approx(exact, rel=1e-10)
    assert every.vector == pytest.approx(exact, rel=1e-10)
    assert every.covariance == pytest.approx(np.linalg.inv(x.T @ x) * 0.49, rel=1e-10)


# ---- the iteration


def arctangent(v: Floats, target: float = 1.0) -> tuple[Floats, Floats]:
    return target - np.arctan(v - 3.0), 1 / (1 + (v - 3.0) ** 2)[:, None]


def test_a_step_that_makes_things_worse_is_damped() -> None:
    """Gauss-Newton diverges on the arctangent from afar."""
    visited: list[float] = []

    def blocks(v: Floats) -> list[Whitened]:
        visited.append(float(v[0]))
        residual, jacobian = arctangent(v)
        return [white(np.arange(1), residual, jacobian, 1e-3)]

    found = solved(blocks, np.array([-2.0]))
    assert found.vector[0] == pytest.approx(3 + np.tan(1.0), abs=1e-3)
    cost = [abs(1.0 - np.arctan(v - 3)) for v in visited]
    assert any(later > earlier for earlier, later in pairwise(cost))  # it was really rejected


def test_the_state_goes_through_all_evaluations_rejected_steps_included() -> None:
    given: list[int] = []
    vectors: list[float] = []

    def blocks(v: Floats, state: int) -> tuple[list[Whitened], int]:
        given.append(state)
        vectors.append(float(v[0]))
        residual, jacobian = arctangent(v)
        return [white(np.arange(1), residual, jacobian, 1e-3)], state + 1

    one = np.ones(1)
    solution, state = solve(
        blocks, -2.0 * one, 7, prior=0 * one, prior_sd=np.inf * one, low=-np.inf * one, high=np.inf * one
    )
    assert given == list(range(7, 7 + len(given)))
    assert state == 7 + len(given)
    assert len(given) > solution.steps - 1
    assert len(set(vectors)) == len(vectors)


def test_numbers_that_the_data_do_not_see_stay_at_their_prior() -> None:
    x = np.random.default_rng(2).normal(size=(30, 2))
    design = np.column_stack([x, np.zeros(30)])
    y = x @ [1.5, -2.0]
    prior, sd = np.array([0.0, 0.0, 4.0]), np.array([1e3, 1e3, 0.5])
    found = solved(lambda b: [white(np.arange(30), y - design @ b, design, 0.01)], np.array([0.0, 0.0, 9.0]), prior, sd)
    assert found.vector == pytest.approx([1.5, -2.0, 4.0], abs=1e-4)
    assert np.sqrt(found.covariance[2, 2]) == pytest.approx(0.5)
    assert found.freedom == pytest.approx(28, abs=1e-6)


def test_spent_numbers_are_taken_from_the_degrees_of_freedom() -> None:
    x = np.ones((10, 1))
    y = np.arange(10.0)
    found = solved(lambda b: [white(np.arange(10), y - x @ b, x, 1.0)], np.zeros(1), spent=4)
    assert found.freedom == pytest.approx(5)
    assert found.chi2 == pytest.approx(np.sum((y - 4.5) ** 2))


@pytest.mark.parametrize(
    ("chi2", "freedom", "expected"),
    [
        (10.0, 10.0, 1.0),
        (4.0, 100.0, 1.0),  # too good is no misfit
        (400.0, 100.0, 2.0),
        (float(stats.chi2.isf(1.01e-3, 50)), 50.0, 1.0),
        (float(stats.chi2.isf(0.99e-3, 50)), 50.0, float(np.sqrt(stats.chi2.isf(0.99e-3, 50) / 50))),
        (1e9, 0.5, 1.0),  # nothing left to judge by
    ],
)
def test_misfit_is_the_spread_where_noise_does_not_explain_it(chi2: float, freedom: float, expected: float) -> None:
    none = np.zeros((1, 1))
    solution = Solution(
        vector=np.zeros(1),
        covariance=none,
        information=none,
        chi2=chi2,
        count=10,
        freedom=freedom,
        steps=1,
    )
    assert solution.misfit == pytest.approx(expected, rel=1e-12)


# ---- whitening, deletion, inverse


def covariance(size: int, rng: np.random.Generator, scale: float) -> Floats:
    root = rng.normal(size=(size, size))
    return scale**2 * (root @ root.T + 0.1 * np.eye(size))


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_whitening_makes_the_covariance_the_identity(scale: float) -> None:
    rng = np.random.default_rng(4)
    c = covariance(7, rng, scale)
    residual, jacobian = scale * rng.normal(size=7), rng.normal(size=(7, 3))
    block = whitened(np.arange(7), residual, jacobian, c)
    assert block.factor @ block.factor.T == pytest.approx(c, rel=1e-12)
    assert block.residual @ block.residual == pytest.approx(residual @ np.linalg.solve(c, residual), rel=1e-9)
    assert block.jacobian.T @ block.jacobian == pytest.approx(
        jacobian.T @ np.linalg.solve(c, jacobian), rel=1e-8, abs=1e-8 * np.abs(block.jacobian).max() ** 2
    )


@pytest.mark.parametrize("scale", [1e-7, 1.0])
@pytest.mark.parametrize("sizes", [[3, 3, 3, 3], [3, 6, 3], [1, 2, 3, 4, 5], [6]])
def test_deletion_is_the_chi_square_that_a_refit_without_the_reading_saves(sizes: list[int], scale: float) -> None:
    """Brute force: leave the reading out, and what the others predict of it, with its covariance."""
    rng = np.random.default_rng(sum(sizes))
    total = sum(sizes)
    c, r = covariance(total, rng, scale), scale * rng.normal(size=total)
    block = whitened(np.arange(total), r, np.zeros((total, 0)), c)
    found = deletion_statistics(block, sizes)
    ends = np.cumsum(sizes)
    for k, (end, size) in enumerate(zip(ends, sizes, strict=True)):
        mine = np.arange(total)[end - size : end]
        rest = np.setdiff1d(np.arange(total), mine)
        without = r[rest] @ np.linalg.solve(c[np.ix_(rest, rest)], r[rest]) if len(rest) else 0.0
        assert found[k] == pytest.approx(block.residual @ block.residual - without, rel=1e-8)
        if len(rest):
            weight = linalg.solve(c[np.ix_(rest, rest)], c[np.ix_(rest, mine)], assume_a="pos").T
            miss = r[mine] - weight @ r[rest]
            left = c[np.ix_(mine, mine)] - weight @ c[np.ix_(rest, mine)]
            assert found[k] == pytest.approx(miss @ np.linalg.solve(left, miss), rel=1e-8)


def test_deletion_of_clean_readings_is_chi_square() -> None:
    rng = np.random.default_rng(6)
    c = covariance(12, rng, 1.0)
    root = np.linalg.cholesky(c)
    every = [
        deletion_statistics(whitened(np.arange(12), root @ rng.normal(size=12), np.zeros((12, 0)), c), [3, 3, 6])
        for _ in range(400)
    ]
    for column, freedom in zip(np.array(every).T, (3, 3, 6), strict=True):
        assert stats.kstest(column, stats.chi2(freedom).cdf).pvalue > 1e-3


def test_the_inverse_does_not_mind_units() -> None:
    rng = np.random.default_rng(8)
    plain = covariance(6, rng, 1.0)
    units = 10.0 ** np.array([-9, -3, 0, 2, 6, 9])
    scaled = plain * np.outer(units, units)
    assert inverse(scaled) * np.outer(units, units) == pytest.approx(np.linalg.inv(plain), rel=1e-9)


def test_the_inverse_of_a_singular_matrix_is_large_where_nothing_is_known() -> None:
    v = np.array([1.0, 1.0]) / np.sqrt(2)
    found = inverse(np.outer(v, v))
    assert v @ found @ v == pytest.approx(1.0, rel=0.2)  # known, beside the 1e15 of what is not
    assert found[0, 0] - found[0, 1] > 1e14
