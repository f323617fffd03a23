"""The figures of a diagnosis: what the error is made of, the candidates, the pattern that an addition explains.

Effects and places go by the catalogue's words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from compensator.report.analysis.pattern import Pattern
from compensator.report.figures.drawing import words_figure
from compensator.report.figures.layout import (
    AFTER,
    AXIS,
    BEFORE,
    BLUE,
    GRID,
    INK,
    ORANGE,
    Figure,
    base_layout,
    heading,
    hover,
    label,
    number,
    on_panel,
)  # fmt: skip
from compensator.report.figures.thinning import numbers, thin
from stiffness.diagnosis.result import Diagnosis

NOISE, PARAMETERS, STRUCTURE, LEFT = "#9aa3ab", "#56b4e9", ORANGE, BLUE
POINTS = 1500
SHOWN = 12  # candidates
ROOM = 0.1  # of the longest bar, for a text in it


@dataclass(frozen=True)
class _Segment:
    """A part of a bar: ``value`` mm of RMS per axis, ``size`` times the mean square of the noise."""

    bar: str
    name: str
    colour: str
    value: float
    size: float


def split_figure(report: dict[str, Any]) -> Figure:
    """A bar per kind of reading, before and after: mean squares, in multiples of the noise's."""
    changed = bool(report["added"] or report["changed"])
    kinds = [(kind, split) for kind, split in report["split_mm"].items() if split is not None]
    segments = [s for kind, split in kinds for s in _segments(kind, split, changed)]
    bars = dict.fromkeys(s.bar for s in segments)
    longest = max((sum(s.size for s in segments if s.bar == bar) for bar in bars), default=1.0)
    first = {s.name: s for s in reversed(segments)}
    layout = base_layout(130 + 46 * len(bars), left=160, top=60, bottom=50)
    layout |= {
        "barmode": "stack",
        "xaxis": {"title": {"text": "mean square, times that of the noise"}, "gridcolor": GRID, "rangemode": "tozero"},
        "yaxis": {"autorange": "reversed", "type": "category", **_APART},
    }
    return {"data": [_drawn(s, longest, legend=first[s.name] is s) for s in segments], "layout": layout}


def _segments(kind: str, split: dict[str, float], changed: bool) -> list[_Segment]:
    """Of the bar before, and where the model has ``changed``, of that after."""
    before = [
        ("noise", NOISE, split["noise"]),
        ("the model's parameters", PARAMETERS, split["parameters"]),
        ("structure it does not know", STRUCTURE, split["structure"]),
    ]
    after = [("noise", NOISE, split["noise"]), ("left above the noise", LEFT, split["left"])]
    floor = split["noise"] or 1e-9
    return [
        _Segment(bar=f"{kind}, {when}", name=name, colour=colour, value=value, size=(value / floor) ** 2)
        for when, parts in (("before", before), ("after", after if changed else []))
        for name, colour, value in parts
    ]


def _drawn(s: _Segment, longest: float, *, legend: bool) -> Figure:
    """``longest``: size of the longest bar; a segment that has no room for its text has none."""
    return {
        "type": "bar", "orientation": "h", "name": s.name, "legendgroup": s.name, "showlegend": legend, "y": [s.bar],
        "x": numbers(np.array([s.size]), 5), "marker": {"color": s.colour}, "width": 0.62, "textposition": "inside",
        "insidetextanchor": "middle", "textangle": 0,
        "textfont": {"color": "#ffffff" if s.name != "noise" else INK},
        "constraintext": "none", "text": [f"{s.value:.3f} mm" if s.size > ROOM * longest else ""],
        "hovertemplate": hover(f"{s.name}: {s.value:.5f} mm"),
    }  # fmt: skip


def ranking_figure(d: Diagnosis) -> Figure:
    """Held-out RMS of the model with one effect more, best first; lines: the model alone, and the noise."""
    there = [c for c in d.candidates if c.where][:SHOWN]
    names = [label(c.effect) for c in there]
    added = {label(a.effect) for a in d.added}
    value = np.array([c.heldout_rms for c in there]) * 1e3
    bars: Figure = {
        "type": "bar", "orientation": "h", "x": numbers(value), "y": names, "showlegend": False, "width": 0.62,
        "marker": {"color": [AFTER if n in added else "#b9c4cd" for n in names]},
        "hovertemplate": hover("%{y}: %{x:.4~g} mm"),
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
    layout = base_layout(140 + 28 * len(names), left=160, top=60, bottom=50)
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
    """Left before, with what an addition explains of it; right after; both at one scale."""
    sides = [(0, [0.0, 0.47], p.titles[0]), (1, [0.53, 1.0], p.titles[1])][: 2 if p.titles[1] else 1]
    layout = base_layout(420, left=70, top=60, bottom=50)
    reach = np.concatenate([p.before, p.after])
    if not len(reach):
        return words_figure("No load state shows this motion by itself: there is nothing to draw.")
    low, high = (float(v) for v in (reach.min(), reach.max()))
    room = 0.06 * max(high - low, 1e-9)
    for k, across, text in sides:
        name = number(k)
        layout[f"xaxis{name}"] = {"domain": across, "anchor": f"y{name}", "title": {"text": p.x_name}, **AXIS}
        layout[f"yaxis{name}"] = {"anchor": f"x{name}", "range": numbers(np.array([low - room, high + room])), **AXIS}
        layout["annotations"].append(heading(text, sum(across) / 2, above=True))
    layout["yaxis"]["title"] = {"text": p.y_name}
    return {"data": _clouds(p), "layout": layout}


def _clouds(p: Pattern) -> list[Figure]:
    kept = thin(np.column_stack([p.x, p.before, p.after]), POINTS)
    clouds = [
        (f"residual, {p.titles[0]}", p.before, BEFORE, "circle-open", 0),
        *([("what the addition says", p.explained, INK, "line-ew-open", 0)] if len(p.explained) else []),
        *([(f"residual, {p.titles[1]}", p.after, AFTER, "circle-open", 1)] if p.titles[1] else []),
    ]
    return [
        {
            "type": "scatter", "mode": "markers", "name": name, "x": numbers(p.x[kept]), "y": numbers(y[kept]),
            **on_panel(panel), "marker": {"size": 7, "color": colour, "symbol": symbol, "line": {"width": 1.6}},
            "hovertemplate": hover(f"{name}: %{{y:.4~g}} at %{{x:.4~g}}"),
        }
        for name, y, colour, symbol, panel in clouds
    ]  # fmt: skip


_APART: Figure = {"ticks": "outside", "ticklen": 8, "tickcolor": "#ffffff"}  # room between a label and its bar
