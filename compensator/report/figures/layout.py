"""What all figures share: their type, colours, headings, and panels beside and above each other.

plotly.js reads markup of its own in labels, which stands in this file only. No text that comes from a file goes into a
figure; the name of an effect goes through ``label``.
"""

from __future__ import annotations

from typing import Any

Figure = dict[str, Any]  # as plotly.js reads it; plain dicts, so that equal results give equal bytes

INK = "#1c2126"
FONT = {"family": "system-ui, sans-serif", "size": 13, "color": INK}
# colours after Okabe and Ito: colour-blind readers can distinguish them
ORANGE, BLUE = "#d55e00", "#0072b2"
BEFORE, AFTER = ORANGE, BLUE
GRID, ZERO_LINE = "#e3e6e9", "#b4bac0"
AXIS: Figure = {"gridcolor": GRID, "zerolinecolor": ZERO_LINE, "exponentformat": "power"}
LEGEND_ABOVE: Figure = {
    "orientation": "h", "x": 0, "xanchor": "left", "y": 1.0, "yanchor": "top", "yref": "container",
}  # fmt: skip


def base_layout(height: int, *, left: int = 60, top: int = 50, bottom: int = 45) -> Figure:
    """The layout of a figure of panels with one legend above them; ``height`` and margins in px."""
    return {
        "font": FONT, "height": height, "margin": {"l": left, "r": 20, "t": top, "b": bottom},
        "plot_bgcolor": "#ffffff", "showlegend": True, "annotations": [], "legend": dict(LEGEND_ABOVE),
    }  # fmt: skip


def number(k: int) -> str:
    """How plotly.js counts axes and scenes: the first without a number."""
    return "" if k == 0 else str(k + 1)


def axes(k: int, *, across: list[float], up: list[float], x: str, y: str) -> Figure:
    """The axes of panel ``k`` with their titles; ``across`` and ``up`` as shares of the figure."""
    name = number(k)
    return {
        f"xaxis{name}": {**AXIS, "domain": across, "anchor": f"y{name}", "title": {"text": x, "standoff": 6}},
        f"yaxis{name}": {**AXIS, "domain": up, "anchor": f"x{name}", "title": {"text": y, "standoff": 8}},
    }


def on_panel(k: int) -> Figure:
    """What puts a trace into panel ``k``."""
    return {"xaxis": f"x{number(k)}", "yaxis": f"y{number(k)}"}


def heading(text: str, x: float, y: float = 1.0, *, above: bool = False) -> Figure:
    """A title over a panel or a scene, hanging from ``y`` or standing on it, both as shares of the figure."""
    place = {"x": x, "y": y, "xref": "paper", "yref": "paper", "yanchor": "bottom" if above else "top"}
    return {"text": f"<b>{text}</b>", "showarrow": False, "xanchor": "center", **place}


def hover(*lines: str) -> str:
    """What plotly.js shows of the point under the cursor, with no second box for the name of the curve."""
    return "<br>".join(lines) + "<extra></extra>"


def label(text: str) -> str:
    """Text in which plotly.js finds no markup."""
    return text.replace("&", "&amp;").replace("<", "&lt;")
