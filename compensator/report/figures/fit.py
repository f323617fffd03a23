"""The figures of a fit: residuals per reflector and per joint, are they noise, correlations of the numbers.

Reflectors go by their number.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import stats

from compensator.report.analysis.by_joint import JointResiduals
from compensator.report.analysis.by_reflector import ReflectorResiduals
from compensator.report.figures.layout import (
    AFTER,
    BEFORE,
    BLUE,
    INK,
    ORANGE,
    Figure,
    axes,
    base_layout,
    heading,
    hover,
    label,
    number,
    on_panel,
)  # fmt: skip
from compensator.report.figures.thinning import Floats, numbers, thin
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from stiffness.identification.unknowns import Unknown

DIVERGING = [[0.0, BLUE], [0.5, "#ffffff"], [1.0, ORANGE]]
COLUMNS = 3
POINTS = 800  # of a joint's panel
WIDEST = 5.0  # standard deviations that the histogram shows
STEP = 0.25
NAMED = 64  # numbers that an axis still has room to name
LETTER = {"k_nm_per_rad": "k", "gap_rad": "gap", "breakaway_nm": "breakaway"}


def reflectors_figure(kinds: dict[str, list[ReflectorResiduals]]) -> Figure:
    """A row of two panels per kind of evidence: RMS of the rigid arm, and of the fit with the noise floor."""
    data: list[Figure] = []
    layout = base_layout(95 + 240 * len(kinds))
    for row, (kind, at) in enumerate(kinds.items()):
        names = [f"{k + 1}" for k in range(len(at))]
        high = 1 - row / len(kinds)
        low = high - (0.78 if row + 1 < len(kinds) else 0.92) / len(kinds)
        for side, (title, colour) in enumerate((("before (rigid)", BEFORE), ("after (fitted)", AFTER))):
            panel = 2 * row + side
            value = np.array([a.fitted if side else a.rigid for a in at]) * 1e3
            data.append(_bars(names, value, title=title, colour=colour, panel=panel))
            if side:
                data.append(_floor(names, np.array([a.floor for a in at]) * 1e3, panel))
            across = [0.56, 1.0] if side else [0.0, 0.44]
            layout |= axes(panel, across=across, up=[low, high - 0.09 / len(kinds)], x="reflector", y="RMS, mm")
            layout[f"xaxis{number(panel)}"] |= {"type": "category"}
            layout["annotations"].append(heading(f"{kind}, {title}", sum(across) / 2, high))
    return {"data": data, "layout": layout}


def _bars(names: list[str], value: Floats, *, title: str, colour: str, panel: int) -> Figure:
    return {
        "type": "bar", "name": title, "x": names, "y": numbers(value), "marker": {"color": colour}, "width": 0.5,
        "hovertemplate": hover(f"reflector %{{x}}, {title}: %{{y:.4~g}} mm"), "showlegend": False,
        **on_panel(panel),
    }  # fmt: skip


def _floor(names: list[str], value: Floats, panel: int) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "name": "what noise alone leaves", "x": names, "y": numbers(value),
        "marker": {"symbol": "line-ew-open", "size": 44, "color": INK, "line": {"width": 3}},
        "hovertemplate": hover("reflector %{x}, noise: %{y:.4~g} mm"), "showlegend": panel == 1,
        **on_panel(panel),
    }  # fmt: skip


def joints_figure(at: list[JointResiduals], enlarged: bool = False) -> Figure:
    """A panel per joint: residual displacement over the torque of the load, mm; ``enlarged``: only after, µm."""
    rows = -(-len(at) // COLUMNS)
    layout = base_layout(110 + 230 * rows)
    data: list[Figure] = []
    for j, joint in enumerate(at):
        row, column = divmod(j, COLUMNS)
        across = [column / COLUMNS + 0.03 * (column > 0), (column + 1) / COLUMNS - 0.03]
        high = 1 - row / rows - 0.09 / rows
        unit = "µm" if enlarged else "mm"
        layout |= axes(
            j, across=across, up=[high - 0.62 / rows, high], x="torque, N·m", y="" if column else unit
        )
        text = f"joint {j + 1}" if len(joint.torque) else f"joint {j + 1}: no displacement loads it"
        layout["annotations"].append(heading(text, sum(across) / 2, high + 0.085 / rows))
        data += _clouds(j, joint, enlarged)
    return {"data": data, "layout": layout}


def _clouds(j: int, joint: JointResiduals, enlarged: bool) -> list[Figure]:
    unit, factor = ("µm", 1e6) if enlarged else ("mm", 1e3)
    kept = thin(np.column_stack([joint.torque, joint.rigid, joint.fitted]), POINTS)
    clouds = [("before (rigid)", joint.rigid, BEFORE, "circle-open"), ("after (fitted)", joint.fitted, AFTER, "circle")]
    return [
        {
            "type": "scatter", "mode": "markers", "name": name, "legendgroup": name, "showlegend": j == 0,
            "x": numbers(joint.torque[kept]), "y": numbers(value[kept] * factor), **on_panel(j),
            "marker": {"size": 5, "color": colour, "symbol": symbol, "opacity": 0.75},
            "hovertemplate": hover(f"joint {j + 1}: %{{x:.4~g}} N·m, {name} %{{y:.3~g}} {unit}"),
        }
        for name, value, colour, symbol in clouds[int(enlarged) :]
    ]  # fmt: skip


def normal_figure(z: Floats) -> Figure:
    """Histogram of standardised residuals, and their normal-probability plot, each with what noise alone gives."""
    edges = np.arange(-WIDEST, WIDEST + STEP / 2, STEP)
    middle = 0.5 * (edges[1:] + edges[:-1])
    found, _ = np.histogram(np.clip(z, -WIDEST, WIDEST), edges)
    expected = len(z) * np.diff(stats.norm.cdf(edges))
    ordered = np.sort(z)
    quantile = stats.norm.ppf((np.arange(len(z)) + 0.5) / max(len(z), 1))
    kept = _spread(len(z))
    ends = float(np.max(np.abs(quantile), initial=1.0))
    layout = base_layout(400)
    layout |= axes(0, across=[0.0, 0.45], up=[0, 0.92], x="residual / its standard deviation", y="count")
    layout |= axes(1, across=[0.55, 1.0], up=[0, 0.92], x="expected of a normal distribution", y="found")
    layout["bargap"] = 0.04
    line = {"type": "scatter", "mode": "lines", "name": "expected", "line": {"color": BEFORE, "width": 2.5}}
    data: list[Figure] = [
        {
            "type": "bar", "name": "residuals", "x": numbers(middle, 4), "y": found.tolist(),
            "marker": {"color": AFTER}, **on_panel(0), "hovertemplate": hover("%{x}: %{y}"),
        },
        {**line, "x": numbers(middle, 4), "y": numbers(expected, 2), **on_panel(0), "hoverinfo": "skip"},
        {
            "type": "scatter", "mode": "markers", "name": "residuals", "showlegend": False, **on_panel(1),
            "x": numbers(quantile[kept], 4), "y": numbers(ordered[kept], 4), "marker": {"size": 5, "color": AFTER},
            "hovertemplate": hover("expected %{x:.3~g}, found %{y:.3~g}"),
        },
        {**line, "x": [-ends, ends], "y": [-ends, ends], "showlegend": False, **on_panel(1), "hoverinfo": "skip"},
    ]  # fmt: skip
    return {"data": data, "layout": layout}


def _spread(count: int) -> Any:
    """Rows of a sorted list to draw: all of the tails, evenly in between."""
    if count <= POINTS:
        return np.arange(count)
    tail = POINTS // 4
    middle = np.linspace(tail, count - tail - 1, POINTS - 2 * tail).astype(int)
    return np.unique(np.concatenate([np.arange(tail), middle, np.arange(count - tail, count)]))


def correlation_figure(fit: Fit, correlation: Floats) -> Figure:
    """Heat map of the correlations (P, P) of the robot's numbers."""
    names = [short(u) for u in fit.unknowns.free]
    side = min(960, max(380, 150 + 16 * len(names)))
    layout = base_layout(side)
    layout |= {"width": side + 130, "showlegend": False, "margin": {"l": 60, "r": 20, "t": 40, "b": 60}}
    axis: Figure = {"type": "category", "showgrid": False, "tickfont": {"size": 10}, "automargin": True, "ticks": ""}
    axis |= {"showticklabels": len(names) <= NAMED}
    layout |= {"xaxis": {**axis, "tickangle": -90}, "yaxis": {**axis, "autorange": "reversed"}}
    heat: Figure = {
        "type": "heatmap", "x": names, "y": names, "z": [numbers(row, 3) for row in correlation],
        "zmin": -1, "zmax": 1, "colorscale": DIVERGING, "xgap": 1, "ygap": 1,
        "colorbar": {"thickness": 14, "title": {"text": "correlation"}},
        "hovertemplate": hover("%{y} and %{x}: %{z:.2f}"),
    }  # fmt: skip
    return {"data": [heat], "layout": layout}


def short(u: Unknown) -> str:
    """A name for an axis; the effects' own words, none from a file."""
    name = LETTER.get(u.parameter.name, u.parameter.name.replace("_rad", "").replace("_m", ""))
    of_every_fit = BY_NAME[u.effect].fitted_where in ("load", "position")
    return label(f"{'' if of_every_fit else u.effect} {name} {u.index + 1}".strip())
