"""The page of identify: the numbers of the fit are in it."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from compensator.report.analysis.precision import correlation, interval
from compensator.report.html.fit import fit_page
from compensator.report.json.fit import fit_report
from compensator.report.words.numbers import rounded
from stiffness.identification.fit import Fit
from tests.compensator.report.page_reader import Walk, figures_in


@pytest.fixture(scope="module")
def report(fitted: tuple[Fit, list[int]]) -> dict[str, Any]:
    return fit_report(fitted[0])


@pytest.fixture(scope="module")
def text(fitted: tuple[Fit, list[int]], report: dict[str, Any]) -> str:
    return fit_page(fitted[0], report)


def test_numbers_of_the_fit_are_there(text: str, fitted: tuple[Fit, list[int]], report: dict[str, Any]) -> None:
    fit, wrong = fitted
    said = Walk(text).said
    k, sd = fit.values()["joint-stiffness"]["k_nm_per_rad"], fit.deviations()["joint-stiffness"]["k_nm_per_rad"]
    for u, v, s, value, spread in zip(fit.unknowns.free, fit.parameters, fit.sd, k, sd, strict=True):
        low, high = interval(u, float(v), float(s))
        shown = [rounded(x, spread) for x in (value, spread, low, high)]
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


def test_correlations_are_those_of_the_model_files_numbers(fitted: tuple[Fit, list[int]]) -> None:
    matrix = correlation(fitted[0])
    assert np.diag(matrix) == pytest.approx(np.ones(len(matrix)))
    assert np.abs(matrix).max() <= 1 + 1e-12
    heat = figures_in(fit_page(fitted[0], fit_report(fitted[0])))["correlations"]["data"][0]
    assert np.array(heat["z"]) == pytest.approx(matrix, abs=6e-4)


def blinded(fit: Fit, k: int) -> Fit:
    """The fit of readings that tell nothing of number ``k``."""
    n = len(fit.unknowns)
    covariance, information = fit.solution.covariance.copy(), fit.solution.information.copy()
    covariance[k, :n] = covariance[:n, k] = information[k, :n] = information[:n, k] = 0.0
    covariance[k, k] = (30 * fit.unknowns.scale[k]) ** 2
    return replace(fit, solution=replace(fit.solution, covariance=covariance, information=information))


def test_what_is_not_identified_has_no_value(fitted: tuple[Fit, list[int]]) -> None:
    blind = blinded(fitted[0], 3)
    said = Walk(fit_page(blind, fit_report(blind))).said
    assert re.search(r"joint 4 N·m/rad – – – not identified : no reading loads it", said)  # noqa: RUF001
    assert "5 of 6 joint stiffnesses are identified" in said


def test_a_number_of_a_table_that_is_not_identified_says_why(fitted: tuple[Fit, list[int]]) -> None:
    fit = fitted[0]
    free = list(fit.unknowns.free)
    free[3] = replace(free[3], parameter=replace(free[3].parameter, each=2, fit="direct"))
    fit = replace(fit, problem=replace(fit.problem, unknowns=replace(fit.unknowns, free=tuple(free))))
    blind = blinded(blinded(fit, 3), 4)
    said = Walk(fit_page(blind, fit_report(blind))).said
    reasons = ("angles that no reading has", "no reading loads it")
    for joint, why in zip((4, 5), reasons, strict=True):
        assert re.search(rf"joint {joint} N·m/rad – – – not identified : {why}", said)  # noqa: RUF001
