"""The cut in 3D: the path coloured by the mean force, over the stock that remains."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import MillingLoad
from compensator.report.figures.layout import FONT, Figure, hover
from compensator.report.figures.path import RAPID_COLOUR, path_scene
from compensator.report.figures.thinning import numbers, thin
from compensator.solve.compensation import Compensation

Floats = npt.NDArray[np.float64]

SCALE = "Inferno"
CELLS = 70  # of the mesh of what remains, along the longest side of the stock
STOCK_COLOUR = "#b8c0c8"


def cut_figure(c: Compensation, load: MillingLoad) -> Figure:
    """Force, engagement and chip load at every pose that is shown; the stock that remains, coarsely, and its box."""
    xyz = c.path.toolpath.position * 1e3
    columns = load.columns
    rows = thin(np.column_stack([xyz, load.size]))
    force = load.size[rows]
    told = np.column_stack([
        c.path.toolpath.line[rows], force, columns["ap_mm"][rows], columns["entry_deg"][rows],
        columns["exit_deg"][rows], columns["feed_per_tooth_mm"][rows],
    ])  # fmt: skip
    cut = load.cut.engaged[rows]
    trace: Figure = {"type": "scatter3d", "mode": "lines+markers", "showlegend": False}
    trace |= {a: numbers(xyz[rows, i], 3) for i, a in enumerate("xyz")}
    trace["line"] = {"width": 1.5, "color": RAPID_COLOUR}
    sizes = [3 if on else 0 for on in cut.tolist()]
    trace["marker"] = {"size": sizes, "color": numbers(force, 1), "coloraxis": "coloraxis"}
    trace["customdata"] = [numbers(row, 3) for row in told]
    trace["hovertemplate"] = hover(
        "line %{customdata[0]}", "force %{customdata[1]:.4~g} N", "ap %{customdata[2]:.3~g} mm",
        "arc %{customdata[3]:.1f} to %{customdata[4]:.1f} deg", "chip load %{customdata[5]:.3~g} mm",
    )  # fmt: skip
    top = max(float(force.max(initial=0.0)), 1e-6)
    bar = {"title": {"text": "mean force, N", "side": "top"}, "orientation": "h", "y": 0.0, "yanchor": "bottom"}
    layout: Figure = {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 20, "b": 0},
        "showlegend": False,
        "scene": path_scene(_all_shown(xyz, load), [0.0, 1.0], 0.9),
        "coloraxis": {"colorscale": SCALE, "cmin": 0, "cmax": top, "colorbar": bar},
    }
    return {"data": [*_remaining(load), _box_edges(load), trace], "layout": layout}


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
    mesh: Figure = {"type": "mesh3d", "color": STOCK_COLOUR, "flatshading": True, "hoverinfo": "skip"}
    mesh |= {a: numbers(vertices[:, i] * 1e3, 2) for i, a in enumerate("xyz")}
    return [{**mesh, **{a: faces[:, i].tolist() for i, a in enumerate("ijk")}}]


def _box_edges(load: MillingLoad) -> Figure:
    """The box around the stock as it was."""
    remains = load.cut.remains
    low, high = (np.zeros(3), np.zeros(3)) if remains is None else remains.stock.box * 1e3
    walk = ("000", "100", "110", "010", "000", "001", "101", "100", "101", "111", "110", "111", "011", "010", "011")
    corner = np.array([[high[i] if w[i] == "1" else low[i] for i in range(3)] for w in walk])
    line: Figure = {"type": "scatter3d", "mode": "lines", "hoverinfo": "skip", "showlegend": False}
    line["line"] = {"width": 1, "color": RAPID_COLOUR}
    return line | {a: numbers(corner[:, i], 2) for i, a in enumerate("xyz")}
