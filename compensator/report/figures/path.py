"""The path in 3D, coloured by deflection."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.report.figures.layout import FONT, Figure, heading, hover, number
from compensator.report.figures.thinning import Floats, Index, numbers, thin
from compensator.solve.compensation import Compensation
from toolpaths.toolpath import CUT

RAPID_COLOUR = "#7b858e"
SCALE = "Viridis"
_LABEL = "distance from where the TCP has to be, mm"


def path_figure(c: Compensation, views: list[tuple[str, Floats]]) -> Figure:
    """The path in the work object, mm, coloured by deflection: one scene per view (title, (N,) mm).

    Two buttons: one colour range from 0 for all views, or for each its own.
    """
    xyz = c.path.toolpath.position * 1e3
    rows = thin(np.column_stack([xyz, *(value for _, value in views)]))
    ranges = [(float(value[c.cutting].min()), float(value[c.cutting].max())) for _, value in views]
    top = max(high for _, high in ranges) or 1e-6
    data: list[Figure] = []
    layout: Figure = {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 60, "b": 0},
        "showlegend": False,
        "annotations": [],
        "updatemenus": [_range_buttons(top, ranges)],
    }
    for k, (title, value) in enumerate(views):
        name = number(k)
        left, right = k / len(views) + 0.005, (k + 1) / len(views) - 0.005
        data += _path_traces(c, rows, value, scene=name)
        layout[f"scene{name}"] = path_scene(xyz, [left, right], 1.0 if len(views) > 1 else 0.9)
        layout[f"coloraxis{name}"] = _colours(top, 0.5 * (left + right), 0.8 / len(views))
        layout["annotations"].append(heading(title, 0.5 * (left + right)))
    return {"data": data, "layout": layout}


def _colours(top: float, x: float, length: float) -> Figure:
    bar = {"orientation": "h", "x": x, "y": 0.0, "yanchor": "bottom", "len": length, "thickness": 14}
    bar |= {"title": {"text": _LABEL, "side": "top"}, "exponentformat": "power"}
    return {"colorscale": SCALE, "cmin": 0, "cmax": top, "colorbar": bar}


def _range_buttons(top: float, ranges: list[tuple[float, float]]) -> Figure:
    """Change the colour range of all views together."""
    shared: Figure = {}
    own: Figure = {}
    for k, (low, high) in enumerate(ranges):
        axis = f"coloraxis{number(k)}"
        shared |= {f"{axis}.cmin": 0, f"{axis}.cmax": top}
        own |= {f"{axis}.cmin": low, f"{axis}.cmax": max(high, low + 1e-9)}
    names = ("one range from 0", "each its own range") if len(ranges) > 1 else ("range from 0", "own range")
    buttons = [
        {"label": text, "method": "relayout", "args": [args]}
        for text, args in zip(names, (shared, own), strict=True)
    ]
    place = {"x": 0.01, "xanchor": "left", "y": 1.0, "yanchor": "bottom", "pad": {"t": 0, "b": 6}}
    return {"type": "buttons", "direction": "right", "buttons": buttons, "font": {"size": 12}, **place}


def _path_traces(c: Compensation, rows: Index, value: Floats, *, scene: str) -> list[Figure]:
    """Cuts coloured, rapids thin and grey; a segment belongs to the pose that it ends at."""
    cut = c.path.toolpath.kind[rows] == CUT
    xyz = c.path.toolpath.position * 1e3
    traces = []
    for cutting in (False, True):
        at, end = segments(cut == cutting)
        if not len(at):
            continue
        shown = np.where((at < 0)[:, None], np.nan, xyz[rows[at]])
        trace: Figure = {"type": "scatter3d", "mode": "lines", "scene": f"scene{scene}", "showlegend": False}
        trace |= {a: numbers(shown[:, i], 3) for i, a in enumerate("xyz")}
        if cutting:
            colour = numbers(value[rows[end]])
            line = c.path.toolpath.line[rows[end]].tolist()
            trace["line"] = {"width": 5, "color": colour, "coloraxis": f"coloraxis{scene}"}
            trace["customdata"] = [list(pair) for pair in zip(line, colour, strict=True)]
            trace["hovertemplate"] = hover(
                "line %{customdata[0]}", "x %{x:.2f}, y %{y:.2f}, z %{z:.2f} mm", "error %{customdata[1]:.5~g} mm"
            )
        else:
            trace |= {"line": {"width": 1.5, "color": RAPID_COLOUR}, "hoverinfo": "skip"}
        traces.append(trace)
    return traces


def segments(mine: npt.NDArray[np.bool_]) -> tuple[Index, Index]:
    """Points of the lines that end at the poses of ``mine``, and the pose that colours each point.

    A run begins at the pose before it, in the colour of its own first pose; -1 stands for a gap.
    """
    at: list[Index] = [np.empty(0, dtype=np.intp)]
    end: list[Index] = [np.empty(0, dtype=np.intp)]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mine, [False]]).astype(np.int8)))
    for first, stop in edges.reshape(-1, 2):
        run = np.arange(first, stop)
        at += [np.array([max(first - 1, 0)]), run, np.array([-1])]
        end += [run[:1], run, run[-1:]]
    return np.concatenate(at), np.concatenate(end)


def path_scene(xyz: Floats, across: list[float], away: float) -> Figure:
    """Equal axes: the ranges and the shape of the box go together; a flat path still gets a box."""
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    largest = max(float((high - low).max()), 1.0)
    size = np.maximum((high - low) * 1.06, 0.12 * largest)
    middle = 0.5 * (low + high)
    scene: Figure = {
        "domain": {"x": across, "y": [0.12, 0.95]},
        "aspectmode": "manual",
        "aspectratio": {a: float(round(1.35 * s / size.max(), 6)) for a, s in zip("xyz", size, strict=True)},
        "camera": {
            "eye": {"x": -0.95 * away, "y": -1.35 * away, "z": 1.1 * away},
            "center": {"x": 0, "y": 0, "z": -0.1},
        },
    }
    for i, a in enumerate("xyz"):
        scene[f"{a}axis"] = {
            "title": {"text": f"{a}, mm"},
            "range": numbers(middle[i] + np.array([-0.5, 0.5]) * size[i], 3),
            "backgroundcolor": "#eef0f2",
            "showbackground": True,
            "gridcolor": "#ffffff",
            "nticks": 6 if size[i] > 0.3 * size.max() else 3,
            "tickfont": {"size": 11},
        }
    return scene
