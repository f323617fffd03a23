"""The HTML report of a fit: it shows the numbers of the fit, and nothing from a file but as text."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

from compensator.report.html.fit import fit_page
from compensator.report.html.fit_tables import correlation, figure, interval
from compensator.report.views.fit import joints, load_torque, looked_at, standardised
from compensator.tasks.identify import identify_report
from stiffness.identification.fit import Fit
from stiffness.identification.identify import identify
from tests.compensator.reports import Walk, figures_in, own
from tests.plant.lab import Form
from tests.stiffness.bench_lab import Lab

HOSTILE = '</script><img src=x onerror="alert(1)">&'


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Fit, list[int]]:
    session, wrong = Lab().session(tmp_path_factory.mktemp("fit"), 11, setups=12, form=Form(wrong=2))
    return identify([session], ["joint-stiffness"]), wrong


@pytest.fixture(scope="module")
def report(run: tuple[Fit, list[int]]) -> dict[str, Any]:
    return identify_report(run[0])


@pytest.fixture(scope="module")
def text(run: tuple[Fit, list[int]], report: dict[str, Any]) -> str:
    return fit_page(run[0], report)


def test_page_is_well_formed_and_has_its_figures(text: str) -> None:
    walk = Walk(text)
    assert walk.open == []
    ids = {value for _, name, value in walk.attributes if name == "id"}
    assert ids - {"figures"} == set(figures_in(text))
    assert set(figures_in(text)) == {"reflectors", "joints", "joints-after", "normal", "correlations"}
    for drawn in figures_in(text).values():
        go.Figure(drawn)  # refuses a property that plotly does not have


def test_numbers_of_the_fit_are_there(text: str, run: tuple[Fit, list[int]], report: dict[str, Any]) -> None:
    fit, wrong = run
    said = Walk(text).said
    k, sd = fit.values()["joint-stiffness"]["k_nm_per_rad"], fit.deviations()["joint-stiffness"]["k_nm_per_rad"]
    for u, v, s, value, spread in zip(fit.unknowns.free, fit.parameters, fit.sd, k, sd, strict=True):
        low, high = interval(u, float(v), float(s))
        shown = [figure(x, spread) for x in (value, spread, low, high)]
        assert f"{shown[0]} {shown[1]} {shown[2]} … {shown[3]} identified" in said
        assert low < value < high and high - low == pytest.approx(2 * 1.959964 * spread, rel=0.01)
    for kind in ("displacement", "absolute"):
        row = re.search(rf"{kind} ([\d.]+) ([\d.]+) ([\d.]+) ", said)
        assert row is not None
        assert [float(v) for v in row.groups()] == pytest.approx(list(report["rms_mm"][kind].values()), rel=1e-3)
    assert f"{report['condition_number']:.4g}" in said
    for line in wrong:
        assert re.search(rf"session\.toml {line} \d+ \d+ 0 (tcp|side|elbow)", said)
    assert f"From {report['n_readings']:,} readings, {len(report['outlier_rows'])} of them left out" in said


def test_equal_fits_give_equal_bytes(text: str, run: tuple[Fit, list[int]], report: dict[str, Any]) -> None:
    assert fit_page(run[0], report) == text
    again = identify([s.session for s in run[0].sessions], ["joint-stiffness"])
    assert fit_page(again, identify_report(again)) == text


def test_page_reaches_for_nothing(text: str) -> None:
    walk = Walk(text)
    policy = next(v for _, name, v in walk.attributes if name == "content" and "default-src" in v)
    assert "default-src 'none'" in policy and "http" not in policy
    assert not {"link", "iframe", "img", "object", "embed", "base", "form"} & set(walk.tags)
    assert not [a for a in walk.attributes if a[1] in ("src", "href", "action", "srcset")]
    assert re.findall(r"https?:|//[a-z]|@import|url\(", own(text)) == []


def test_hostile_names_stay_text(run: tuple[Fit, list[int]], report: dict[str, Any]) -> None:
    fit = run[0]
    (observations,) = (s.observations for s in fit.sessions)
    kept = observations.session
    hostile = replace(
        kept,
        source=HOSTILE,
        robot=replace(kept.robot, name=HOSTILE),
        reflectors=tuple(replace(r, name=HOSTILE + r.name) for r in kept.reflectors),
    )
    named = replace(observations, data=replace(observations.data, session=hostile))
    spoiled = replace(fit, problem=replace(fit.problem, observations=(named,)))
    text = fit_page(spoiled, {**report, "notes": [HOSTILE], "not_identified": [HOSTILE]})
    walk = Walk(text)
    assert walk.open == [] and "img" not in walk.tags and HOSTILE not in text
    # title, heading, note, not identified, 2 x 3 reflectors, the session, and twice for every row left out
    assert " ".join(walk.words).count(HOSTILE) == 11 + 2 * len(fit.outlier_rows())
    assert "onerror" not in str(figures_in(text))


def test_per_joint_the_rigid_arm_leaves_a_slope_and_the_fit_none(run: tuple[Fit, list[int]]) -> None:
    fit = run[0]
    for at in joints(fit, looked_at(fit)):
        assert len(at.torque) > 10
        slope_rigid, slope_fitted = (at.torque @ v / (at.torque @ at.torque) for v in (at.rigid, at.fitted))
        assert slope_rigid > 0  # gives in along its torque
        assert abs(slope_fitted) < 0.05 * slope_rigid
        assert np.sqrt(np.mean(at.fitted**2)) < 0.1 * np.sqrt(np.mean(at.rigid**2))


def test_torque_of_a_load_is_that_of_the_jacobian(run: tuple[Fit, list[int]]) -> None:
    session = run[0].sessions[0].session
    s, robot = session.samples, session.robot
    torque = load_torque(session)
    loaded = np.flatnonzero(np.linalg.norm(s.load.wrench, axis=1) > 100)[::17]
    assert len(loaded) > 3
    for k in loaded:
        pose = robot.pose(s.q[k])
        at = pose[:3, 3] + pose[:3, :3] @ s.load.point[k]
        force, moment = s.load.wrench[k, :3], s.load.wrench[k, 3:]
        about = moment + np.cross(at - pose[:3, 3], force)
        assert torque[k] == pytest.approx(robot.jacobian(s.q[k]).T @ np.concatenate([force, about]), abs=1e-6)


def test_residuals_of_a_good_session_are_standard_normal(run: tuple[Fit, list[int]]) -> None:
    z = standardised(run[0])
    used = int(run[0].sessions[0].used.sum())
    assert 2 * used < len(z) < 3 * used  # a reading has three numbers, one of a reflector's states carries the offset
    assert np.std(z) == pytest.approx(1, abs=4 / np.sqrt(2 * len(z)))
    assert abs(np.mean(z)) < 4 / np.sqrt(len(z))


def test_correlations_are_those_of_the_model_files_numbers(run: tuple[Fit, list[int]]) -> None:
    matrix = correlation(run[0])
    assert np.diag(matrix) == pytest.approx(np.ones(len(matrix)))
    assert np.abs(matrix).max() <= 1 + 1e-12
    heat = figures_in(fit_page(run[0], identify_report(run[0])))["correlations"]["data"][0]
    assert np.array(heat["z"]) == pytest.approx(matrix, abs=6e-4)


def test_what_is_not_identified_has_no_value(run: tuple[Fit, list[int]]) -> None:
    fit = run[0]
    n = len(fit.unknowns)
    covariance, information = fit.solution.covariance.copy(), fit.solution.information.copy()
    covariance[3, :n] = covariance[:n, 3] = information[3, :n] = information[:n, 3] = 0.0
    covariance[3, 3] = (30 * fit.unknowns.scale[3]) ** 2
    blind = replace(fit, solution=replace(fit.solution, covariance=covariance, information=information))
    said = Walk(fit_page(blind, identify_report(blind))).said
    assert re.search(r"joint 4 N·m/rad – – – not identified : no reading loads it", said)  # noqa: RUF001
    assert "5 of 6 joint stiffnesses are identified" in said


@pytest.mark.parametrize(
    ("value", "sd", "shown"),
    [(1996912.3, 5612.0, "1,996,900"), (0.0123456, 0.00021, "0.01235"), (float("inf"), 3.0, "∞"), (-0.001, 0.4, "0.00"),
     (5.0, 0.0, "5"), (37650.4, 9.96, "37,650.4")],
)  # fmt: skip
def test_digits_follow_the_standard_deviation(value: float, sd: float, shown: str) -> None:
    assert figure(value, sd) == shown


def test_a_session_that_is_not_registered(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 5, setups=10, form=Form(registered=False))
    fit = identify([session], ["joint-stiffness"])
    for at in joints(fit, looked_at(fit)):
        assert at.torque @ at.rigid > 0 and np.sqrt(np.mean(at.fitted**2)) < 6e-5
