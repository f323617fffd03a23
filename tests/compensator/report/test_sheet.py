"""The page for a customer: one page, its numbers those of the report, no text of a file is markup."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from compensator.report.pdf.sheet import sheet, sheet_figure
from compensator.report.words.three_numbers import three_numbers
from compensator.solve.compensation import Compensation

Run = tuple[Compensation, dict[str, Any]]


def words(figure: Any) -> str:
    return " ".join(" ".join(text.get_text() for text in figure.texts).split())


def test_it_is_one_page_and_the_same_for_the_same_result(run: Run) -> None:
    c, report = run
    data = sheet(c, report, np.full(len(c), 1e-7))
    assert data.startswith(b"%PDF") and data.count(b"/Type /Page ") == 1
    assert data == sheet(c, report, np.full(len(c), 1e-7))


def test_its_numbers_are_those_of_the_report_and_hostile_text_is_text(run: Run) -> None:
    c, report = run
    toolpath = replace(c.path.toolpath, source="$\\frac{x</script>$" + "y" * 300)
    hostile = replace(c, path=replace(c.path, toolpath=toolpath))
    about = {"level": "warning", "kind": "x", "where": "", "remedy": "", "count": 1}
    found = [{**about, "what": f"w{k}$^"} for k in range(7)]
    figure, _ = sheet_figure(hostile, {**report, "findings": found}, np.full(len(c), 1e-7))
    said = words(figure)
    for number in three_numbers(report, corrected=True):
        assert number["value"] in said and number["words"] in said
    assert "$\\frac{x</script>$" in said and "w3$^" in said and "w4" not in said and "and 3 more warnings" in said
    assert "not measured" in said


def test_a_preview_has_one_curve(preview: Run) -> None:
    c, report = preview
    figure, title = sheet_figure(c, report, None)
    assert "not compensated" in title and [len(axes.lines) for axes in figure.axes] == [0, 1]
    shown = figure.axes[1].lines[0].get_ydata()
    assert np.nanmax(shown) == 1e3 * np.linalg.norm(c.error_before[c.cutting], axis=1).max()
