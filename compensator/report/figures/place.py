"""The picture of a study of placements: a map over x and y, the best ten and the one that was chosen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from compensator.place.best import LISTED, ranking
from compensator.place.judge import BEYOND, COLLIDES, GOOD, OUT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection

Floats = npt.NDArray[np.float64]

COLOURS = {COLLIDES: "#c0392b", BEYOND: "#8e8e8e", OUT: "#dcdcdc"}
WORDS = {COLLIDES: "collides", BEYOND: "beyond joint limits, or singular", OUT: "out of reach"}
MOST_SHOWN = 95  # % of the scores that the colours spread over
ORDER = (GOOD, COLLIDES, BEYOND, OUT)  # what stands for a place over x and y: the best of its heights and turns


def draw(columns: dict[str, Any], chosen: Sequence[int], target: Path) -> None:
    """Write the PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas
    from matplotlib.patches import Patch
    from matplotlib.patheffects import withStroke

    canvas = Canvas(figsize=(8.6, 7.4), dpi=110, layout="constrained")
    FigureCanvasAgg(canvas)
    axes = canvas.subplots()
    x, y, status, score = best_over_height(columns)
    good, size = status == GOOD, (_apart(x), _apart(y))
    drawn = _cells(axes, x[good], y[good], size)
    if good.any():
        drawn.set(array=score[good] * 1e3, cmap="viridis_r")
        drawn.set_clim(score[good].min() * 1e3, np.percentile(score[good], MOST_SHOWN) * 1e3)
        canvas.colorbar(drawn, ax=axes, label="score, µm: smaller is better", extend="max")
    for name, colour in COLOURS.items():
        _cells(axes, x[status == name], y[status == name], size).set_facecolor(colour)
    for place, k in enumerate(ranking(columns)[:LISTED].tolist(), start=1):
        at = (columns["x_mm"][k], columns["y_mm"][k])
        text = axes.annotate(str(place), at, ha="center", va="center", fontsize=9, color="white", fontweight="bold")
        text.set_path_effects([withStroke(linewidth=2.0, foreground="black")])
    for k in chosen[:1]:
        axes.scatter(
            columns["x_mm"][k], columns["y_mm"][k], marker="o", s=220, facecolors="none", edgecolors="black",
            linewidths=1.8, label="followed along the whole path",
        )  # fmt: skip
    axes.plot(0.0, 0.0, "k^", markersize=9, label="base of the robot")
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x of the work object in the base, mm")
    axes.set_ylabel("y, mm")
    axes.set_title(f"{len(columns['status']):,} placements; the best ten are numbered", fontsize=10)
    patches = [Patch(color=colour, label=WORDS[name]) for name, colour in COLOURS.items() if (status == name).any()]
    handles = [*patches, *axes.get_legend_handles_labels()[0]]
    canvas.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    canvas.savefig(target, format="png", metadata={"Software": None})


def best_over_height(columns: dict[str, Any]) -> tuple[Floats, Floats, npt.NDArray[np.str_], Floats]:
    """x, y (M,) mm, status and score (mm) of the best placement at each place over x and y."""
    places = np.column_stack([columns["x_mm"], columns["y_mm"]])
    level = np.array([ORDER.index(s) for s in columns["status"]])
    score = np.nan_to_num(np.array(columns["score_mm"], dtype=float), nan=np.inf)
    order = np.lexsort((score, level))
    _, first = np.unique(places[order], axis=0, return_index=True)
    rows = order[first]
    return places[rows, 0], places[rows, 1], np.array(columns["status"])[rows], score[rows]


def _cells(axes: Axes, x: Floats, y: Floats, size: tuple[float, float]) -> PolyCollection:
    """A rectangle of some size about each place."""
    from matplotlib.collections import PolyCollection

    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * size
    cells = PolyCollection(list(np.column_stack([x, y])[:, None] + corner), linewidths=0)
    axes.add_collection(cells)
    return cells


def _apart(values: Floats) -> float:
    """Smallest step between places, mm; 50 where there is one only."""
    places = np.unique(values)
    return float(np.diff(places).min()) if len(places) > 1 else 50.0
