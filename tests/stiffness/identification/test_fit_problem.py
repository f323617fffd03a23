"""Fit problem and fit: layout, priors, states that are carried on; outliers and rows that come back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy import optimize

from stiffness.effects import BASE
from stiffness.identification.evaluate import predicted_by, predicted_rigid
from stiffness.identification.fit import Fit
from stiffness.identification.fitting import fitted
from stiffness.identification.outliers import cleaned, reconsidered, with_whole_setups
from stiffness.identification.problem import LOOSE, Problem, loose_sd
from stiffness.identification.session_data import SessionData
from stiffness.identification.station import REGISTERED_SD
from stiffness.identification.weighting import Weighting
from stiffness.session.session import Session
from tests.plant import lab
from tests.stiffness import session_desk
from tests.stiffness.bench_lab import Lab
from tests.stiffness.identification import many_sided

Floats = npt.NDArray[np.float64]
K = "k_nm_per_rad"


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Noisy, tracker not registered, one reflector rough; springs alone."""
    folder = tmp_path_factory.mktemp("noisy")
    return Lab("ur10").session(folder, 5, setups=8, form=lab.Form(registered=False))[0]


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> list[Session]:
    return [Lab("ur10").session(tmp_path_factory.mktemp(f"s{k}"), k, setups=4)[0] for k in (1, 2)]


def problem(*sessions: Session, offset: float = 0.0, names: tuple[str, ...] = ()) -> Problem:
    layout, fixed = many_sided.free(*names)
    data, weightings = [SessionData.of(s) for s in sessions], [Weighting(s, offset) for s in sessions]
    return Problem.of_sessions(data=data, weightings=weightings, unknowns=layout, fixed=fixed)


def fit(*sessions: Session, offset: float = 0.0) -> Fit:
    p = problem(*sessions, offset=offset)
    return fitted(p, p.first_states())


def test_own_numbers_stand_behind_the_parameters(session: Session, two: list[Session]) -> None:
    p = problem(session, *two)
    assert p.columns == (slice(6, 12), slice(12, 18), slice(18, 24))
    assert p.start == pytest.approx(np.concatenate([1 / many_sided.STIFFNESS, np.zeros(18)]))
    assert p.sd[:6] == pytest.approx(LOOSE / 1e6 * np.ones(6))
    assert p.sd[6:].tolist() == [1.0] * 3 + [0.5] * 3 + [*REGISTERED_SD] * 2
    blocks, states = p.blocks(p.start, p.first_states())
    assert {b.jacobian.shape[1] for b in blocks} == {24}
    assert len(states) == 3
    own = [b for b in blocks if b.jacobian[:, 6:12].any()]
    assert len(own) == len(np.unique(session.samples.setup))
    assert len(p.sessions(p.start, states)) == 3


def test_the_fit_is_that_of_scipy_on_all_whitened_residuals(two: list[Session]) -> None:
    """Two sessions at once, every number of both; the residual is evaluated by the problem, minimised by scipy."""
    p = problem(*two)
    found = fitted(p, p.first_states(), once=True)

    unit = np.concatenate([1 / many_sided.STIFFNESS, p.sd[6:]])

    def residual(scaled: Floats) -> Floats:
        vector = scaled * unit
        states = p.first_states()
        for _ in range(2):
            blocks, states = p.blocks(vector, states)
        return np.concatenate([b.residual for b in blocks] + [(vector - p.start) / p.sd])

    start = np.concatenate([np.full(6, 0.9), np.full(12, 0.1)])
    scipy = optimize.least_squares(residual, start, xtol=1e-10, ftol=1e-10, diff_step=1e-4)
    off = (found.solution.vector - scipy.x * unit) / np.sqrt(np.diag(found.solution.covariance))
    assert np.abs(off).max() < 0.1  # scipy also moves the noise that the wrench makes
    assert found.solution.chi2 == pytest.approx(2 * scipy.cost, rel=1e-3)


def test_the_fit_does_not_depend_on_where_the_iteration_starts(session: Session) -> None:
    p = problem(session)
    first = fitted(p, p.first_states())
    warm = fitted(p, first.states, first.solution.vector)
    assert (warm.parameters - first.parameters) / first.sd == pytest.approx(np.zeros(6), abs=1e-2)
    assert warm.solution.steps <= 2
    assert warm.sessions[0].state.poses is first.sessions[0].state.poses


def test_a_fit_holds_the_state_it_ended_with(session: Session) -> None:
    found = fit(session)
    (s,) = found.sessions
    assert s.predicted.x == pytest.approx(s.state.x, abs=1e-9)
    assert s.predicted is s.predicted
    assert s.further().state is s.predicted.state
    assert s.own == pytest.approx(found.solution.vector[6:])
    again = np.concatenate([b.residual for b in s.blocks()])
    assert again @ again == pytest.approx(found.solution.chi2, rel=1e-6)
    # fitting on from it leaves it as it is
    before = s.state.x.copy(), s.used.copy()
    fitted(found.problem, found.states, found.solution.vector)
    cleaned(found)
    assert np.array_equal(s.state.x, before[0]) and np.array_equal(s.used, before[1])


def test_a_prior_counts_by_its_standard_deviation(two: list[Session]) -> None:
    free = fit(*two)
    model = free.model("ur10", {})
    soft = {BASE.name: {K: 1 / (free.parameters + 3 * free.sd)}}
    layout, fixed = many_sided.free()
    fixed[BASE.name][K] = soft[BASE.name][K]
    sd = {BASE.name: {K: free.sd / (free.parameters + 3 * free.sd) ** 2}}
    known = Problem.of_sessions(
        data=[SessionData.of(s) for s in two],
        weightings=[Weighting(s, 0.0) for s in two],
        unknowns=layout,
        fixed=fixed,
        prior=replace(model, values=soft, sd=sd),
    )
    assert known.parameter_sd == pytest.approx(free.sd)
    both = fitted(known, known.first_states(), once=True)
    # two Gaussians: the mean weighted by the information of each
    data, prior = np.linalg.inv(free.solution.covariance[:6, :6]), np.diag(free.sd**-2.0)
    expected = np.linalg.solve(data + prior, data @ free.parameters + prior @ known.start[:6])
    assert (both.parameters - expected) / both.sd == pytest.approx(np.zeros(6), abs=0.05)
    assert np.all(both.sd < free.sd)


def test_what_the_model_does_not_explain_weighs_against_the_data(two: list[Session]) -> None:
    """With a residual far above the noise a firm prior counts for more than beside the noise alone."""
    rng = np.random.default_rng(0)
    wild = [
        replace(s, samples=replace(s.samples, position=s.samples.position + 3e-4 * rng.normal(size=(len(s), 3))))
        for s in two
    ]
    p = problem(*wild)
    firm = replace(p, parameter_sd=0.02 * p.start[:6])
    once, twice = (fitted(firm, firm.first_states(), once=flag) for flag in (True, False))
    assert twice.solution.misfit > 3
    away = np.abs(once.parameters - p.start[:6]), np.abs(twice.parameters - p.start[:6])
    assert np.all(away[1] < away[0])


def test_loose_priors_are_of_the_right_size() -> None:
    """Five typical sizes; of what yields, as many times more as the joints yield more than those of a heavy arm."""
    layout, values = many_sided.free("backlash", "kinematic-offset", "link-compliance", "base-compliance")
    k = values["joint-stiffness"]["k_nm_per_rad"]
    values["backlash"]["gap_rad"][2] = 0.3
    for softness, stiffness in ((1.0, [3e6, 2e6, 1.5e6, 1.2e6, 1e5, 5e4]), (40.0, [6e4, 5e4, 2.5e4, 2.5e4, 1e4, 9e3])):
        k[:] = stiffness
        for u, sd in zip(layout.free, loose_sd(layout, values), strict=True):
            yields = "compliance" in u.effect and u.parameter.unit != "1"
            own = LOOSE * u.scale if u.inverse else 5 * u.scale * (softness if yields else 1.0)
            assert sd == pytest.approx(own if u.parameter.prior_sd is None else u.parameter.prior_sd), str(u)
    assert sum("compliance" in u.effect for u in layout.free) > 20


def test_bounds_are_those_of_the_effects(two: list[Session]) -> None:
    """A gap that the noise would make negative is zero."""
    p = problem(*two, names=("backlash",))
    found = fitted(p, p.first_states())
    gaps = found.values()["backlash"]["gap_rad"]
    assert np.all(gaps >= 0) and np.any(gaps == 0)
    free, _ = p.solved(p.first_states(), bounded=False)
    assert np.any(free.vector[6:12] < 0)


def test_rows_that_are_wrong_are_left_out_and_no_others(tmp_path: Path) -> None:
    session, wrong = Lab("ur10").session(tmp_path, 9, setups=10, form=lab.Form(wrong=6))
    found = cleaned(fit(session, offset=0.02))
    assert sorted(line for _, line in found.outlier_rows()) == sorted(wrong)
    exact = np.isin(session.samples.line, wrong)
    assert np.array_equal(found.sessions[0].used, ~exact)
    assert found.solution.misfit == 1.0


def test_all_rows_of_a_clean_session_stay(two: list[Session]) -> None:
    found = cleaned(fit(*two, offset=0.02))
    assert all(s.used.all() for s in found.sessions)
    assert found.outlier_rows() == []


def test_rows_that_may_not_take_part_never_come_back(two: list[Session]) -> None:
    p = problem(*two, offset=0.02)
    held = [s.samples.setup == s.samples.setup[0] for s in two]
    states = tuple(
        replace(state, used=~h, allowed=~h) for state, h in zip(p.first_states(), held, strict=True)
    )
    found = reconsidered(cleaned(fitted(p, states)))
    assert all(np.array_equal(s.used, ~h) for s, h in zip(found.sessions, held, strict=True))
    fewer = tuple(replace(s, used=s.used & (np.arange(len(s.used)) % 7 > 0)) for s in found.states)
    back = reconsidered(replace(found, states=fewer))
    assert all(np.array_equal(s.used, ~h) for s, h in zip(back.sessions, held, strict=True))
    assert reconsidered(found) is found


def test_a_setup_that_is_mostly_out_is_structure_and_comes_back(two: list[Session]) -> None:
    found = fit(*two)
    s = found.sessions[0]
    setup = s.samples.setup
    most, few = setup == setup[0], np.flatnonzero(setup == setup[-1])[:3]
    used = ~most
    used[few] = False
    one_left = np.flatnonzero(most)[:4]
    used[one_left] = True
    spoiled = replace(found, states=(replace(s.state, used=used), found.states[1]))
    back = with_whole_setups(spoiled)
    assert back[0][most].all()
    assert not back[0][few].any()
    assert back[1].all()
    assert not used[most].all()  # what was given is as it was
    barred = replace(found, states=(replace(s.state, used=used, allowed=used), found.states[1]))
    assert np.array_equal(with_whole_setups(barred)[0], used)


def test_a_model_without_free_numbers_only_places_the_tracker(session: Session) -> None:
    found = fit(session)
    model = found.model("ur10", {})
    every = np.ones(len(session), dtype=bool)
    placed = predicted_by(model, session, every)
    assert len(placed.vector) == 6
    apart = placed.predicted.position - found.sessions[0].predicted.position
    assert np.abs(apart).max() < 2e-5
    rigid = predicted_rigid(session, every)
    assert np.abs(rigid.predicted.x[:, :6]).max() < 1e-8
    off, bent = (session.samples.position - p.predicted.position for p in (rigid, placed))
    assert np.sqrt(np.mean(off**2)) > 5 * np.sqrt(np.mean(bent**2))
    # readings that do not take part do not place it
    some = session.samples.setup % 2 == 0
    noisy = session.samples.position + np.where(some[:, None], 0.0, 1e-3)
    moved = replace(session, samples=replace(session.samples, position=noisy))
    a, b = (predicted_by(model, s, some).predicted.position for s in (session, moved))
    # only the first guess sees them, and what counts from it comes out the same
    assert np.abs(a - b).max() < 1e-7


def test_leaving_an_effect_out_predicts_the_rest(tmp_path: Path) -> None:
    session, _ = session_desk.write(tmp_path, noise=lab.Noise(1e-6, 1e-3, 1e-3, 1e-3), design={"count": 6})
    p = problem(session, names=("backlash",))
    found = fitted(p, p.first_states())
    gap = next(e for e in found.unknowns.effects if e.name == "backlash")
    (without,) = found.predicted_without(gap)
    layout, fixed = many_sided.free()
    bare = many_sided.observed(session, layout, fixed)
    state = replace(bare.first_state(), poses=found.sessions[0].state.poses)
    expected = bare.predictor.predict(state, found.parameters[:6], found.sessions[0].own)
    assert np.array_equal(without.position, expected.position)
    assert np.abs(without.position - found.sessions[0].predicted.position).max() > 2e-6
