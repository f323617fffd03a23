"""The figures of the HTML report: they show the values of the result, thinned or not."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensator.report.figures.curves import along_figure, flanks_figure, joints_figure
from compensator.report.figures.path import path_figure
from compensator.report.figures.thinning import LIMIT, numbers, path_length, thin
from compensator.report.html.path import path_page
from compensator.solve.compensation import Compensation
from tests.compensator.report.page_reader import Walk, figures_in
from tests.compensator.report.small_path import taken
from toolpaths.toolpath import RAPID


@pytest.fixture(scope="module")
def text(run: tuple[Compensation, dict[str, Any]]) -> str:
    return path_page(*run)


def test_colours_share_one_range_and_axes_are_equal(run: tuple[Compensation, dict[str, Any]]) -> None:
    c = run[0]
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    figure = path_figure(c, [("a", before), ("b", before / 7)])
    layout = figure["layout"]
    top = before[c.cutting].max()
    for axis in ("coloraxis", "coloraxis2"):
        assert (layout[axis]["cmin"], layout[axis]["cmax"]) == (0, pytest.approx(top))
    shared, own_range = (b["args"][0] for b in layout["updatemenus"][0]["buttons"])
    assert shared["coloraxis2.cmax"] == pytest.approx(top)
    assert own_range["coloraxis2.cmax"] == pytest.approx(top / 7)
    assert own_range["coloraxis.cmin"] == pytest.approx(before[c.cutting].min())
    for name in ("scene", "scene2"):
        scene = layout[name]
        scale = [
            scene["aspectratio"][a] / np.diff(scene[f"{a}axis"]["range"])[0] for a in "xyz"
        ]  # box per mm
        assert scale == pytest.approx([scale[0]] * 3, rel=1e-4)
        for i, a in enumerate("xyz"):
            low, high = scene[f"{a}axis"]["range"]
            at = c.path.toolpath.position[:, i] * 1e3
            assert low < at.min() and at.max() < high


def test_rapids_are_grey_and_cuts_carry_the_error_of_the_pose_they_end_at(
    run: tuple[Compensation, dict[str, Any]],
) -> None:
    c = run[0]
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    rapid, cut = path_figure(c, [("a", before)])["data"]
    at = c.path.toolpath.position * 1e3
    cutting = np.flatnonzero(c.cutting)
    assert cut["x"][:-1] == pytest.approx(at[cutting[0] - 1 : cutting[-1] + 1, 0], abs=1e-3)
    assert cut["x"][-1] is None
    assert cut["line"]["color"][:-1] == pytest.approx([before[cutting[0]], *before[cutting]], abs=1e-4)
    heights = np.array([np.nan if v is None else v for v in rapid["z"]])
    last = np.flatnonzero(c.path.toolpath.kind == RAPID)[-1]
    assert np.count_nonzero(np.isnan(heights)) == 2  # one gap after each of the two runs of rapids
    assert np.nanmax(heights) == pytest.approx(at[:, 2].max(), abs=1e-3)
    assert rapid["z"][-2] == pytest.approx(at[last, 2], abs=1e-3)
    assert isinstance(rapid["line"]["color"], str) and rapid["line"]["width"] < cut["line"]["width"]


def test_curves_show_cutting_poses_and_the_correction_everywhere(
    run: tuple[Compensation, dict[str, Any]],
) -> None:
    c = run[0]
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    curves = along_figure(c, before, before / 1000)["data"]
    assert [t["name"] for t in curves] == [
        "before", "after", "after", "dx before", "dy before", "dz before",
        "correction x", "correction y", "correction z",
    ]  # fmt: skip
    cut, along = np.flatnonzero(c.cutting), path_length(c)
    assert curves[0]["x"] == pytest.approx(along[cut], abs=1e-6)
    assert curves[0]["y"] == pytest.approx(before[cut], abs=1e-5)
    assert curves[2]["y"] == pytest.approx(before[cut], abs=1e-4)  # a thousandth, in µm
    for i in range(3):
        assert curves[3 + i]["y"] == pytest.approx(1e3 * c.error_before[cut, i], abs=1e-5)
        assert curves[6 + i]["y"] == pytest.approx(1e3 * c.correction[:, i], abs=1e-5)
    assert curves[0]["customdata"] == c.path.toolpath.line[cut].tolist()


def test_curves_break_where_a_rapid_lies_between(run: tuple[Compensation, dict[str, Any]]) -> None:
    c = run[0]
    kind = c.path.toolpath.kind.copy()
    first, last = np.flatnonzero(c.cutting)[[0, -1]]
    gap = (first + last) // 2
    kind[gap : gap + 3] = RAPID
    c = replace(c, path=replace(c.path, toolpath=replace(c.path.toolpath, kind=kind)))
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    curve = along_figure(c, before, None)["data"][0]
    assert [k for k, v in enumerate(curve["y"]) if v is None] == [gap - first]
    assert curve["x"][gap - first] is None
    assert len(curve["y"]) == c.cutting.sum() + 1


def test_joint_angles_are_percent_of_their_range(run: tuple[Compensation, dict[str, Any]]) -> None:
    c = run[0]
    robot = c.job.arm.robot
    for j, curve in enumerate(joints_figure(c)["data"]):
        shown = robot.lower[j] + np.array(curve["y"]) / 100 * (robot.upper[j] - robot.lower[j])
        assert shown == pytest.approx(c.command.q[:, j], abs=1e-4)


def test_flanks_have_a_lane_for_every_joint_with_a_gap(run: tuple[Compensation, dict[str, Any]]) -> None:
    c = run[0]
    figure = flanks_figure(c)
    assert figure is not None
    lanes = {t["name"]: t for t in figure["data"] if "not known" not in t["name"]}
    assert sorted(lanes) == [f"joint {j}" for j in (1, 2, 3, 4, 6)]  # the gap of joint 5 is 0
    side = c.state.middle[:, 5] / 1.1e-4
    assert np.abs(side).max() == pytest.approx(1.0)
    assert (np.array(lanes["joint 6"]["y"]) - 1) / 0.36 == pytest.approx(side, abs=1e-3)
    assert flanks_figure(replace(c, job=replace(c.job, arm=replace(c.job.arm, effects=c.job.arm.effects[:1])))) is None


def test_a_long_path_is_thinned_and_says_so(run: tuple[Compensation, dict[str, Any]]) -> None:
    c, report = run
    rows = np.sort(np.random.default_rng(5).integers(0, len(c), LIMIT * 6))
    long = taken(c, rows)
    peak = 17321
    error = long.before.copy()
    error[peak] += [0.0, 0.0, 0.0123]
    long = replace(long, before=error)
    text = path_page(long, report, np.zeros(len(long)))
    assert f"The path has {len(long):,} poses" in Walk(text).said
    assert "The path has" not in Walk(path_page(c, report)).said
    for figure in figures_in(text).values():
        for trace in figure["data"]:
            assert len(trace["x"]) < LIMIT * 1.2
    drawn = figures_in(text)["along"]["data"]
    size = 1e3 * np.linalg.norm(long.error_before, axis=1)
    assert size.argmax() == peak
    assert max(v for v in drawn[0]["y"] if v is not None) == pytest.approx(size[peak], abs=1e-4)
    assert len(text) < 10_000_000


@given(
    rows=st.integers(1, 4000),
    columns=st.integers(1, 5),
    limit=st.integers(20, 400),
    seed=st.integers(0, 2**32 - 1),
)
def test_thinning_keeps_extremes_and_ends(rows: int, columns: int, limit: int, seed: int) -> None:
    values = np.random.default_rng(seed).standard_cauchy((rows, columns))
    kept = thin(values, limit)
    assert len(kept) <= max(limit, 2 * columns + 2)
    assert (np.diff(kept) > 0).all()
    assert kept[0] == 0 and kept[-1] == rows - 1
    assert (values[kept].max(axis=0) == values.max(axis=0)).all()
    assert (values[kept].min(axis=0) == values.min(axis=0)).all()
    if rows <= limit:
        assert len(kept) == rows


def test_thinning_keeps_the_peak_of_every_stretch() -> None:
    values = np.zeros((100_000, 1))
    peaks = np.arange(137, 100_000, 211)
    values[peaks, 0] = np.random.default_rng(3).uniform(1, 2, len(peaks)) * np.where(peaks % 2, 1, -1)
    assert set(peaks) <= set(thin(values, 5000))


def test_numbers_are_rounded_to_what_a_figure_shows() -> None:
    assert numbers(np.array([0.123456789, np.nan, -0.0]), 3) == [0.123, None, 0.0]
    assert numbers(np.array([1.23456789e-9, 5e-16])) == [1.23457e-9, 0.0]
    assert numbers(np.array([np.nan])) == [None]
    assert str(numbers(np.array([-1e-9]), 3)) == "[0.0]"
