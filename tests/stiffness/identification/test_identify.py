"""Global identification on sessions that an independent engine wrote."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.errors import StiffnessError
from stiffness.identification import scores
from stiffness.identification.evaluate import evaluate
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.model.model import load_model, save_model
from stiffness.session.session import load_session
from tests.plant.lab import Form, Noise, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import Lab


def stiffness(fit: Fit) -> tuple[np.ndarray, np.ndarray]:
    return fit.values()["joint-stiffness"]["k_nm_per_rad"], fit.deviations()["joint-stiffness"]["k_nm_per_rad"]


def deviations(fit: Fit, truth: np.ndarray) -> np.ndarray:
    """Distance from the truth in standard deviations, where the fit lives: in the compliance."""
    k, sd = stiffness(fit)
    return np.asarray((1 / k - 1 / truth) / (sd / k**2))


@pytest.mark.parametrize(
    ("robot", "form"),
    [
        ("abb-irb6600-175-255", Form()),
        ("abb-irb6600-175-255", Form(length="m", angle="rad", frame="tool", about="flange")),
        ("ur10", Form(frame="base", about="base")),
        ("ur10", Form(registered=False, blocks=2)),
    ],
    ids=["mm-deg", "m-rad-tool-flange", "about-base", "not-registered"],
)
def test_the_truth_is_found(robot: str, form: Form, tmp_path: Path) -> None:
    lab = Lab(robot)
    session, _ = lab.session(tmp_path, 3, form=form)
    fit = identify([session], ["joint-stiffness"])
    k, _ = stiffness(fit)
    assert np.abs(deviations(fit, lab.stiffness)).max() < 3.5
    assert np.abs(k / lab.stiffness - 1).max() < 0.12
    assert np.abs(k / lab.stiffness - 1)[:5].max() < 0.02
    assert fit.outlier_rows() == []


def test_without_noise_it_is_exact(tmp_path: Path) -> None:
    """Nothing in the statics, the loads or the derivatives is off by more than rounding and print."""
    lab = Lab()
    session, _ = lab.session(tmp_path, 5, setups=12, noise=Noise(1e-9, 0.0, 1e-6, 1e-6))
    session = replace(session, instruments=replace(session.instruments, tracker=2e-5))
    k, _ = stiffness(identify([session], ["joint-stiffness"]))
    assert np.abs(k / lab.stiffness - 1).max() < 2e-3


def test_default_effects_and_absolute_positions(tmp_path: Path) -> None:
    lab = Lab()
    session, _ = lab.session(tmp_path / "a", 7)
    fit = identify([session])
    assert [e.name for e in fit.unknowns.effects] == ["joint-stiffness", "kinematic-offset"]
    assert np.abs(deviations(fit, lab.stiffness)).max() < 3.5
    # the arm is nominal: its offsets are found to be small, and held-out readings come out at the noise
    other, _ = lab.session(tmp_path / "b", 8)
    path = tmp_path / "model.toml"
    save_model(fit.model(session.robot_name, {"kind": "static"}), path)
    result = evaluate(other, load_model(path))
    assert result.displacement is not None
    assert result.absolute is not None
    assert result.displacement.rms == pytest.approx(result.displacement.noise_floor, rel=0.05)
    assert result.absolute.rms < 2 * result.absolute.noise_floor


def test_a_gap_is_taken_up_and_found(tmp_path: Path) -> None:
    gap = (1.2e-4, 1.0e-4, 1.2e-4, 2.2e-4, 3.2e-4, 4.4e-4)
    lab = Lab(gap=gap)
    session, _ = lab.session(tmp_path, 11, setups=35)
    fit = identify([session])
    assert "backlash" in [e.name for e in fit.unknowns.effects]
    found, sd = fit.values()["backlash"]["gap_rad"], fit.deviations()["backlash"]["gap_rad"]
    assert np.abs(found - gap)[:5].max() < 2e-5
    assert np.abs((found - gap) / np.maximum(sd, 2e-6))[:5].max() < 5
    assert abs(found[5] - gap[5]) < 1.2e-4  # its torque is of the size of the sensor's noise: flanks are guessed
    assert np.abs(stiffness(fit)[0] / lab.stiffness - 1).max() < 0.06


def test_an_effect_that_is_named_is_searched_for_the_torque_that_switches_it(tmp_path: Path) -> None:
    session, _ = Lab(gap=(1.2e-4, 1.0e-4, 1.2e-4, 2.2e-4, 3.2e-4, 4.4e-4), breakaway=120.0).session(tmp_path, 11)
    fit = identify([session], ["joint-stiffness", "backlash"])
    found, sd = fit.values()["backlash"]["breakaway_nm"], fit.deviations()["backlash"]["breakaway_nm"]
    told = sd[:5] < 10.0  # loads that say it
    assert told.sum() >= 2
    assert np.abs((found[:5] - 120.0) / sd[:5])[told].max() < 3
    prior = fit.model(session.robot_name, {})
    gap = {**prior.values["backlash"], "breakaway_nm": np.full(6, 7.0)}
    prior = replace(prior, values={**prior.values, "backlash": gap})
    kept = identify([session], ["joint-stiffness", "backlash"], prior)
    assert kept.values()["backlash"]["breakaway_nm"].tolist() == [7.0] * 6  # who knows it is believed


def test_one_load_level_cannot_tell_a_gap(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 12, setups=12, levels=(1.0,))
    fit = identify([session])
    assert [e.name for e in fit.unknowns.effects] == ["joint-stiffness", "kinematic-offset"]
    assert any("one load level" in note for note in fit.notes)


def test_wrong_rows_are_found_and_a_clean_session_loses_none(tmp_path: Path) -> None:
    for seed in (21, 22, 23):
        clean, _ = Lab().session(tmp_path / f"clean{seed}", seed, setups=15)
        assert identify([clean], ["kinematic-offset"]).outlier_rows() == []
    dirty, wrong = Lab().session(tmp_path / "dirty", 24, setups=15, form=Form(wrong=6))
    fit = identify([dirty], ["kinematic-offset"])
    assert len(wrong) == 6
    assert {row for _, row in fit.outlier_rows()} == set(wrong)
    assert np.abs(deviations(fit, Lab().stiffness)).max() < 3.5


def test_what_no_reading_loads_is_said_and_not_invented(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 31, setups=10)
    inner = session.take(np.array([session.reflectors[k].name == "elbow" for k in session.samples.reflector]))
    fit = identify([inner], ["joint-stiffness"])
    known = fit.determined()
    assert known.tolist() == [True, True, True, False, False, False]
    words = fit.not_identified()
    assert len(words) == 3
    assert "joint 4" in words[0]
    assert "no reading loads it" in words[0]
    flags = fit.model("abb-irb6600-175-255", {}).identified["joint-stiffness"]
    assert flags.tolist() == [True, True, True, False, False, False]


def test_several_sessions_share_the_robot(tmp_path: Path) -> None:
    lab = Lab()
    one, _ = lab.session(tmp_path / "1", 41, setups=10)
    two, _ = lab.session(tmp_path / "2", 42, setups=10, form=Form(registered=False))
    alone, both = identify([one], ["joint-stiffness"]), identify([one, two], ["joint-stiffness"])
    assert np.all(stiffness(both)[1] < stiffness(alone)[1])
    assert np.abs(deviations(both, lab.stiffness)).max() < 3.5
    with pytest.raises(StiffnessError, match="several sessions of one robot"):
        identify([one, Lab("ur10").session(tmp_path / "3", 43, setups=3)[0]])


def test_a_prior_counts_by_its_deviations(tmp_path: Path) -> None:
    lab = Lab()
    session, _ = lab.session(tmp_path, 51, setups=6)
    first = identify([session], ["joint-stiffness"]).model("abb-irb6600-175-255", {})
    k = {"joint-stiffness": {"k_nm_per_rad": 2 * lab.stiffness}}
    firm = replace(first, values=k, sd={"joint-stiffness": {"k_nm_per_rad": 1e-6 * lab.stiffness}})
    loose = replace(first, values=k, sd={"joint-stiffness": {"k_nm_per_rad": 50 * lab.stiffness}})
    assert stiffness(identify([session], ["joint-stiffness"], firm))[0] == pytest.approx(2 * lab.stiffness, rel=1e-3)
    free = stiffness(identify([session], ["joint-stiffness"]))[0]
    assert stiffness(identify([session], ["joint-stiffness"], loose))[0] == pytest.approx(free, rel=0.02)


def test_intervals_hold_the_truth(tmp_path: Path) -> None:
    """A first look at coverage: 20 sessions, 120 intervals of 95 %; the chance of fewer than 106 inside is 0.3 %."""
    inside = 0
    lab = Lab()
    for seed in range(20):
        session, _ = lab.session(tmp_path / str(seed), 100 + seed, setups=8)
        inside += int(np.sum(np.abs(deviations(identify([session], ["joint-stiffness"]), lab.stiffness)) < 1.96))
    assert 106 <= inside <= 120


def test_scores_by_hand(tmp_path: Path) -> None:
    assert scores.rms(np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])) == pytest.approx(np.sqrt(25 / 6))
    a = scores.Score(rms=1.0, p95=2.0, largest=3.0, noise_floor=0.5, by_reflector={"x": 1.0}, count=10)
    b = scores.Score(rms=2.0, p95=1.0, largest=5.0, noise_floor=0.5, by_reflector={"x": 2.0, "y": 1.0}, count=30)
    both = scores.pooled([a, None, b])
    assert both is not None
    assert both.rms == pytest.approx(np.sqrt((10 * 1 + 30 * 4) / 40))
    assert (both.largest, both.by_reflector) == (5.0, {"x": 2.0, "y": 1.0})
    assert scores.pooled([None]) is None


def test_evaluate_registers_on_evenly_spread_states(tmp_path: Path) -> None:
    lab = Lab()
    session, _ = lab.session(tmp_path / "a", 61, setups=12, form=Form(registered=False))
    k = {"joint-stiffness": {"k_nm_per_rad": lab.stiffness}}
    model = replace(identify([session], ["joint-stiffness"]).model("abb-irb6600-175-255", {}), values=k)
    result = evaluate(session, model, 10)
    states = len(session.states)
    picked = np.unique(np.round(np.linspace(0, states - 1, 10)).astype(int))
    assert result.registered_on == 3 * len(picked)
    with pytest.raises(StiffnessError, match=rf"all {states} states place the tracker .* {states // 3}$"):
        evaluate(session, model, states)
    assert result.absolute is not None
    assert result.absolute.rms < 1.5 * result.absolute.noise_floor
    few, _ = lab.session(tmp_path / "few", 62, setups=4, form=Form(registered=False))
    small = evaluate(few, model)
    assert (len(few.states), small.registered_on) == (20, 3 * 6)
    assert small.absolute is not None
    assert small.absolute.count == 3 * 14
    assert small.absolute.rms < 2 * small.absolute.noise_floor
    soft = replace(model, values={"joint-stiffness": {"k_nm_per_rad": 0.5 * lab.stiffness}})
    worse = evaluate(session, soft, 10)
    assert worse.displacement is not None
    assert worse.displacement.rms > 5 * worse.displacement.noise_floor
    with pytest.raises(StiffnessError, match="not registered"):
        evaluate(session, model, 0)


def test_observability_falls_with_the_design(tmp_path: Path) -> None:
    rich, _ = Lab().session(tmp_path / "rich", 81, setups=20)
    poor, _ = Lab().session(tmp_path / "poor", 81, setups=2)
    good = identify([rich], ["joint-stiffness"])
    bad = identify([poor], ["joint-stiffness"])
    assert good.condition_number() == pytest.approx(1 / good.observability()["o2"], rel=1e-6)
    # per reading the indices compare designs; with the number of readings they say what is known in the end
    for index in ("o1", "o3"):
        few, many = (f.observability()[index] * np.sqrt(f.solution.count) for f in (bad, good))
        assert few < 0.5 * many
    one = good.observability()
    assert one["o3"] < one["o1"]
    assert one["o4"] == pytest.approx(one["o2"] * one["o3"], rel=1e-9)


def test_ropes_inner_links_and_payloads(tmp_path: Path) -> None:
    """A rope that is already taut in state 0, loads on link 3 about a reflector of it, a payload state."""
    lab = Lab()
    plant = lab.plant()
    targets = [
        Target("tcp", 6, np.array([0.02, -0.01, 0.25])),
        Target("side", 6, np.array([0.15, 0.0, 0.2])),
        Target("elbow", 3, np.array([0.1, 0.1, 0.1])),
    ]
    plan = random_setups(
        plant.arm, 24, 9, force=800.0, levels=(0.4, 1.0), preload=60.0, payload=40.0, pulls=(None, "elbow", "tcp")
    )
    session = load_session(measure(plant, plan, targets, noise=Noise(), form=Form(), seed=3).write(tmp_path, lab.robot))
    assert {3, 6} <= set(session.samples.load.link.tolist())
    assert session.samples.payload.max() == pytest.approx(40.0)
    fit = identify([session], ["joint-stiffness"])
    assert np.abs(deviations(fit, lab.stiffness)).max() < 3.5
    assert np.abs(stiffness(fit)[0] / lab.stiffness - 1)[:5].max() < 0.03


def test_what_a_prior_knows_stays_in_the_model(tmp_path: Path) -> None:
    """A model from data sheets has effects that no session asks for: measured data narrows them, or leaves them."""
    session, _ = Lab().session(tmp_path, 91, setups=8)
    first = identify([session], ["joint-stiffness"]).model("abb-irb6600-175-255", {})
    windup = {"windup_rad": np.full(6, 1e-7), "knee_nm": np.full(6, 200.0)}
    values = {**first.values, "joint-hardening": windup}
    sd = {**first.sd, "joint-hardening": {"windup_rad": np.full(6, 1e-9), "knee_nm": np.full(6, 1.0)}}
    fit = identify([session], None, replace(first, values=values, sd=sd))
    assert "joint-hardening" in [e.name for e in fit.unknowns.effects]
    assert fit.values()["joint-hardening"]["windup_rad"] == pytest.approx(1e-7, rel=0.1)
