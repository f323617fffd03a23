"""The HTML report of a diagnosis: it shows the numbers of the diagnosis, and nothing from a file but as text."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest

from compensator.report.figures.diagnosis import model_alone, noise_of
from compensator.report.figures.residual_map import enlargement
from compensator.report.html.diagnosis import diagnosis_page
from compensator.report.html.fit_tables import figure, millimetres
from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.views.diagnosis import looked_at, postures
from compensator.report.views.diagnosis_pattern import patterns
from compensator.report.views.place_wrench import place_wrench
from compensator.report.views.state_motion import turn, twist
from stiffness.diagnosis.attribution import Share
from stiffness.planning.next_setups import NextSetup
from tests.compensator.conftest import Sick
from tests.compensator.reports import Walk, figures_in, own

HOSTILE = '</script><img src=x onerror="alert(1)">&'


@pytest.fixture(scope="module")
def text(loose: Sick) -> str:
    return (loose.folder / "report.html").read_text()


def test_page_is_well_formed_and_tells_the_story_in_order(text: str) -> None:
    walk = Walk(text)
    assert walk.open == []
    ids = {value for _, name, value in walk.attributes if name == "id"}
    assert ids - {"figures"} == set(figures_in(text)) == {"map", "split", "ranking", "pattern-1"}
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
        row = " ".join(millimetres(rms[k]) for k in ("before", "refitted", "after", "noise_floor"))
        assert f"{kind} {row} {rms['after'] / rms['noise_floor']:.2f}" in said
        assert f"{kind} {' '.join(millimetres(split[k]) for k in ('noise', 'parameters', 'structure', 'left'))}" in said
    gap, sd, _ = d.added[0].parameters["gap_rad"]
    shown = [figure(1e3 * float(v), 1e3 * float(sd[0])) for v in (gap[0], sd[0])]
    assert f"backlash gap joint-1 mrad {shown[0]} {shown[1]}" in said
    for k, c in enumerate(c for c in d.candidates if c.where):
        assert f"{k + 1} {c.effect}" in said and millimetres(1e3 * c.heldout_rms) in said
    for s in d.points_at:
        assert f"{100 * s.share:.0f} %" in said
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
    looked = looked_at(loose.done.diagnosis, loose.model)
    shown = postures(looked, 12)
    sizes = [p.size for p in shown]
    assert sizes == sorted(sizes, reverse=True) and len(shown) == 12
    scale = enlargement(shown)
    assert f"{scale:,.0f} times" in Walk(text).said
    (seen,) = looked
    s = seen.session.samples
    rows = np.flatnonzero((s.setup == shown[0].setup) & seen.sound)
    assert shown[0].size == pytest.approx(float(np.sqrt(np.mean(seen.before[rows] ** 2))))
    arrows = figures_in(text)["map"]["data"][3]
    tip = np.array([arrows[a][1] for a in "xyz"], dtype=float) - np.array([arrows[a][0] for a in "xyz"], dtype=float)
    assert tip / scale == pytest.approx(seen.before[rows[0]], abs=1e-4 / scale * 10)
    # the reflector stands where the arm without deflection has it: within a few mm of where it was read
    assert np.abs(seen.geometry.point - s.position).max() < 0.01
    assert len(shown[0].skeleton) == 13 and shown[0].skeleton[0].tolist() == [0.0, 0.0, 0.0]


def test_the_pattern_of_backlash_is_a_step_that_is_gone_after(loose: Sick) -> None:
    d = loose.done.diagnosis
    (p,) = patterns(d, looked_at(d, loose.model), d.added[0])
    gap = float(d.added[0].parameters["gap_rad"][0][0]) * 1e6
    assert p.x_name == "torque of joint 1, N·m" and p.y_name == "rotation of joint 1, µrad"
    assert np.abs(p.says).max() == pytest.approx(gap / 2, rel=0.02)  # either flank is half a gap away
    assert p.before == pytest.approx(p.after + p.says, abs=1e-9)
    assert np.sqrt(np.mean(p.after**2)) < 0.35 * np.sqrt(np.mean(p.before**2))


def test_motion_of_a_state_is_found_from_its_residuals(loose: Sick) -> None:
    """Made-up residuals: a joint turned by 1 mrad; a place moved and turned."""
    (seen,) = looked_at(loose.done.diagnosis, loose.model)
    g, rows = seen.geometry, np.arange(len(seen.sound))
    link = np.array([r.link for r in seen.session.reflectors])[seen.session.samples.reflector]
    for j in (0, 2, 4):
        moved = 1e-3 * np.cross(g.axis[:, j], g.point - g.pivot[:, j]) * (link > j)[:, None]
        angle, told = turn(seen, rows, j, moved)
        assert told.sum() > 10 and angle[told] == pytest.approx(np.full(told.sum(), 1e-3), rel=1e-9)
    shift, rotation = np.array([2e-4, -1e-4, 3e-4]), np.array([1e-4, 2e-4, -3e-4])
    moved = shift + np.cross(rotation, g.point)
    found, _, told = twist(seen, rows, 0, moved)
    assert told.all() and found == pytest.approx(np.tile([*shift, *rotation], (len(found), 1)), abs=1e-9)


def test_load_on_the_base_carries_the_weight_of_the_arm(loose: Sick) -> None:
    (seen,) = looked_at(loose.done.diagnosis, loose.model)
    session, g = seen.session, seen.geometry
    wrench = place_wrench(seen.session, g, 0)
    robot, load = session.robot, session.samples.load
    assert robot.mass is not None
    weight = 9.80665 * (float(robot.mass.sum()) + (session.tool.mass or 0.0))
    assert wrench[:, 2] - load.wrench[:, 2] == pytest.approx(np.full(len(wrench), -weight), rel=1e-12)
    # about joint 1's axis, which is the base's z, no weight turns: only the load does
    tcp = g.origin[:, -1] + g.rotation[:, -1] @ session.tool.position
    moment = load.wrench[:, 5] + np.cross(tcp, load.wrench[:, :3])[:, 2]
    assert not load.in_tool.any() and wrench[:, 5] == pytest.approx(moment, abs=1e-9)


def test_unexplained_page_points_and_draws_what_is_left(healthy: Sick) -> None:
    q = np.radians([10.0, -20.0, 30.0, 40.0, -50.0, 60.0])
    d = replace(
        healthy.done.diagnosis, verdict="unexplained",
        points_at=(Share("column:q3", 0.9), Share("joint-3", 0.7, "angle of joint 3; time")),
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
    (seen,) = looked_at(d, healthy.model)
    angles = np.degrees(seen.session.samples.q[seen.session.states.first, 2])
    assert all(np.abs(angles - x).min() < 1e-3 for x in cloud["x"])
    assert np.abs(cloud["y"]).max() < 200  # µrad of noise


def test_page_reaches_for_nothing(text: str) -> None:
    walk = Walk(text)
    policy = next(v for _, name, v in walk.attributes if name == "content" and "default-src" in v)
    assert "default-src 'none'" in policy and "http" not in policy
    assert not {"link", "iframe", "img", "object", "embed", "base", "form"} & set(walk.tags)
    assert re.findall(r"https?:|//[a-z]|@import|url\(", own(text)) == []
