"""A figure that fails costs that figure: the page, the model and the JSON are there, and it is said where."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from plotly.offline import get_plotlyjs

from compensator.cli import main
from compensator.errors import CompensatorError
from compensator.report.analysis.pattern import Pattern
from compensator.report.figures.diagnosis import pattern_figure
from compensator.report.figures.drawing import drawn
from compensator.report.html import fit as fit_html
from compensator.report.html.page import plotly_js
from compensator.tasks.page_last import write_with_page
from tests.compensator.report.page_reader import Walk, figures_in
from tests.stiffness.bench_lab import Lab


def empty() -> Any:
    return {"data": [{"y": [float(np.empty(0).min())]}]}


def test_one_figure_fails_and_the_others_are_drawn() -> None:
    said: list[str] = []
    figures = drawn({"a": empty, "b": lambda: {"data": [1], "layout": {}}}, said.append)
    assert list(figures) == ["a", "b"] and figures["b"] == {"data": [1], "layout": {}}
    assert "could not be drawn" in figures["a"]["layout"]["annotations"][0]["text"]
    assert len(said) == 1 and said[0].startswith("figure 'a' of the report could not be drawn (ValueError: zero-size")


def test_a_pattern_of_no_state_is_a_sentence() -> None:
    none = np.empty(0)
    pattern = Pattern(x_name="torque", y_name="rotation", x=none, before=none, after=none, explained=none)
    figure = pattern_figure(pattern)
    assert figure["data"] == [] and "nothing to draw" in figure["layout"]["annotations"][0]["text"]


def test_identify_with_a_failing_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Lab("ur10").session(tmp_path, 5, setups=6)
    monkeypatch.setattr(fit_html, "normal_figure", lambda z: empty())
    files = {k: tmp_path / k for k in ("m.toml", "o.json", "r.html")}
    arguments = ["identify", str(tmp_path / "session.toml"), "-o", str(files["m.toml"]), "--effects", "joint-stiffness"]
    done = CliRunner().invoke(main, [*arguments, "--json", str(files["o.json"]), "--report", str(files["r.html"])])
    assert done.exit_code == 0
    assert done.stdout == "" and "warning: figure 'normal' of the report could not be drawn" in done.stderr
    assert json.loads(files["o.json"].read_text())["findings"] == []
    page = files["r.html"].read_text()
    assert "figure 'normal' of the report could not be drawn" in Walk(page).said.replace("&#39;", "'")
    assert {"normal", "joints", "reflectors", "correlations"} <= set(figures_in(page))
    assert files["m.toml"].stat().st_size > 100


def test_a_page_that_fails_as_a_whole_leaves_the_numbers(tmp_path: Path) -> None:
    model, page = tmp_path / "m.toml", tmp_path / "r.html"

    def fails(_: object) -> str:
        raise ValueError("no page")

    with pytest.raises(CompensatorError, match=r"r\.html: the report could not be made .*m\.toml"):
        write_with_page([(model, "numbers")], page, fails)
    assert model.read_text() == "numbers" and not page.exists()


def test_a_page_carries_no_more_of_plotly_than_it_draws_with() -> None:
    flat = {"a": {"data": [{"type": "scatter"}, {"type": "scatter3d"}]}, "b": {"data": [{"type": "mesh3d"}]}}
    assert "plotly.js (gl3d - minified)" in plotly_js(flat)[:200] and len(plotly_js(flat)) < 2e6
    assert plotly_js({**flat, "c": {"data": [{"type": "heatmap"}]}}) == get_plotlyjs()
