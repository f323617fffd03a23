"""The HTML report: its numbers are in it, and nothing in it reaches out or breaks out."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.report.html.path import page
from compensator.report.html.tables import LISTED, millimetres
from compensator.solve.compensation import Compensation
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.reports import Walk, figures_in, own, prepared

HOSTILE = "</script><img src=x onerror=alert(1)>&\"'.csv"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return prepared(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def run(folder: Path) -> tuple[Compensation, dict[str, Any]]:
    done = compensate_file(folder / "circle.csv", folder / "cell.toml", folder / "out.csv")
    return done.result, done.report


@pytest.fixture(scope="module")
def text(run: tuple[Compensation, dict[str, Any]]) -> str:
    return page(*run)


@pytest.fixture(scope="module")
def preview(folder: Path) -> tuple[Compensation, dict[str, Any]]:
    done = preview_file(folder / "circle.csv", folder / "cell.toml")
    return done.result, done.report


def test_page_is_well_formed(text: str) -> None:
    walk = Walk(text)
    assert walk.open == []
    assert text.startswith("<!DOCTYPE html>\n")
    for tag in ("html", "head", "title", "body", "h1"):
        assert walk.tags.count(tag) == 1
    ids = [value for _, name, value in walk.attributes if name == "id"]
    assert ids == ["path", "along", "joints", "flanks", "figures"]
    assert set(ids) - {"figures"} == set(figures_in(text))


def test_numbers_of_the_summary_are_in_words_and_tables(
    text: str, run: tuple[Compensation, dict[str, Any]]
) -> None:
    result, report = run
    said = Walk(text).said
    error = report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.1
    for key in ("before", "after"):
        for value in error[key].values():
            assert millimetres(value) in said
    assert f"{report['max_correction_mm']:.4f} mm" in said
    assert f"poses {report['n_poses']} of these cutting {report['n_cut']} " in said
    assert f"joint reversals {len(report['reversals'])} " in said
    assert f"torque sign changes {len(report['torque_sign_changes'])} " in said
    assert f"of these put in at flank changes {report['inserted_poses']} " in said
    for note in report["notes"]:
        assert note in said
    cut = np.flatnonzero(result.cutting)
    worst = cut[np.argmax(np.linalg.norm(result.error_before[cut], axis=1))]
    assert f"line {result.path.toolpath.line[worst]}, pose {worst}" in said


def test_warnings_appear_only_with_a_cause(run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    quiet = {**report, "unknown_state": {"n_cut": 0, "max_spread_mm": 0.0}, "not_applied": [], "notes": []}
    assert "warn" not in {v for _, name, v in Walk(page(result, quiet)).attributes if name == "class"}
    loud = {
        **quiet,
        "unknown_state": {"n_cut": 1234, "max_spread_mm": 0.0625},
        "not_applied": ["tool-<b>compliance"],
    }
    said = Walk(page(result, loud)).said
    assert "At 1,234 cutting poses" in said and "0.0625 mm at the TCP" in said
    assert "instruments): tool-<b>compliance." in said


def test_after_is_what_the_caller_measured(run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    after = np.linspace(0, 1e-3, len(result))
    drawn = figures_in(page(result, report, after))
    enlarged = next(t for t in drawn["along"]["data"] if "µm" in t["hovertemplate"])
    cut = np.flatnonzero(result.cutting)
    assert [v for v in enlarged["y"] if v is not None] == pytest.approx(after[cut] * 1e6, abs=0.01)
    assert drawn["path"]["layout"]["coloraxis2"]["cmax"] == pytest.approx(1e3 * after[cut].max())


def test_equal_results_give_equal_bytes(
    folder: Path, text: str, run: tuple[Compensation, dict[str, Any]]
) -> None:
    again = compensate_file(folder / "circle.csv", folder / "cell.toml", folder / "out2.csv")
    assert page(again.result, {**again.report, "seconds": 98765.432}) == text
    assert page(*run) == text


def test_page_reaches_for_nothing(text: str) -> None:
    walk = Walk(text)
    policy = next(v for _, name, v in walk.attributes if name == "content" and "default-src" in v)
    assert "default-src 'none'" in policy and "http" not in policy and "unsafe-eval" not in policy
    assert not {"link", "iframe", "img", "object", "embed", "base", "form"} & set(walk.tags)
    assert not [a for a in walk.attributes if a[1] in ("src", "href", "action", "srcset")]
    assert re.findall(r"https?:|//[a-z]|@import|url\(", own(text)) == []


def test_hostile_names_stay_text(folder: Path, run: tuple[Compensation, dict[str, Any]]) -> None:
    result, report = run
    toolpath = replace(result.path.toolpath, source=HOSTILE)
    arm = result.job.arm
    robot = replace(arm.robot, name="<b>arm</b>", joint_names=(HOSTILE,) * arm.robot.n)
    placement = replace(result.job.placement, source="<i>cell&amp;")
    job = replace(result.job, arm=replace(arm, robot=robot), placement=placement)
    hostile = replace(result, job=job, path=replace(result.path, toolpath=toolpath))
    text = page(hostile, {**report, "notes": [HOSTILE], "not_applied": [HOSTILE]})
    assert HOSTILE not in text
    walk = Walk(text)
    assert walk.open == []
    assert not {"img", "i"} & set(walk.tags)
    # heading, title, input table, note, not applied, and every joint
    assert " ".join(walk.words).count(HOSTILE) == 5 + robot.n
    assert "<b>arm</b>" in walk.said and "<i>cell&amp;" in walk.said
    assert "onerror" not in json.dumps(figures_in(text))


def test_preview_says_that_nothing_is_corrected(preview: tuple[Compensation, dict[str, Any]]) -> None:
    text = page(*preview)
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
    said = Walk(page(result, {**report, "reversals": many})).said
    assert f"{70000 + LISTED - 1} ({80000 + LISTED - 1}) … and 1,030 more" in said
    assert str(70000 + LISTED) not in said
    assert "joint reversals 1,042 " in said


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0.0000"), (12.3456789, "12.3457"), (0.001, "0.0010"), (0.000999, "0.00100"),
        (6.99e-5, "0.000070"), (3.2e-6, "0.000003"), (9e-10, "&lt; 0.000001"),
    ],
)  # fmt: skip
def test_millimetres(value: float, shown: str) -> None:
    assert millimetres(value) == unescape(shown)
