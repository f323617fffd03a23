"""The figure of a ball-bar: the circles as they were read and as models predict them, deviations enlarged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.circular_test import CircularTest, circular_tests
from compensator.report.figures.layout import AFTER, BEFORE, GRID, Figure, axes, base_layout, number, on_panel
from stiffness.identification.session_fit import SessionFit

Floats = npt.NDArray[np.float64]

MOST = 4  # circles side by side
PALE = "#9aa3ab"
OUTSIDE, APART = 1.4, np.radians(12)  # of the names of joints that turn
SHARE = 0.25  # of the radius that the largest deviation is drawn as


def has_ballbar(fits: Sequence[SessionFit]) -> bool:
    """Whether there is something to draw."""
    return any(f.session.path is not None and f.session.path.kind == "ballbar" for f in fits)


def ballbar_figure(fits: Sequence[SessionFit], before: Sequence[SessionFit]) -> Figure:
    """Measured, and predicted by the model at hand and by the one that stands at the end, one panel per plane and feed;
    one enlargement for all, in the title of the panels."""
    circles = [one for fit, old in zip(fits, before, strict=True) for one in _of(fit, old)][:MOST]
    radius = max(np.ptp(c[0].deviation) for c in circles)
    enlarged = _round(SHARE / max(float(radius), 1e-9))  # drawn on a circle of radius one
    layout = base_layout(430, top=80)
    data: list[Figure] = []
    width = 1 / len(circles)
    for k, tests in enumerate(circles):
        across = [k * width + 0.04 * (k > 0), (k + 1) * width - 0.02]
        feed = "" if np.isnan(tests[0].feed) else f", {tests[0].feed * 6e4:.0f} mm/min"
        title = f"{tests[0].plane}{feed}: 0.1 of the radius is {1e5 / enlarged:.3g} um"
        layout |= axes(k, across=across, up=[0.0, 1.0], x=title, y="")
        layout[f"yaxis{number(k)}"] |= {"scaleanchor": f"x{number(k)}", "showticklabels": False}
        layout[f"xaxis{number(k)}"] |= {"showticklabels": False}
        angle = np.linspace(0, 2 * np.pi, 181)
        data.append(_line("", GRID, angle, np.ones(181), panel=k, legend=False))
        shown = (("measured", PALE), ("the model at hand", BEFORE), ("the refined model", AFTER))
        for (name, colour), test in zip(shown, tests, strict=True):
            for way in (True, False):
                mine = np.flatnonzero(test.clockwise == way)
                r = 1 + enlarged * (test.deviation[mine] - tests[0].deviation.mean())
                wide = 4.0 if name == "measured" else 1.5  # the others lie on it
                data.append(_line(name, colour, test.place[mine], r, panel=k, legend=k == 0 and way, width=wide))
        layout["annotations"] += _turning(tests[0], k)
    return {"data": data, "layout": layout}


def _of(fit: SessionFit, before: SessionFit) -> list[tuple[CircularTest, CircularTest, CircularTest]]:
    path = fit.session.path
    if path is None or path.kind != "ballbar":
        return []
    read = (fit.samples.position, before.predicted.position, fit.predicted.position)
    return list(zip(*(circular_tests(path, p[:, 0]) for p in read), strict=True))


def _turning(test: CircularTest, panel: int) -> list[Figure]:
    """The joint that turns, outside of the circle; of several at one place the one that steps the radius most."""
    out: list[Figure] = []
    places: list[float] = []
    for t in sorted(test.turning, key=lambda t: -abs(t.step)):
        if all(abs(np.angle(np.exp(1j * (t.place - p)))) > APART for p in places):
            places.append(t.place)
            x, y = OUTSIDE * np.cos(t.place), OUTSIDE * np.sin(t.place)
            out.append({"text": f"joint {t.joint}", "x": x, "y": y, "showarrow": False, "font": {"size": 11},
                        "xref": f"x{number(panel)}", "yref": f"y{number(panel)}"})  # fmt: skip
    return out


def _line(
    name: str, colour: str, angle: Floats, radius: Floats, *, panel: int, legend: bool, width: float = 1.5
) -> Figure:
    return {
        "type": "scatter", "mode": "lines", "name": name, "legendgroup": name, "showlegend": legend and bool(name),
        "x": np.round(radius * np.cos(angle), 5).tolist(), "y": np.round(radius * np.sin(angle), 5).tolist(),
        "line": {"color": colour, "width": width}, "hoverinfo": "skip", **on_panel(panel),
    }  # fmt: skip


def _round(factor: float) -> float:
    """One digit, downwards."""
    power = 10 ** np.floor(np.log10(factor))
    return float(np.floor(factor / power) * power)
