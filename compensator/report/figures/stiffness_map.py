"""A stiffness map as a picture: contour maps over the two joints."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stiffness.statics.joint_grid import JointGrid
from stiffness.statics.stiffness_map import LIMIT, NO_EQUILIBRIUM, SINGULAR, StiffnessMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap

Floats = npt.NDArray[np.float64]

_BLANK = "0.82"
_TICKS = 13  # direction ticks along an axis


@dataclass(frozen=True)
class Panel:
    """One field of the picture: ``values`` (A, B) in the unit of ``title``; ``scale`` is a name of a colour scale."""

    title: str
    values: Floats
    scale: str


def panels(grid: JointGrid, result: StiffnessMap) -> tuple[Panel, ...]:
    """The fields of the picture."""
    low, high, _ = result.softest
    fields = (
        ("smallest stiffness, N/µm (ticks: elevation of that direction)", low * 1e-6, "viridis"),
        ("largest stiffness, N/µm", high * 1e-6, "viridis"),
        ("deflection under the wrench, mm", result.deflection * 1e3, "magma_r"),
        ("moved by K_c, µm", result.shift * 1e6, "magma_r"),
        ("nu_p (Eq. 27): share of K_c, %", result.nu_p * 100, "magma_r"),
        ("nu_r (Eq. 28): turned by K_c, µrad", result.nu_r * 1e6, "magma_r"),
    )
    return tuple(Panel(title, grid.over(values), scale) for title, values, scale in fields)


def draw(grid: JointGrid, result: StiffnessMap, title: str, target: Path) -> None:
    """Contour maps over the two joints as PNG; grey where nothing can be said."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(14.0, 8.2), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=11)
    axes = figure.subplots(2, 3, sharex=True, sharey=True)
    for k, panel in enumerate(panels(grid, result)):
        _field(axes.flat[k], grid, panel)
        if k % 3 == 0:
            axes.flat[k].set_ylabel(f"joint {grid.joints[1] + 1}, deg")
        if k >= 3:
            axes.flat[k].set_xlabel(f"joint {grid.joints[0] + 1}, deg")
    _directions(axes.flat[0], grid, result)
    figure.text(0.004, 0.004, _blanks(result), fontsize=9, color="0.35")
    figure.savefig(target, format="png", metadata={"Software": None})


def _blanks(result: StiffnessMap) -> str:
    words = ((SINGULAR, "singular"), (LIMIT, "beyond a joint limit"), (NO_EQUILIBRIUM, "no equilibrium"))
    found = [f"{int(np.sum(result.status == s))} {word}" for s, word in words if np.any(result.status == s)]
    return "grey: " + ", ".join(found) if found else ""


def _field(axes: Axes, grid: JointGrid, panel: Panel) -> None:
    import matplotlib
    from matplotlib.patheffects import withStroke

    colours: Colormap = matplotlib.colormaps[panel.scale]
    axes.set_facecolor(_BLANK)
    values = np.ma.masked_invalid(panel.values.T)
    axes.set_title(f"{panel.title}\n{values.min():.3g} ... {values.max():.3g}", fontsize=10)
    levels = _levels(values.compressed())
    drawn = axes.contourf(grid.first, grid.second, values, levels, cmap=colours, extend="both")
    inside = [v for v in levels[1::3] if values.min() < v < values.max()]
    if inside:
        lines = axes.contour(grid.first, grid.second, values, inside, colors="black", linewidths=0.5)
        for label in axes.clabel(lines, fontsize=7, fmt="%.3g"):
            label.set_path_effects([withStroke(linewidth=2, foreground="white")])
    bar = axes.figure.colorbar(drawn, ax=axes, shrink=0.9)
    bar.ax.tick_params(labelsize=8)
    k = np.unravel_index(int(np.argmax(values.filled(-np.inf))), values.shape)
    axes.plot(grid.first[k[1]], grid.second[k[0]], "k^", markersize=5, markerfacecolor="white", clip_on=False)


def _levels(values: Floats) -> Floats:
    """15 to 20 round levels; a singular rim is not allowed to take all the colours."""
    from matplotlib.ticker import MaxNLocator

    low, high = (float(v) for v in np.percentile(values, (0.5, 99.5)))
    if high - low <= 1e-9 * max(abs(high), 1e-30):
        low, high = low - 0.01 * abs(low) - 1e-12, high + 0.01 * abs(high) + 1e-12
    return np.asarray(MaxNLocator(18).tick_values(low, high))


def _directions(axes: Axes, grid: JointGrid, result: StiffnessMap) -> None:
    """A tick per posture: its slope is the elevation of the softest direction above the horizontal."""
    _, _, direction = result.softest
    rise = grid.over(direction[:, 2])
    flat = grid.over(np.hypot(direction[:, 0], direction[:, 1]))
    a, b = (_spread(len(axis)) for axis in (grid.first, grid.second))
    x, y = np.meshgrid(grid.first[a], grid.second[b], indexing="ij")
    seen = np.isfinite(rise[np.ix_(a, b)])
    axes.quiver(
        x[seen], y[seen], flat[np.ix_(a, b)][seen], rise[np.ix_(a, b)][seen], angles="uv", pivot="mid", scale=32,
        headwidth=0, headlength=0, headaxislength=0, width=0.004, color="white",
    )  # fmt: skip


def _spread(count: int) -> npt.NDArray[np.intp]:
    return np.unique(np.linspace(0, count - 1, min(count, _TICKS)).round().astype(np.intp))
