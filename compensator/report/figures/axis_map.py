"""An axis map as a picture and as figures of a page: four fields over position along the path and turn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from compensator.report.csv.axis_map import STATUS
from compensator.report.figures.layout import AXIS, FONT, Figure, heading, hover, on_panel
from compensator.turn.axis_map import AxisMap
from compensator.turn.turn_grid import BEYOND_LIMIT, COLLIDING, FREE, OUT_OF_REACH, SINGULAR

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]

#: Of what forbids a turn, after Okabe and Ito; a free cell has the colour of its value.
FORBIDDEN = {OUT_OF_REACH: "#8c8c8c", BEYOND_LIMIT: "#d55e00", SINGULAR: "#cc79a7", COLLIDING: "#1c2126"}
MOST_COLUMNS = 700  # of the page and the picture: a screen has no more


@dataclass(frozen=True)
class MapField:
    """One field of the map: ``values`` (M, T) in the unit of ``title``; ``scale`` is a name of a colour scale."""

    title: str
    values: Floats
    scale: str


def fields_of(m: AxisMap) -> tuple[MapField, ...]:
    """The four fields, NaN where a turn is forbidden."""
    free = m.grid.free
    room = np.where(free, np.clip(m.grid.margin, 0.0, 1.0), np.nan)
    return (
        MapField("room to limits and singularities, 1 = 45 deg and more", room, "viridis"),
        MapField("predicted deflection, µm", m.reliance.deflection * 1e6, "magma_r"),
        MapField("its standard deviation, µm", m.reliance.sd * 1e6, "magma_r"),
        MapField("joints that reverse here, at a constant turn", np.where(free, m.reversing, np.nan), "Blues"),
    )


def drawn_columns(m: AxisMap) -> npt.NDArray[np.intp]:
    """Poses of the map that are drawn, evenly."""
    count = len(m.grid.rows)
    return np.unique(np.linspace(0, count - 1, min(count, MOST_COLUMNS)).round().astype(np.intp))


def _gathered(m: AxisMap, columns: npt.NDArray[np.intp]) -> list[MapField]:
    """The fields at the drawn columns; reversals between two of them are counted at the second one."""
    fields = list(fields_of(m))
    counts = np.add.reduceat(np.nan_to_num(fields[3].values), np.append(0, columns[:-1] + 1), axis=0)
    counts = np.where(m.grid.free[columns], counts, np.nan)
    shown = [replace(f, values=f.values[columns]) for f in fields[:3]]
    return [*shown, replace(fields[3], values=counts)]


def signed(turn: Floats) -> Floats:
    """Turns in deg from -180 up to 180."""
    return np.asarray((np.degrees(turn) + 180.0) % 360.0 - 180.0)


def curve(m: AxisMap, columns: npt.NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Position (K,) m and turn (K,) deg of the chosen curve, broken by NaN where it leaves at an edge."""
    x, y = m.position[columns], signed(m.chosen[columns])
    jump = np.flatnonzero(np.abs(np.diff(y)) > 180.0) + 1
    return np.insert(x, jump, np.nan), np.insert(y, jump, np.nan)


def draw(m: AxisMap, title: str, target: Path) -> None:
    """The four fields as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas
    from matplotlib.patches import Patch

    canvas = Canvas(figsize=(14.0, 8.6), dpi=110, layout="constrained")
    FigureCanvasAgg(canvas)
    canvas.suptitle(title, fontsize=11)
    axes = canvas.subplots(2, 2, sharex=True, sharey=True)
    columns = drawn_columns(m)
    for k, field in enumerate(_gathered(m, columns)):
        _field(axes.flat[k], m, columns, field)
        if k % 2 == 0:
            axes.flat[k].set_ylabel("turn about the tool axis, deg")
        if k >= 2:
            axes.flat[k].set_xlabel("position along the path, m")
    found = [code for code in FORBIDDEN if np.any(m.grid.status == code)]
    patches = [Patch(color=FORBIDDEN[code], label=STATUS[code]) for code in found]
    patches.append(Patch(facecolor="white", edgecolor="black", label="chosen turn"))
    canvas.legend(handles=patches, loc="outside lower center", ncols=5, fontsize=9, frameon=False)
    canvas.savefig(target, format="png", metadata={"Software": None})


def _field(axes: Axes, m: AxisMap, columns: npt.NDArray[np.intp], field: MapField) -> None:
    import matplotlib
    from matplotlib.colors import ListedColormap
    from matplotlib.patheffects import withStroke

    order = np.argsort(signed(m.grid.turns), kind="stable")
    x, y = _edges(m.position[columns]), _edges(signed(m.grid.turns)[order])
    status = m.grid.status[columns][:, order].T
    shades = ListedColormap([FORBIDDEN.get(np.uint8(k), "#ffffff") for k in range(len(STATUS))])
    axes.pcolormesh(x, y, status, cmap=shades, vmin=-0.5, vmax=len(STATUS) - 0.5, rasterized=True)
    values = np.ma.masked_invalid(field.values[:, order].T)
    low, high = _span(values.compressed())
    mesh = axes.pcolormesh(x, y, values, cmap=matplotlib.colormaps[field.scale], vmin=low, vmax=high, rasterized=True)
    bar = axes.figure.colorbar(mesh, ax=axes, shrink=0.95)
    bar.ax.tick_params(labelsize=8)
    axes.set_title(field.title, fontsize=10)
    axes.set_yticks(range(-180, 181, 45))
    rim = [withStroke(linewidth=3.4, foreground="black")]
    axes.plot(*curve(m, columns), color="white", linewidth=1.6, path_effects=rim)


def _span(values: Floats) -> tuple[float, float]:
    """The range of colours: a singular rim is not allowed to take all of them."""
    if not len(values):
        return 0.0, 1.0
    low, high = (float(v) for v in np.percentile(values, (0.5, 99.5)))
    return (low, high) if high > low else (low, max(float(values.max()), low + 1e-9))


def _edges(centres: Floats) -> Floats:
    """(K + 1,) edges of cells about ascending centres (K,)."""
    if len(centres) < 2:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    inner = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - inner[0]], inner, [2 * centres[-1] - inner[-1]]])


def axis_map_figure(m: AxisMap) -> Figure:
    """The four fields for a page, above each other, with one axis of position."""
    columns = drawn_columns(m)
    order = np.argsort(signed(m.grid.turns), kind="stable")
    y = signed(m.grid.turns)[order].tolist()
    x = m.position[columns].round(6).tolist()
    fields = _gathered(m, columns)
    data: list[Figure] = []
    layout: Figure = {"font": FONT, "height": 300 * len(fields) + 60, "margin": {"l": 60, "r": 20, "t": 30, "b": 45},
                      "showlegend": False, "annotations": [], "plot_bgcolor": "#ffffff"}  # fmt: skip
    status = m.grid.status[columns][:, order].T
    for k, field in enumerate(fields):
        top = 1 - k / len(fields)
        up = [top - 1 / len(fields) + 0.035, top - 0.025]
        data += _traces(m, k, field, x=x, y=y, status=status, order=order, up=up)
        name = "" if k == 0 else str(k + 1)
        across: dict[str, Any] = {"title": {"text": "position along the path, m"}} if k == len(fields) - 1 else {}
        layout[f"xaxis{name}"] = {**AXIS, "anchor": f"y{name}", "matches": "x", **across}
        up_axis = {"anchor": f"x{name}", "domain": up, "title": {"text": "turn, deg"}, "dtick": 45}
        layout[f"yaxis{name}"] = {**AXIS, **up_axis}
        layout["annotations"].append(heading(field.title, 0.45, top))
    return {"data": data, "layout": layout}


def _traces(
    m: AxisMap, k: int, field: MapField, *, x: list[float], y: list[float], status: npt.NDArray[np.uint8],
    order: npt.NDArray[np.intp], up: list[float],
) -> list[Figure]:  # fmt: skip
    values = field.values[:, order].T
    low, high = _span(values[np.isfinite(values)])
    shown = [[None if not np.isfinite(v) else float(f"{v:.4g}") for v in row] for row in values.tolist()]
    forbidden = [[None if s == FREE else int(s) for s in row] for row in status.tolist()]
    scale = [[j / 4, FORBIDDEN.get(np.uint8(j), "#ffffff")] for j in range(len(STATUS))]
    along, turn = curve(m, drawn_columns(m))
    line: Figure = {"type": "scatter", "mode": "lines", "x": _known(along), "y": _known(turn), **on_panel(k)}
    told = hover("chosen: %{y:.1f} deg at %{x:.3f} m")
    return [
        {"type": "heatmap", "x": x, "y": y, "z": forbidden, "zmin": 0, "zmax": len(STATUS) - 1, "colorscale": scale,
         "showscale": False, "hoverinfo": "skip", **on_panel(k)},
        {"type": "heatmap", "x": x, "y": y, "z": shown, "zmin": low, "zmax": high, "colorscale": SCALES[field.scale],
         "colorbar": {"len": up[1] - up[0], "y": (up[0] + up[1]) / 2, "thickness": 14},
         "hovertemplate": hover("%{z} at %{x:.3f} m, %{y} deg"), **on_panel(k)},
        {**line, "line": {"color": "#000000", "width": 5}, "hoverinfo": "skip"},
        {**line, "line": {"color": "#ffffff", "width": 2.5}, "hovertemplate": told},
    ]  # fmt: skip


def _known(values: Floats) -> list[float | None]:
    return [None if np.isnan(v) else round(v, 6) for v in values.tolist()]


#: matplotlib's scales as plotly.js takes them.
SCALES = {
    "viridis": "Viridis",
    "magma_r": [[0.0, "#fcfdbf"], [0.25, "#fc8961"], [0.5, "#b73779"], [0.75, "#51127c"], [1.0, "#000004"]],
    "Blues": [[0.0, "#f7fbff"], [0.5, "#6baed6"], [1.0, "#08306b"]],
}
