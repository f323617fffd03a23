"""Every page of a report: it opens without a network, is the same for the same result, and no name breaks out of it."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

import compensator.report.html
from compensator.report.html.diagnosis import diagnosis_page
from compensator.report.html.fit import fit_page
from compensator.report.html.path import path_page
from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.json.fit import fit_report
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness import effects
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.diagnosis.result import Candidate, Diagnosis, MovedParameter
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.planning.next_setups import NextSetup
from tests.compensator.conftest import Sick
from tests.compensator.report.conftest import Run
from tests.compensator.report.page_reader import Walk, figures_in, own

HOSTILE = "</script><img src=x onerror=alert(1)>&amp;\"'{{ 7 * 7 }}{% raw %}"
NAMES_OF_A_PATH = 21  # title, heading, robot, 3 + 3 of findings; 6 joints; path, cell, robot, 2 of the model, tool
TEMPLATES = sorted((Path(compensator.report.html.__file__).parent / "templates").iterdir())


@dataclass(frozen=True)
class Page:
    """A page, the page of an equal result, its figures in order, and the page of a result whose every name from
    outside is HOSTILE, with how often that stands in it."""

    text: str
    again: str
    figures: tuple[str, ...]
    hostile: str
    names: int


def with_hostile_names(run: Run) -> Run:
    result, report = run
    arm, placement = result.job.arm, result.job.placement
    numbered = {k: replace(tool, name=HOSTILE) for k, tool in placement.tools.by_number.items()}
    named = replace(
        arm,
        robot=replace(arm.robot, name=HOSTILE, joint_names=(HOSTILE,) * arm.robot.n),
        model=replace(arm.model, source=HOSTILE),
        effects=tuple(replace(e, name=HOSTILE) if e.memory else e for e in arm.effects),
        values={**arm.values, HOSTILE: arm.values["backlash"]},
    )
    tools = replace(placement.tools, by_number=numbered)
    job = replace(result.job, arm=named, placement=replace(placement, source=HOSTILE, tools=tools))
    path = replace(result.path, toolpath=replace(result.path.toolpath, source=HOSTILE))
    hostile = replace(result, job=job, path=path)
    found = {"kind": HOSTILE, "where": HOSTILE, "what": HOSTILE, "remedy": HOSTILE, "count": 3}
    return hostile, {**report, "findings": [{**found, "level": "warning"}, {**found, "level": "note"}]}


def compensated(ask: Callable[[str], Any]) -> Page:
    run, folder = ask("run"), ask("circle")
    again = compensate_file(folder / "circle.csv", folder / "cell.toml", folder / "again.csv")
    after = np.zeros(len(run[0]))
    return Page(
        text=path_page(*run),
        again=path_page(again.result, {**again.report, "seconds": 98765.432}),
        figures=("path", "along", "joints", "flanks"),
        hostile=path_page(*with_hostile_names(run), after),
        names=NAMES_OF_A_PATH,
    )


def previewed(ask: Callable[[str], Any]) -> Page:
    run, folder = ask("preview"), ask("circle")
    again = preview_file(folder / "circle.csv", folder / "cell.toml")
    return Page(
        text=path_page(*run),
        again=path_page(again.result, {**again.report, "seconds": 98765.432}),
        figures=("path", "along", "joints", "flanks"),
        hostile=path_page(*with_hostile_names(run)),
        names=NAMES_OF_A_PATH,
    )


def identified(ask: Callable[[str], Any]) -> Page:
    fit, report = ask("fitted")[0], fit_report(ask("fitted")[0])
    again = identify([e.session for e in fit.sessions], ["joint-stiffness"])
    notes = {"notes": [HOSTILE], "not_identified": [HOSTILE, f"joint zero (kinematic-offset) of {HOSTILE}"]}
    return Page(
        text=fit_page(fit, report),
        again=fit_page(again, fit_report(again)),
        figures=("reflectors", "joints", "joints-after", "normal", "correlations"),
        hostile=fit_page(renamed(fit), {**report, **notes}),
        # title, heading, note, not identified, 2 x 3 reflectors, the session; twice for every row left out
        names=11 + 2 * len(fit.outlier_rows()),
    )


def renamed(fit: Fit) -> Fit:
    """The fit of a session whose every name is hostile."""
    (observations,) = (s.observations for s in fit.sessions)
    kept = observations.session
    session = replace(
        kept,
        source=HOSTILE,
        robot=replace(kept.robot, name=HOSTILE),
        reflectors=tuple(replace(r, name=HOSTILE + r.name) for r in kept.reflectors),
    )
    named = replace(observations, data=replace(observations.data, session=session))
    return replace(fit, problem=replace(fit.problem, observations=(named,)))


def diagnosed(ask: Callable[[str], Any]) -> Page:
    sick: Sick = ask("loose")
    d, report = sick.done.diagnosis, sick.done.report
    (added,) = d.added
    hostile = replace(with_hostile_words(d), added=(replace(added, confused_with=(HOSTILE,)),))
    return Page(
        text=(sick.folder / "report.html").read_text(),
        again=diagnosis_page(d, sick.model, report),
        figures=("map", "split", "ranking", "pattern-1"),
        hostile=diagnosis_page(hostile, replace(sick.model, source=HOSTILE), diagnosis_report(hostile)),
        # 2 changed, note, 3 of a candidate, 1 of no help, alike, 2 points at, 2 next, 2 changed, outlier, model
        names=16,
    )


def unexplained(ask: Callable[[str], Any]) -> Page:
    sick: Sick = ask("healthy")
    d = replace(
        sick.done.diagnosis,
        verdict="unexplained",
        residual_sources=(ResidualSource("column:q3", 0.9), ResidualSource("joint-3", 0.7, "angle of joint 3; time")),
    )
    report = diagnosis_report(d)
    hostile = with_hostile_words(d)
    return Page(
        text=diagnosis_page(d, sick.model, report),
        again=diagnosis_page(d, sick.model, report),
        figures=("map", "split", "ranking", "remainder"),
        hostile=diagnosis_page(hostile, replace(sick.model, source=HOSTILE), diagnosis_report(hostile)),
        names=18,  # the verdict and 2 of the nearest candidate more, none alike
    )


def with_hostile_words(d: Diagnosis) -> Diagnosis:
    """Names of effects, places and columns that packages and files may bring, and all words of notes."""
    setup = NextSetup(np.zeros(6), np.zeros(6), (HOSTILE,), HOSTILE, 0.0)
    return replace(
        d,
        residual_sources=(
            ResidualSource(f"column:{HOSTILE}", 0.9),
            ResidualSource("joint-3", 0.7, f"angle of joint 3; {HOSTILE}"),
        ),
        candidates=(
            Candidate(HOSTILE, (HOSTILE,), 1e-5, (HOSTILE,)),
            *d.candidates,
            Candidate(HOSTILE, (), 1e-5, ()),
        ),
        changed=(MovedParameter(HOSTILE, (HOSTILE,), "k_nm_per_rad", 1.0, 2.0, 0.1, "N*m/rad"),),
        next_setups=(setup,),
        notes=(HOSTILE,),
        outliers=((HOSTILE, 7),),
    )


PAGES = {f.__name__: f for f in (compensated, previewed, identified, diagnosed, unexplained)}
_made: dict[str, Page] = {}


@pytest.fixture(params=PAGES)
def page(request: pytest.FixtureRequest) -> Page:
    if request.param not in _made:
        _made[request.param] = PAGES[request.param](request.getfixturevalue)
    return _made[request.param]


def test_it_is_well_formed_and_has_a_place_for_every_figure(page: Page) -> None:
    walk = Walk(page.text)
    assert walk.open == [] and page.text.startswith("<!DOCTYPE html>\n")
    for tag in ("html", "head", "title", "body", "h1"):
        assert walk.tags.count(tag) == 1
    ids = [value for _, name, value in walk.attributes if name == "id"]
    assert ids == [*page.figures, "scene", "figures"]
    assert set(figures_in(page.text)) == set(page.figures)
    for drawn in figures_in(page.text).values():
        go.Figure(drawn)  # refuses a property that plotly does not have


def test_it_reaches_for_nothing(page: Page) -> None:
    walk = Walk(page.text)
    policy = next(v for _, name, v in walk.attributes if name == "content" and "default-src" in v)
    assert "default-src 'none'" in policy and "http" not in policy and "unsafe-eval" not in policy
    assert not {"link", "iframe", "img", "object", "embed", "base", "form"} & set(walk.tags)
    assert not [a for a in walk.attributes if a[1] in ("src", "href", "action", "srcset")]
    numbers = r'"[A-Za-z0-9+/]{4,}={0,2}"'  # of the scene, in base64
    assert re.findall(r"https?:|//[a-z]|@import|url\(", re.sub(numbers, "", own(page.text))) == []


def test_equal_results_give_equal_bytes(page: Page) -> None:
    assert page.again == page.text


def test_every_number_is_finite(page: Page) -> None:
    words = Walk(page.text).said
    assert re.findall(r"\b(nan|inf|NaN|Infinity)\b", words) == []
    figures_in(page.text)  # refuses one that is not


def test_it_has_no_script_but_its_data_the_libraries_and_the_drawing(page: Page) -> None:
    for text in (page.text, page.hostile):
        mine = own(text)
        assert Walk(text).tags.count("script") == 6
        assert mine.count("<script") == mine.count("</script>") == 6
        data = re.findall(r'<script type="application/json" id="(?:figures|scene)">(.*?)</script>', mine, re.DOTALL)
        assert len(data) == 2 and re.findall(r"[<>&\u2028\u2029]", "".join(data)) == []
    drawing = r"<script>(.*?)</script>"
    assert re.findall(drawing, own(page.text), re.DOTALL) == re.findall(drawing, own(page.hostile), re.DOTALL)


def test_hostile_names_stay_text(page: Page) -> None:
    walk = Walk(page.hostile)
    assert HOSTILE not in page.hostile and walk.open == []
    assert not {"img", "i"} & set(walk.tags)
    assert " ".join(walk.words).count(HOSTILE) == page.names
    labels = json.dumps(figures_in(page.hostile))
    assert "<img" not in labels and "</script" not in labels


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda p: p.name)
def test_only_libraries_go_into_a_template_unescaped(template: Path) -> None:
    raw = re.findall(r"\{\{[^}]*\|\s*safe[^}]*\}\}", template.read_text())
    three, plotly = "{{ three_js | safe }}", "{{ plotly_js | safe }}"
    assert raw == {"base.html": [three, plotly], "view.html": [three]}.get(template.name, [])
    assert "autoescape" not in template.read_text()


def test_no_python_of_the_package_writes_markup() -> None:
    """But for what plotly.js reads in labels."""
    root = Path(compensator.__file__).parent
    found = [
        f"{path.relative_to(root)}:{node.lineno}"
        for path in sorted(root.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and re.search(r"</?[a-z]+[ />]", node.value)
    ]
    assert {place.partition(":")[0] for place in found} == {"report/figures/layout.py"}


def test_an_effect_of_another_package_is_named_and_drawn(
    fitted: tuple[Fit, list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its name stands in the table of numbers and at the axes of the correlations."""
    fit = fitted[0]
    stranger = replace(effects.BASE, name=HOSTILE, is_base=False, fitted_where="")
    monkeypatch.setitem(effects.BY_NAME, HOSTILE, stranger)
    layout = fit.unknowns
    free = tuple(replace(u, effect=HOSTILE) for u in layout.free)
    known = {HOSTILE: fit.fixed[effects.BASE.name], **fit.fixed}
    layout = replace(layout, effects=(stranger,), free=free)
    renamed = replace(fit, problem=replace(fit.problem, unknowns=layout, fixed=known))
    text = fit_page(renamed, fit_report(fit))
    walk = Walk(text)
    assert HOSTILE not in text and walk.open == []
    assert " ".join(walk.words).count(HOSTILE.replace("-", "\u2011")) == len(free)
    names = figures_in(text)["correlations"]["data"][0]["x"]
    assert all(name.startswith("&lt;/script>&lt;img") for name in names)
