"""Whether the numbers of an identification can be trusted: intervals, three arms, flanks told apart.

IDENTIFY_SESSIONS=110 runs coverage on more than 1,200 intervals; the numbers are in docs/identify.md.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from benchmarks import identify as identify_benchmark
from stiffness.identification.evaluate import evaluate
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from tests.plant.lab import Form
from tests.stiffness.worn_lab import KUKA, WornLab

ABB = "abb-irb6600-175-255"
GAP = (1.2e-4, 1.0e-4, 1.2e-4, 2.2e-4, 3.2e-4, 4.4e-4)
RATIO = (0.75, 0.8, 0.7, 0.85, 0.75, 0.8)
SESSIONS = int(os.environ.get("IDENTIFY_SESSIONS", "9"))
METRES = Form(length="m", angle="rad", frame="tool", about="flange")


def distance(fit: Fit, lab: WornLab) -> np.ndarray:
    """From the truth in standard deviations, in the order of the solver, where the intervals live."""
    truth = [1 / lab.stiffness]
    truth += [np.array(lab.gap)] if lab.gap else []
    truth += [1 / np.array(lab.ratio)] if lab.ratio else []
    return np.asarray((fit.parameters - np.concatenate(truth)) / fit.sd)


def test_intervals_hold_the_truth(tmp_path: Path) -> None:
    """Stiffness of a heavy and a light arm, gaps, softer flanks: 95 % intervals, pooled."""
    kinds = [
        (WornLab(ABB), 7, "joint-stiffness"),
        (WornLab("ur10", form=METRES), 7, "joint-stiffness"),
        (WornLab(ABB, gap=GAP, lever=0.4), 12, "backlash"),
        (WornLab(ABB, ratio=RATIO, lever=0.4), 12, "preload-softening"),
    ]
    found: list[float] = []
    for k, (lab, setups, effect) in enumerate(kinds):
        for seed in range(SESSIONS if k < 2 else -(-SESSIONS // 3)):
            session = lab.session(tmp_path / f"{k}-{seed}", 5000 * k + seed, setups)
            found += distance(identify([session], [effect]), lab).tolist()
    inside = int(np.sum(np.abs(found) < 1.96))
    if len(found) >= 1200:
        assert 0.93 <= inside / len(found) <= 0.97
    # as it should be for independent intervals: outside these bounds once in a thousand runs
    low, high = stats.binom.ppf([5e-4, 1 - 5e-4], len(found), 0.95)
    assert low <= inside <= high


@pytest.mark.parametrize(("robot", "form"), [(ABB, Form()), ("ur10", METRES), (KUKA, Form(blocks=2, registered=False))])
def test_three_arms(robot: str, form: Form, tmp_path: Path) -> None:
    """Loads half a metre off the TCP load every wrist; held-out readings come out at the noise."""
    lab = WornLab(robot, lever=0.5, form=form)
    fit = identify([lab.session(tmp_path / "a", 5, 40)], ["joint-stiffness"])
    k = fit.values()["joint-stiffness"]["k_nm_per_rad"]
    assert fit.determined().all()
    assert np.abs(distance(fit, lab)).max() < 3
    assert np.abs(k / lab.stiffness - 1).max() < 0.02
    assert fit.notes == ()
    held = lab.session(tmp_path / "b", 12, 250)
    score = evaluate(held, fit.model(robot, {})).displacement
    assert score is not None
    assert score.rms == pytest.approx(score.noise_floor, rel=0.03)


def test_a_gap_is_no_softer_flank(tmp_path: Path) -> None:
    lab = WornLab(ABB, gap=GAP, lever=0.4)
    fit = identify([lab.session(tmp_path, 7, 30)])
    assert [e.name for e in fit.unknowns.effects if e.memory] == ["backlash"]
    assert np.abs(fit.values()["backlash"]["gap_rad"] - GAP).max() < 2e-5
    assert np.abs(fit.values()["joint-stiffness"]["k_nm_per_rad"] / lab.stiffness - 1).max() < 0.03


def test_a_softer_flank_is_no_gap(tmp_path: Path) -> None:
    lab = WornLab(ABB, ratio=RATIO, lever=0.4)
    fit = identify([lab.session(tmp_path, 21, 30)])
    assert fit.outlier_rows() == []  # not even those that springs alone contradict
    assert [e.name for e in fit.unknowns.effects if e.memory] == ["preload-softening"]
    assert np.abs(fit.values()["preload-softening"]["ratio"] / RATIO - 1).max() < 0.04
    assert np.abs(fit.values()["joint-stiffness"]["k_nm_per_rad"] / lab.stiffness - 1).max() < 0.03


def test_a_sensor_at_rest_chooses_no_flank(tmp_path: Path) -> None:
    """Joint 1 carries nothing in state 0: its gap rests where the approach left it, whatever the sensor shows."""
    lab = WornLab(ABB, gap=GAP, lever=0.4)
    session = lab.session(tmp_path, 9, 20)
    fit = identify([session], ["backlash"])
    (fitted,) = fit.sessions
    history, resting = fitted.observations.data.history, fitted.observations.predictor.resting
    state = history.state(fit.unknowns.effects, fit.values(), fitted.predicted.torque, resting)[:, 0]
    rest = session.samples.state == 0
    assert np.array_equal(state[rest], np.sign(session.samples.approach[rest, 0]))
    assert np.any(state[~rest] != np.sign(session.samples.approach[~rest, 0]))


def test_a_light_wrist_is_not_pulled_to_a_heavy_one(tmp_path: Path) -> None:
    """Few set-ups, a wrist a hundred times softer than the start: no prior shows beside the noise."""
    lab = WornLab("ur10", form=METRES)
    sessions = [lab.session(tmp_path / str(seed), seed, 6) for seed in range(12)]
    mean = np.mean([distance(identify([s], ["joint-stiffness"]), lab) for s in sessions], axis=0)
    assert np.abs(mean).max() < 3.3 / np.sqrt(12)


def test_what_the_benchmark_times_finds_the_truth(tmp_path: Path) -> None:
    given = identify_benchmark.session(tmp_path, 300)
    fit = identify([given], ["joint-stiffness"])
    assert len(given) == 300
    assert np.abs((fit.parameters - 1 / identify_benchmark.STIFFNESS) / fit.sd).max() < 3.5
    assert fit.solution.misfit == 1.0


def test_a_missing_effect_widens_what_it_biases(tmp_path: Path) -> None:
    """Flanks that are softer one way, and a model of springs alone: its residual does not show how far the springs are
    off, its intervals do; and no state that all reflectors agree on is called wrong."""
    lab = WornLab(ABB, ratio=(0.5, 0.6, 0.5, 0.6, 0.5, 0.6), lever=0.4)
    fit = identify([lab.session(tmp_path, 4, 30)], ["joint-stiffness"])
    off = fit.values()["joint-stiffness"]["k_nm_per_rad"] - lab.stiffness
    sd = fit.deviations()["joint-stiffness"]["k_nm_per_rad"]
    assert fit.lacks
    by_residual = (fit.parameters - 1 / lab.stiffness) / fit.sd
    assert np.abs(by_residual).max() > 4
    assert np.abs(off / sd).max() < 3
    (fitted,) = fit.sessions
    s, out = fitted.samples, fitted.allowed & ~fitted.used
    for state in np.unique(np.column_stack([s.setup, s.state])[out], axis=0):
        mine = (s.setup == state[0]) & (s.state == state[1])
        assert not out[mine].all()
