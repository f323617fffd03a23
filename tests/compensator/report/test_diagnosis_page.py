"""The page of diagnose: the numbers of the diagnosis are in it, and the story is told in order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest

from compensator.report.analysis.session_residuals import session_residuals
from compensator.report.analysis.setup_residuals import largest_setups
from compensator.report.figures.diagnosis import model_alone, noise_of
from compensator.report.figures.residual_map import enlargement
from compensator.report.html.diagnosis import diagnosis_page
from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.words.numbers import residual_mm, rounded
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.planning.next_setups import NextSetup
from tests.compensator.conftest import Sick
from tests.compensator.report.page_reader import Walk, figures_in

HOSTILE = '</script><img src=x onerror="alert(1)">&'


@pytest.fixture(scope="module")
def text(loose: Sick) -> str:
    return (loose.folder / "report.html").read_text()


def test_page_is_well_formed_and_tells_the_story_in_order(text: str) -> None:
    walk = Walk(text)
    assert walk.open == []
    ids = {value for _, name, value in walk.attributes if name == "id"}
    assert ids - {"figures", "scene"} == set(figures_in(text)) == {"map", "split", "ranking", "pattern-1"}
    for drawn in figures_in(text).values():
        go.Figure(drawn)  # refuses a property that plotly does not have
    heads = (
        "Explained: the model lacks backlash in joint-1", "Where the readings miss", "Noise, parameters, structure",
        "Candidates", "Evidence: backlash in joint-1", "What could not be told apart", "What the residual points at",
        "Parameters that have moved", "Rows left out", "What this was computed from",
    )  # fmt: skip
    places = [walk.said.replace(" :", ":").index(h) for h in heads]
    assert places == sorted(places)


def test_numbers_of_the_diagnosis_are_there(text: str, loose: Sick) -> None:
    said, d, report = Walk(text).said, loose.done.diagnosis, loose.done.report
    for kind in ("displacement", "absolute"):
        rms, split = report["rms_mm"][kind], report["split_mm"][kind]
        row = " ".join(residual_mm(rms[k]) for k in ("before", "refitted", "after", "noise_floor"))
        assert f"{kind} {row} {rms['after'] / rms['noise_floor']:.2f}" in said
        assert f"{kind} {' '.join(residual_mm(split[k]) for k in ('noise', 'parameters', 'structure', 'left'))}" in said
    gap, sd, _ = d.added[0].parameters["gap_rad"]
    shown = [rounded(1e3 * float(v), 1e3 * float(sd[0])) for v in (gap[0], sd[0])]
    assert f"backlash gap joint-1 mrad {shown[0]} {shown[1]}" in said
    for k, c in enumerate(c for c in d.candidates if c.where):
        assert f"{k + 1} {c.effect}" in said and residual_mm(1e3 * c.heldout_rms) in said
    for s in d.residual_sources:
        assert f"{100 * s.fraction:.0f} %" in said
    for name, line in d.outliers:
        assert f"{name} {line}" in said
    for note in d.notes:
        assert note in said


def test_figures_show_the_same_numbers(text: str, loose: Sick) -> None:
    d, report, drawn = loose.done.diagnosis, loose.done.report, figures_in(text)
    bars, *lines = drawn["ranking"]["data"]
    assert bars["y"] == [c.effect for c in d.candidates if c.where][:12]
    assert bars["x"] == pytest.approx([1e3 * c.heldout_rms for c in d.candidates if c.where][:12], rel=1e-4)
    assert lines[0]["x"] == pytest.approx([1e3 * noise_of(d)] * 2, rel=1e-4)
    bare = model_alone(d)
    if bare is not None:
        assert lines[1]["x"] == pytest.approx([1e3 * bare] * 2, rel=1e-4)
    for kind in ("displacement", "absolute"):
        split = report["split_mm"][kind]
        mine = {t["name"]: t["x"][0] for t in drawn["split"]["data"] if t["y"] == [f"{kind}, before"]}
        assert list(mine.values()) == pytest.approx(
            [(split[k] / split["noise"]) ** 2 for k in ("noise", "parameters", "structure")], abs=1e-4
        )


def test_the_map_has_the_largest_residuals_at_the_stated_scale(text: str, loose: Sick) -> None:
    residuals = session_residuals(loose.done.diagnosis, loose.model)
    shown = largest_setups(residuals, 12)
    sizes = [p.size for p in shown]
    assert sizes == sorted(sizes, reverse=True) and len(shown) == 12
    scale = enlargement(shown)
    assert f"{scale:,.0f} times" in Walk(text).said
    (seen,) = residuals
    s = seen.session.samples
    rows = np.flatnonzero((s.setup == shown[0].setup) & seen.sound)
    assert shown[0].size == pytest.approx(float(np.sqrt(np.mean(seen.before[rows] ** 2))))
    arrows = figures_in(text)["map"]["data"][3]
    tip = np.array([arrows[a][1] for a in "xyz"], dtype=float) - np.array([arrows[a][0] for a in "xyz"], dtype=float)
    assert tip / scale == pytest.approx(seen.before[rows[0]], abs=1e-4 / scale * 10)
    # the reflector stands where the arm without deflection has it: within a few mm of where it was read
    assert np.abs(seen.reflector - s.position).max() < 0.01
    assert len(shown[0].skeleton) == 13 and shown[0].skeleton[0].tolist() == [0.0, 0.0, 0.0]


def test_unexplained_page_points_and_draws_what_is_left(healthy: Sick) -> None:
    q = np.radians([10.0, -20.0, 30.0, 40.0, -50.0, 60.0])
    d = replace(
        healthy.done.diagnosis, verdict="unexplained",
        residual_sources=(ResidualSource("column:q3", 0.9), ResidualSource("joint-3", 0.7, "angle of joint 3; time")),
        next_setups=(NextSetup(q, np.array([0.0, 60.0, 0.0, 0.0, 0.0, 0.0]), ("tcp", "upper"), HOSTILE, 0.0),),
        notes=(HOSTILE,), outliers=((HOSTILE, 7),),
    )  # fmt: skip
    page = diagnosis_page(d, healthy.model, diagnosis_report(d))
    walk = Walk(page)
    assert walk.open == [] and "img" not in walk.tags and HOSTILE not in page
    assert " ".join(walk.words).count(HOSTILE) == 3
    assert "onerror" not in str(figures_in(page))
    assert "joint-3 70 % angle of joint 3 and time" in walk.said
    assert "it sits at joint-3 and follows the angle of joint 3" in walk.said
    assert "1 10.0, -20.0, 30.0, 40.0, -50.0, 60.0 0, 60, 0, 0, 0, 0 tcp and upper" in walk.said
    drawn = figures_in(page)["remainder"]
    assert drawn["layout"]["xaxis"]["title"]["text"] == "angle of joint 3, deg"
    (cloud,) = drawn["data"]  # nothing was found, so before is all there is
    (seen,) = session_residuals(d, healthy.model)
    angles = np.degrees(seen.session.samples.q[seen.session.states.first, 2])
    assert all(np.abs(angles - x).min() < 1e-3 for x in cloud["x"])
    assert np.abs(cloud["y"]).max() < 200  # µrad of noise
