"""The page of compensate and preview: the numbers of the run are in it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from compensator.report.html.path import path_page
from compensator.report.html.path_tables import LISTED
from compensator.report.words.numbers import deflection_mm
from compensator.report.words.shares import SHARES
from compensator.solve.compensation import Compensation
from tests.compensator.report.page_reader import Walk, figures_in


@pytest.fixture(scope="module")
def text(run: tuple[Compensation, dict[str, Any]]) -> str:
    return path_page(*run)


def test_numbers_of_the_summary_are_in_words_and_tables(
    text: str, run: tuple[Compensation, dict[str, Any]]
) -> None:
    result, report = run
    said = Walk(text).said
    error = report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.1
    for key in ("before", "after"):
        for value in error[key].values():
            assert deflection_mm(value) in said
    assert f"{report['max_correction_mm']:.3f} mm" in said
    assert f"poses {report['n_poses']} of these cutting {report['n_cut']} " in said
    assert f"joint reversals {len(report['reversals'])} " in said
    assert f"torque sign changes {len(report['torque_sign_changes'])} " in said
    assert f"of these put in at flank changes {report['inserted_poses']} " in said
    assert len(report["findings"]) > 5
    for finding in report["findings"]:
        assert finding["what"] in said
    plain = result.uncompensated
    cut = np.flatnonzero(plain.cutting)
    worst = cut[np.argmax(np.linalg.norm(plain.error_before[cut], axis=1))]
    assert f"line {plain.path.toolpath.line[worst]}, pose {worst}" in said


def test_what_the_deflection_is_made_of(text: str, run: tuple[Compensation, dict[str, Any]]) -> None:
    """A row per cause, and where the tool looks."""
    _, report = run
    said = Walk(text).said
    for name, share in report["deflection_mm"].items():
        assert f"{SHARES[name]} {deflection_mm(share['mean'])} {deflection_mm(share['p95'])}" in said
    assert "tool looks along, base axes (0.00, 0.00, -1.00) " in said


def test_warnings_appear_only_with_a_cause(run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    note = {"level": "note", "kind": "cell", "where": "a <b>", "what": "so so", "remedy": "", "count": 1}
    quiet = {**report, "findings": [note]}
    assert "warn" not in {v for _, name, v in Walk(path_page(result, quiet)).attributes if name == "class"}
    assert "Assumptions and limits a <b>: so so" in Walk(path_page(result, quiet)).said
    loud = {**report, "findings": [{**note, "level": "warning", "remedy": "look", "count": 3}]}
    page = Walk(path_page(result, loud))
    assert "warn" in {v for _, name, v in page.attributes if name == "class"}
    assert "warning: a <b> (and 2 more places): so so. look" in page.said


def test_after_is_what_the_caller_measured(run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    after = np.linspace(0, 1e-3, len(result))
    drawn = figures_in(path_page(result, report, after))
    enlarged = next(t for t in drawn["along"]["data"] if "µm" in t["hovertemplate"])
    cut = np.flatnonzero(result.cutting)
    assert [v for v in enlarged["y"] if v is not None] == pytest.approx(after[cut] * 1e6, abs=0.01)
    assert drawn["path"]["layout"]["coloraxis2"]["cmax"] == pytest.approx(1e3 * after[cut].max())


def test_preview_says_that_nothing_is_corrected(preview: tuple[Compensation, dict[str, Any]]) -> None:
    text = path_page(*preview)
    walk = Walk(text)
    assert walk.open == []
    assert "Nothing is corrected here" in walk.said and "not compensated" in walk.said
    for word in ("program as written", "largest correction", "flank changes", "after"):
        assert word not in walk.said
    drawn = figures_in(text)
    assert "scene2" not in drawn["path"]["layout"]
    assert [t["name"] for t in drawn["along"]["data"]] == ["distance", "dx", "dy", "dz"]


def test_long_lists_are_cut_with_a_count(run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    many = [{"where": "joint-2", "source_line": 70000 + k, "pose": 80000 + k} for k in range(LISTED + 1030)]
    said = Walk(path_page(result, {**report, "reversals": many})).said
    assert f"{70000 + LISTED - 1} ({80000 + LISTED - 1}) … and 1,030 more" in said
    assert str(70000 + LISTED) not in said
    assert "joint reversals 1,042 " in said
