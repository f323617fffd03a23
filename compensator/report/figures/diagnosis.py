"""The figures of the report of a diagnosis.

No text that comes from a file goes into a figure: plotly.js reads markup in labels. Reflectors go by their number,
effects and places by the catalogue's words.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator.report.figures.curves import AFTER, BEFORE, GRID
from compensator.report.figures.thinning import FONT, Figure, numbers, thin
from compensator.report.views.diagnosis_pattern import Pattern
from stiffness.diagnosis.result import Diagnosis

NOISE, PARAMETERS, STRUCTURE, LEFT = "#9aa3ab", "#56b4e9", "#d55e00", "#0072b2"
INK = "#1c2126"
POINTS = 1500
SHOWN = 12  # candidates
ROOM = 0.1  # of the longest bar, for a text in it


def split_figure(report: dict[str, Any]) -> Figure:
    """A bar per kind of evidence, before and after: mean squares, in multiples of the noise's."""
    rows: list[tuple[str, list[tuple[str, float, str]]]] = []
    for kind, s in report["split_mm"].items():
        if s is None:
            continue
        rows.append(
            (
                f"{kind}, before",
                [
                    ("noise", s["noise"], NOISE), ("the model's parameters", s["parameters"], PARAMETERS),
                    ("structure it does not know", s["structure"], STRUCTURE),
                ],
            )
        )  # fmt: skip
        if report["added"] or report["changed"]:
            rows.append((f"{kind}, after", [("noise", s["noise"], NOISE), ("left above the noise", s["left"], LEFT)]))
    floors = {kind: s["noise"] or 1e-9 for kind, s in report["split_mm"].items() if s}
    longest = max((sum((v / floors[_kind(label)]) ** 2 for _, v, _ in parts) for label, parts in rows), default=1.0)
    data, seen = [], set[str]()
    for label, parts in rows:
        floor = floors[_kind(label)]
        for name, value, colour in parts:
            data.append(_segment(label, name, value, (value / floor) ** 2, colour, name not in seen, longest))
            seen.add(name)
    layout = _layout(130 + 46 * len(rows), left=160)
    layout |= {
        "barmode": "stack",
        "xaxis": {"title": {"text": "mean square, times that of the noise"}, "gridcolor": GRID, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "type": "category", **_APART},
    }
    return {"data": data, "layout": layout}


def _kind(label: str) -> str:
    return label.partition(",")[0]


def _segment(label: str, name: str, value: float, size: float, colour: str, legend: bool, longest: float) -> Figure:
    """``longest``: size of the longest bar; a segment that has no room for its text has none."""
    return {
        "type": "bar", "orientation": "h", "name": name, "legendgroup": name, "showlegend": legend, "y": [label],
        "x": numbers(np.array([size]), 5), "marker": {"color": colour}, "width": 0.62, "textposition": "inside",
        "insidetextanchor": "middle", "textangle": 0, "textfont": {"color": "#ffffff" if name != "noise" else INK},
        "constraintext": "none", "text": [f"{value:.3f} mm" if size > ROOM * longest else ""],
        "hovertemplate": f"{name}: {value:.5f} mm<extra></extra>",
    }  # fmt: skip


def ranking_figure(d: Diagnosis) -> Figure:
    """Held-out RMS of the model with one effect more, best first; lines: the model alone, and the noise."""
    there = [c for c in d.candidates if c.where][:SHOWN]
    names = [c.effect for c in there]
    added = {a.effect for a in d.added}
    value = np.array([c.heldout_rms for c in there]) * 1e3
    bars: Figure = {
        "type": "bar", "orientation": "h", "x": numbers(value), "y": names, "showlegend": False, "width": 0.62,
        "marker": {"color": [AFTER if n in added else "#b9c4cd" for n in names]},
        "hovertemplate": "%{y}: %{x:.4~g} mm<extra></extra>",
    }  # fmt: skip
    floor, bare = noise_of(d), model_alone(d)
    marks = [("noise", floor, NOISE)] + ([("the model alone", bare, BEFORE)] if bare else [])
    lines = [
        {
            "type": "scatter", "mode": "lines", "name": f"{name}: {1e3 * at:.4f} mm",
            "x": numbers(np.full(2, at * 1e3)), "y": [names[0], names[-1]],
            "line": {"color": colour, "width": 2, "dash": "dash"}, "hoverinfo": "skip",
        }
        for name, at, colour in marks
    ]  # fmt: skip
    if len(names) == 1:  # a line between two equal categories is a point
        for line in lines:
            line["mode"] = "markers"
    layout = _layout(140 + 28 * len(names), left=160)
    layout |= {
        "xaxis": {"title": {"text": "RMS on set-ups left out, mm"}, "gridcolor": GRID, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "type": "category", **_APART},
    }
    return {"data": [bars, *lines], "layout": layout}


def noise_of(d: Diagnosis) -> float:
    """m per axis: the measure of candidates is the tracker's noise times the weighted residual."""
    return float(np.sqrt(np.mean(np.concatenate([e.samples.sd[e.used] for e in d.base.sessions]) ** 2)))


def model_alone(d: Diagnosis) -> float | None:
    """m, held out, of the model without any effect more: what a candidate has that pays nowhere."""
    return next((c.heldout_rms for c in d.candidates if not c.where), None)


def pattern_figure(p: Pattern) -> Figure:
    """Left before, with what an addition says of it if there is one; right after; one scale."""
    kept = thin(np.column_stack([p.x, p.before, p.after]), POINTS)
    layout = _layout(420)
    panels = [("", [0.0, 0.47], p.titles[0]), ("2", [0.53, 1.0], p.titles[1])][: 2 if p.titles[1] else 1]
    reach = np.concatenate([p.before, p.after])
    low, high = (float(v) for v in (reach.min(), reach.max()))
    room = 0.06 * max(high - low, 1e-9)
    for name, across, text in panels:
        layout[f"xaxis{name}"] = {"domain": across, "anchor": f"y{name}", "title": {"text": p.x_name}, **_AXIS}
        layout[f"yaxis{name}"] = {"anchor": f"x{name}", "range": numbers(np.array([low - room, high + room])), **_AXIS}
        layout["annotations"].append(
            {
                "text": f"<b>{text}</b>", "x": sum(across) / 2, "y": 1.0, "xref": "paper", "yref": "paper",
                "xanchor": "center", "yanchor": "bottom", "showarrow": False,
            }
        )  # fmt: skip
    layout["yaxis"]["title"] = {"text": p.y_name}
    clouds = [
        (f"residual, {p.titles[0]}", p.before, BEFORE, "circle-open", ""),
        *([("what the addition says", p.says, INK, "line-ew-open", "")] if len(p.says) else []),
        *([(f"residual, {p.titles[1]}", p.after, AFTER, "circle-open", "2")] if p.titles[1] else []),
    ]
    data: list[Figure] = [
        {
            "type": "scatter", "mode": "markers", "name": name, "x": numbers(p.x[kept]), "y": numbers(y[kept]),
            "xaxis": f"x{panel}", "yaxis": f"y{panel}",
            "marker": {"size": 7, "color": colour, "symbol": symbol, "line": {"width": 1.6}},
            "hovertemplate": f"{name}: %{{y:.4~g}} at %{{x:.4~g}}<extra></extra>",
        }
        for name, y, colour, symbol, panel in clouds
    ]  # fmt: skip
    return {"data": data, "layout": layout}


_APART: Figure = {"ticks": "outside", "ticklen": 8, "tickcolor": "#ffffff"}  # room between a label and its bar
_AXIS: Figure = {"gridcolor": GRID, "zerolinecolor": "#b4bac0", "exponentformat": "power"}


def _layout(height: int, left: int = 70) -> Figure:
    return {
        "font": FONT, "height": height, "margin": {"l": left, "r": 20, "t": 60, "b": 50}, "plot_bgcolor": "#ffffff",
        "showlegend": True, "annotations": [],
        "legend": {"orientation": "h", "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "top", "yref": "container"},
    }  # fmt: skip
