"""The cut in 3D, coloured by the mean force, over the stock that remains; force, engagement and chip load along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import MillingLoad
from compensator.report.figures.curves import JOINT_COLOURS, Pen, curve, stacked
from compensator.report.figures.layout import BEFORE, FONT, Figure, hover
from compensator.report.figures.path import RAPID_COLOUR, path_scene, segments
from compensator.report.figures.thinning import numbers, thin, typed
from compensator.solve.compensation import Compensation

Floats = npt.NDArray[np.float64]

SCALE = [[0.0, "#ffd24d"], [0.5, "#e8590c"], [1.0, "#6a0572"]]  # none of them is lost on grey
CELLS = 70  # of the mesh of what remains, along the longest side of the stock
GREYS = [[0.0, "#66717a"], [1.0, "#e3e8ec"]]  # of faces away from the light, and towards it
LIGHT = np.array([-0.25, -0.36, 0.9])
# shaded here: plotly.js lights a mesh of many small faces all alike
UNLIT: Figure = {"lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0}, "showscale": False}


def cut_figure(c: Compensation, load: MillingLoad) -> Figure:
    """Force, engagement and chip load at every pose that is shown; the stock that remains, coarsely, and its box."""
    xyz = c.path.toolpath.position * 1e3
    top = max(float(load.size.max(initial=0.0)), 1e-6)
    bar = {"title": {"text": "mean force, N", "side": "top"}, "orientation": "h", "y": 0.0, "yanchor": "bottom"}
    layout: Figure = {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 20, "b": 0},
        "showlegend": False,
        "scene": path_scene(_all_shown(xyz, load), [0.0, 1.0], 0.9),
        "coloraxis": {"colorscale": SCALE, "cmin": 0, "cmax": top, "colorbar": {**bar, "thickness": 14, "len": 0.8}},
    }
    return {"data": [*_remaining(load), _box_edges(load), *_paths(c, load, xyz)], "layout": layout}


def cut_along_figure(c: Compensation, load: MillingLoad) -> Figure:
    """Force, depth, arc and chip load over the path length, cutting poses only; no arc in the air."""
    cut, columns = np.flatnonzero(c.cutting), load.columns
    engaged = np.flatnonzero(c.cutting & load.cut.engaged)
    if not len(engaged):
        engaged = cut[:1]
    force = [
        curve(c, cut, load.size, Pen("mean", BEFORE, "N")),
        curve(c, cut, columns["peak_n"], Pen("peak over a turn", JOINT_COLOURS[5], "N")),
    ]
    arc = [
        curve(c, engaged, columns[f"{end}_deg"], Pen(end, colour, "deg"))
        for end, colour in (("entry", JOINT_COLOURS[0]), ("exit", JOINT_COLOURS[2]))
    ]
    depth = curve(c, cut, columns["ap_mm"], Pen("ap", JOINT_COLOURS[0]))
    chip = curve(c, cut, columns["feed_per_tooth_mm"], Pen("chip load", JOINT_COLOURS[4]))
    panels = [("force, N", force), ("ap, mm", [depth]), ("arc, deg", arc), ("per tooth, mm", [chip])]
    return stacked(panels, 150)


def _paths(c: Compensation, load: MillingLoad, xyz: Floats) -> list[Figure]:
    """Cuts coloured by force, rapids thin and grey; a move belongs to the pose that it ends at."""
    columns = load.columns
    rows = thin(np.column_stack([xyz, load.size]))
    told = np.column_stack([
        c.path.toolpath.line, load.size, columns["ap_mm"], columns["entry_deg"], columns["exit_deg"],
        columns["feed_per_tooth_mm"],
    ])  # fmt: skip
    traces = []
    for cutting in (False, True):
        at, end = segments(c.cutting[rows] == cutting)
        if not len(at):
            continue
        shown = np.where((at < 0)[:, None], np.nan, xyz[rows[at]])
        trace: Figure = {"type": "scatter3d", "mode": "lines", "showlegend": False}
        trace |= {a: numbers(shown[:, i], 3) for i, a in enumerate("xyz")}
        if cutting:
            trace["line"] = {"width": 5, "color": numbers(load.size[rows[end]], 1), "coloraxis": "coloraxis"}
            trace["customdata"] = [numbers(row, 3) for row in told[rows[end]]]
            trace["hovertemplate"] = hover(
                "line %{customdata[0]}", "force %{customdata[1]:.4~g} N", "ap %{customdata[2]:.3~g} mm",
                "arc %{customdata[3]:.1f} to %{customdata[4]:.1f} deg", "chip load %{customdata[5]:.3~g} mm",
            )  # fmt: skip
        else:
            trace |= {"line": {"width": 1.5, "color": RAPID_COLOUR}, "hoverinfo": "skip"}
        traces.append(trace)
    return traces


def _all_shown(xyz: Floats, load: MillingLoad) -> Floats:
    remains = load.cut.remains
    return xyz if remains is None else np.concatenate([xyz, remains.stock.box * 1e3])


def _remaining(load: MillingLoad) -> list[Figure]:
    remains = load.cut.remains
    if remains is None:
        return []
    size = float(np.ptp(remains.stock.box, axis=0).max())
    vertices, faces = remains.mesh(max(size / CELLS, load.cell))
    if not len(faces):
        return []
    a, b, c = vertices[faces].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    shade = 0.5 + 0.5 * (normal @ LIGHT) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
    mesh: Figure = {"type": "mesh3d", "flatshading": True, "hoverinfo": "skip", **UNLIT}
    mesh |= {"intensity": typed(255 * shade, "u1"), "intensitymode": "cell", "cmin": 0, "cmax": 255}
    mesh["colorscale"] = GREYS
    mesh |= {a: typed(vertices[:, i] * 1e3, "f4") for i, a in enumerate("xyz")}
    number = "u2" if len(vertices) < 1 << 16 else "u4"
    return [{**mesh, **{a: typed(faces[:, i], number) for i, a in enumerate("ijk")}}]


def _box_edges(load: MillingLoad) -> Figure:
    """The box around the stock as it was."""
    remains = load.cut.remains
    low, high = (np.zeros(3), np.zeros(3)) if remains is None else remains.stock.box * 1e3
    walk = ("000", "100", "110", "010", "000", "001", "101", "100", "101", "111", "110", "111", "011", "010", "011")
    corner = np.array([[high[i] if w[i] == "1" else low[i] for i in range(3)] for w in walk])
    line: Figure = {"type": "scatter3d", "mode": "lines", "hoverinfo": "skip", "showlegend": False}
    line["line"] = {"width": 1, "color": RAPID_COLOUR}
    return line | {a: numbers(corner[:, i], 2) for i, a in enumerate("xyz")}
