"""Curves along the path: deflection, joint angles against their limits, flanks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator.report.figures.layout import AFTER, BEFORE, FONT, GRID, ORANGE, ZERO_LINE, Figure, hover, label, number
from compensator.report.figures.thinning import Floats, Index, numbers, path_length, thin
from compensator.solve.compensation import Compensation
from stiffness.memory.preload import PreloadState
from stiffness.memory.state_columns import state_columns

# colours after Okabe and Ito: colour-blind readers can distinguish them
JOINT_COLOURS = ("#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#000000", "#777777")
UNKNOWN = "#777777"
LANE = 0.36  # half the height of a joint's lane, of 1 between two joints
Panel = tuple[str, list[Figure]]


@dataclass(frozen=True)
class Pen:
    """How a curve is drawn: its name, its colour, and the unit of its values."""

    name: str
    colour: str
    unit: str = "mm"


def along_figure(c: Compensation, before: Floats, after: Floats | None) -> Figure:
    """Deflection along the path, cutting poses only, and the correction along all of it.

    Args:
        before, after: (N,) mm; without ``after`` only what preview knows.
    """
    cut, every = np.flatnonzero(c.cutting), np.arange(len(c))
    if after is None:
        distance = curve(c, cut, before, Pen("distance", BEFORE))
        return stacked(
            [("distance, mm", [distance]), ("deflection, mm", _three(c, cut, c.error_before, "d{}"))]
        )
    both = [curve(c, cut, before, Pen("before", BEFORE)), curve(c, cut, after, Pen("after", AFTER))]
    unit, per_mm = ("µm", 1e3) if after[cut].max() >= 1e-5 else ("nm", 1e6)
    return stacked(
        [
            ("distance, mm", both),
            (f"after, {unit}", [curve(c, cut, after * per_mm, Pen("after", AFTER, unit))]),
            ("deflection before, mm", _three(c, cut, c.error_before, "d{} before")),
            ("correction, mm", _three(c, every, c.correction, "correction {}")),
        ]
    )


def _three(c: Compensation, rows: Index, vectors: Floats, name: str) -> list[Figure]:
    """x, y and z of vectors (N, 3) in m."""
    return [
        curve(c, rows, vectors[:, i] * 1e3, Pen(name.format(a), JOINT_COLOURS[i])) for i, a in enumerate("xyz")
    ]


def curve(c: Compensation, rows: Index, value: Floats, pen: Pen) -> Figure:
    """One thinned line over the path length, broken where ``rows`` leaves poses out."""
    kept = rows[thin(value[rows][:, None])]
    run = np.cumsum(np.diff(rows, prepend=rows[:1]) > 1)[np.searchsorted(rows, kept)]
    alone = np.bincount(run)[run] == 1
    gaps = np.flatnonzero(np.diff(run)) + 1
    return {
        "type": "scatter",
        "mode": "lines+markers" if alone.any() else "lines",
        "name": pen.name,
        "x": numbers(np.insert(path_length(c)[kept], gaps, np.nan), 6),
        "y": numbers(np.insert(value[kept], gaps, np.nan)),
        "customdata": np.insert(c.path.toolpath.line[kept], gaps, 0).tolist(),
        "line": {"width": 1.4, "color": pen.colour},
        "marker": {"size": 4},
        "hovertemplate": hover(f"{pen.name} %{{y:.5~g}} {pen.unit} (line %{{customdata}})"),
    }


def stacked(panels: list[Panel], height: float = 220) -> Figure:
    """Panels above each other over one path length, ``height`` px each, every panel with its own legend."""
    gap = 0.06
    share = (1 - gap * (len(panels) - 1)) / len(panels)
    last = f"y{number(len(panels) - 1)}"
    layout: Figure = {
        "font": FONT,
        "height": 90 + height * len(panels),
        "margin": {"l": 85, "r": 150, "t": 40, "b": 50},
        "hovermode": "x",
        "showlegend": True,
        "plot_bgcolor": "#ffffff",
        "xaxis": {"title": {"text": "path length, rapids included, m"}, "anchor": last, "gridcolor": GRID},
    }
    data = []
    for k, (title, curves) in enumerate(panels):
        name = number(k)
        top = 1 - k * (share + gap)
        layout[f"yaxis{name}"] = {
            "title": {"text": title, "standoff": 14},
            "automargin": True,
            "domain": [max(0.0, top - share), top],
            "gridcolor": GRID,
            "zerolinecolor": ZERO_LINE,
            "rangemode": "tozero",
            "exponentformat": "power",
        }
        layout[f"legend{name}"] = {"y": top, "yanchor": "top", "x": 1.01}
        data += [{**curve, "xaxis": "x", "yaxis": f"y{name}", "legend": f"legend{name}"} for curve in curves]
    return {"data": data, "layout": layout}


def joints_figure(c: Compensation) -> Figure:
    """Commanded joint angles as percent of each joint's range: 0 and 100 are its limits."""
    low, high, every = c.job.arm.robot.lower, c.job.arm.robot.upper, np.arange(len(c))
    percent = 100 * (c.command.q - low) / (high - low)
    curves = [
        curve(c, every, percent[:, j], Pen(f"joint {j + 1}", _colour(j), "%")) for j in range(c.job.arm.robot.n)
    ]
    figure = stacked([("angle, % of the joint's range", curves)], 330)
    figure["layout"]["shapes"] = [_band(0, 5), _band(95, 100)]
    figure["layout"]["yaxis"] |= {"range": [-2, 102], "tickvals": [0, 25, 50, 75, 100], "zeroline": False}
    return figure


def _colour(joint: int) -> str:
    return JOINT_COLOURS[joint % len(JOINT_COLOURS)]


def _band(low: float, high: float) -> Figure:
    place = {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": low, "y1": high}
    return {**place, "fillcolor": ORANGE, "opacity": 0.13, "line": {"width": 0}, "layer": "below"}


def flanks_figure(c: Compensation) -> Figure | None:
    """What every joint remembers, one lane per joint, one panel per effect; None when nothing remembers.

    Of an effect with several states per joint the lane shows their sum.
    """
    n = c.job.arm.robot.n
    columns = state_columns(c.job.arm.effects, n)
    panels: list[Panel] = []
    for effect in c.job.arm.effects:
        if effect.memory is not None:
            half = effect.memory.bounds(c.job.arm.values[effect.name]).reshape(-1, n).sum(axis=0)
            own = columns[effect.name]
            edges = (s[:, own].reshape(len(c), -1, n).sum(axis=1) for s in (c.state.low, c.state.high, c.state.middle))
            state = PreloadState(*edges)
            lanes = [_lane(c, int(j), state, float(half[j])) for j in np.flatnonzero(half > 0)]
            panels.append((label(effect.name), [curve for lane in lanes for curve in lane]))
    if not panels:
        return None
    figure = stacked(panels, 46 * n)
    for key in [k for k in figure["layout"] if k.startswith("yaxis")]:
        figure["layout"][key] |= {
            "tickvals": [n - j for j in range(n)],
            "ticktext": [f"joint {j + 1}" for j in range(n)],
            "range": [0.4, n + 0.6],
            "zeroline": False,
        }
    return figure


def _lane(c: Compensation, joint: int, state: PreloadState, half: float) -> list[Figure]:
    """The state of one joint between its bounds, and the bracket where it is not known."""
    at, name = c.job.arm.robot.n - joint, f"joint {joint + 1}"
    middle = at + LANE * state.middle[:, joint] / half
    lane = curve(c, np.arange(len(c)), middle, Pen(name, _colour(joint)))
    lane |= {"hovertemplate": hover(f"{name} (line %{{customdata}})"), "showlegend": False}
    unsure = np.flatnonzero(~state.known[:, joint])
    if not len(unsure):
        return [lane]
    band = []
    for edge in (state.low, state.high):
        side = curve(c, unsure, at + LANE * edge[:, joint] / half, Pen(f"{name}, not known", UNKNOWN))
        side |= {"mode": "lines", "showlegend": False, "hoverinfo": "skip", "line": {"width": 0}}
        del side["hovertemplate"]
        band.append(side)
    band[1] |= {"fill": "tonexty", "fillcolor": "rgba(110,110,110,0.35)"}
    return [*band, lane]
