"""Attribution: shares against explicit ridge regressions of every fold, and the regressors of a session."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis import attribution
from stiffness.diagnosis.attribution import LEAST, RIDGES, SIX, _Structure
from stiffness.diagnosis.held_out import EVERY, FEWEST, held_out
from stiffness.diagnosis.regressors import HARMONICS, SILENT, columns, regressors
from stiffness.diagnosis.selection import steady
from stiffness.identification.session_fit import SessionFit
from tests.stiffness.diagnosis.random_columns import Columns
from tests.stiffness.diagnosis.sick import sick

Floats = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def fit() -> SessionFit:
    return sick("clean").base.sessions[0]


# ---- shares


def ridge(data: Columns, chosen: list[int], fold: int, strength: float) -> float:
    """Chi-square of a fold: nuisance taken out of every column of the others, then a penalty on the scaled weights."""
    inside = np.flatnonzero(data.fold != fold)
    m = data.nuisance.shape[1]

    def reduced(column: Floats) -> Floats:
        moved = Columns(
            nuisance=data.nuisance,
            precision=data.precision,
            candidates=data.candidates,
            residual=column,
            block=data.block,
            fold=data.fold,
        )
        own = moved.refit([], inside)[0]
        prior = np.sqrt(data.precision) * own
        return np.concatenate([column[inside] - data.nuisance[inside] @ own, -prior])

    design = np.stack([reduced(data.candidates[:, k]) for k in chosen], axis=1)
    right = reduced(data.residual)
    size = np.linalg.norm(design, axis=0)
    system = np.vstack([design / size, np.sqrt(strength) * np.eye(len(chosen))])
    weight = np.linalg.lstsq(system, np.concatenate([right, np.zeros(len(chosen))]), rcond=None)[0] / size
    assert len(right) == len(inside) + m
    return data.left_out(chosen, fold, weight)


@pytest.mark.parametrize("chosen", [[0], [0, 3], [0, 2, 5, 7]], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_a_fraction_is_what_a_ridge_regression_explains_of_left_out_folds(seed: int, chosen: list[int]) -> None:
    data = Columns.of(seed, weight=np.array([0.5, 0.2, 0, 0.4, 0, -0.3, 0, 0]), blocks=60)
    structure = _Structure.of(data.equations())
    none = np.array([data.left_out([], k) for k in range(5)])
    above = float(none.sum() - len(data.residual))
    assert structure.total == pytest.approx(above, rel=1e-6)
    best = 0.0
    for strength in RIDGES:
        gain = none - np.array([ridge(data, chosen, k, strength) for k in range(5)])
        if steady(gain):
            best = max(best, float(gain.sum()) / above)
    assert structure.explained(np.array(chosen)) == pytest.approx(min(best, 1.0), rel=1e-5, abs=1e-9)
    assert best > 0.02


def test_noise_has_no_share() -> None:
    shares = []
    for seed in range(40):
        data = Columns.of(100 + seed, weight=np.array([0.8, 0, 0, 0, 0, 0, 0, 0]), blocks=60)
        structure = _Structure.of(data.equations())
        shares.append(structure.explained(np.arange(1, 8)))
        assert structure.explained(np.array([0])) > 0.8
    assert np.mean(np.array(shares) > LEAST) < 0.1
    assert structure.explained(np.empty(0, dtype=np.intp)) == 0.0


def test_places_and_columns_share_out_a_ripple() -> None:
    """Joint 3 errs with its angle: it comes first, its angle is what it follows, and columns of noise have no share."""
    ill = sick("unknown ripple")
    found = attribution.residual_sources(ill.base, ill.search.sensitivities)
    assert found[0].what == "joint-3"
    assert "angle of joint 3" in found[0].follows
    assert [s.fraction for s in found] == sorted((s.fraction for s in found), reverse=True)
    assert all(s.fraction > LEAST for s in found)
    assert not [s for s in found if s.what in ("column:humidity", "column:spindle")]
    assert SIX < 1


# ---- regressors


def test_regressors_are_scaled_and_named(fit: SessionFit) -> None:
    (found,) = regressors([fit])
    assert np.sqrt(np.mean(found.values**2, axis=0)) == pytest.approx(np.ones(found.values.shape[1]))
    assert len(found.family) == len(found.column) == len(found.joint) == found.values.shape[1]
    assert found.family[0] == "always the same" and np.all(found.values[:, 0] == 1)
    s, torque = fit.samples, fit.predicted.torque
    by_name = {(f, j): found.values[:, k] for k, (f, j) in enumerate(zip(found.family, found.joint, strict=True))}
    tau = torque[:, 2]
    assert np.corrcoef(by_name["torque of joint 3", -1], tau)[0, 1] == pytest.approx(1)
    sign = by_name["sign of its torque, joint 3", 2]
    assert np.array_equal(np.sign(sign), np.where(np.abs(tau) > SILENT * np.abs(tau).max(), np.sign(tau), 0))
    assert np.array_equal(np.sign(by_name["approach of joint 4", 3]), s.approach[:, 3])
    waves = [k for k, (f, j) in enumerate(zip(found.family, found.joint, strict=True)) if f == "angle of joint 5"]
    assert len(waves) == 2 * HARMONICS
    shares = [abs(np.corrcoef(found.values[:, k], np.cos(2 * s.q[:, 4]))[0, 1]) for k in waves]
    assert max(shares) == pytest.approx(1)


def test_the_last_change_of_load_is_that_from_the_state_before(fit: SessionFit) -> None:
    (found,) = regressors([fit])
    k = found.family.index("last change of load of joint 2")
    s = fit.samples
    tau = fit.predicted.torque[:, 1] / np.abs(fit.predicted.torque[:, 1]).max()
    for row in range(0, len(s), 29):
        before = np.flatnonzero((s.setup == s.setup[row]) & (s.state == s.state[row] - 1))
        change = tau[row] - tau[before[0]] if len(before) else 0.0
        expected = np.sign(change) if abs(change) > SILENT else 0.0
        assert np.sign(found.values[row, k]) == expected


def test_columns_that_vary_are_centred_and_scaled(fit: SessionFit) -> None:
    found = columns(fit.session)
    assert {"time", "temperature", "humidity"} <= set(found)
    for name, column in found.items():
        assert column.mean() == pytest.approx(0, abs=1e-9), name
        assert column.std() == pytest.approx(1)
    assert "payload" not in found or np.ptp(fit.samples.payload) > 0


def test_what_a_session_does_not_have_is_zero_in_it(fit: SessionFit) -> None:
    bare = dataclasses.replace(fit.session.samples, extra={}, time=np.full(len(fit.samples), np.nan))
    observations = fit.observations
    data = dataclasses.replace(observations.data, session=dataclasses.replace(fit.session, samples=bare))
    other = dataclasses.replace(fit, observations=dataclasses.replace(observations, data=data))
    first, second = regressors([fit, other])
    assert (first.family, first.column, first.joint) == (second.family, second.column, second.joint)
    missing = np.isin(first.column, ["time", *fit.samples.extra])
    assert missing.sum() >= 2 and not second.values[:, missing].any()
    assert np.all(np.sqrt(np.mean(first.values[:, missing] ** 2, axis=0)) == pytest.approx(np.sqrt(2)))
    np.testing.assert_allclose(second.values[:, ~missing], first.values[:, ~missing])


# ---- what is held out


def test_every_fifth_setup_of_every_block_is_held_out(fit: SessionFit) -> None:
    session = fit.session
    s = session.samples
    held = held_out(session)
    for block in np.unique(s.block):
        order = list(dict.fromkeys(s.setup[s.block == block].tolist()))
        expected = {order[k] for k in range(2, len(order), EVERY)} if len(order) >= FEWEST else set()
        assert set(s.setup[held & (s.block == block)].tolist()) == expected
    few = session.take(np.isin(s.setup, np.unique(s.setup)[: FEWEST - 1]))
    assert not held_out(few).any()
