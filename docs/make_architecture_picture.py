"""Draws docs/images/architecture.png: the folders, who imports whom, and the way of one pose and of one reading."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

TARGET = Path(__file__).parent / "images" / "architecture.png"
POSE, READING, ARROW, EDGE = "#1f5fa8", "#b3541e", "#555555", "#9a9a9a"

# package: left, bottom, width, height, colour
PACKAGES = {
    "compensator": (1.0, 6.15, 14.0, 3.35, "#eef3f8"),
    "toolpaths": (1.0, 0.4, 5.3, 5.0, "#f1f5ec"),
    "stiffness": (7.0, 0.4, 8.0, 5.0, "#faf3ea"),
}
LINES = {
    "compensator": "the only package that knows both",
    "toolpaths": "knows no robot model",
    "stiffness": "robots and loads; knows no toolpath",
}
# folder: left, bottom, width, what it holds
FOLDERS = {
    "compensator/cli.py": (1.3, 8.0, 2.0, "one verb per command"),
    "compensator/tasks": (3.6, 8.0, 2.6, "one file per verb,\nfiles in, files out"),
    "compensator/cell": (6.5, 8.0, 2.2, "cell file,\narm, placement"),
    "compensator/report": (9.0, 8.0, 3.1, "json, html, figures"),
    "compensator/terminal": (12.4, 8.0, 2.3, "tables, progress"),
    "compensator/path": (1.9, 6.5, 2.9, "inverse kinematics\nalong the path"),
    "compensator/process": (5.1, 6.5, 2.9, "wrench per pose:\nconstant, table"),
    "compensator/solve": (8.3, 6.5, 3.3, "commands, joint state,\nposes at flank changes"),
    "compensator/program": (11.9, 6.5, 2.8, "robot programs in\nand out, filter"),
    "toolpaths/reading": (1.3, 3.55, 2.3, "what readers share"),
    "toolpaths/writing": (3.8, 3.55, 2.3, "what writers share"),
    "toolpaths/languages": (1.3, 2.1, 4.8, "a folder each: reader, scan,\ninterpreter, writer, read back, filter"),
    "toolpaths/interpreting": (1.3, 0.65, 2.3, "expressions,\nmoves, arcs"),
    "toolpaths/rewriting": (3.8, 0.65, 2.3, "filter in place"),
    "stiffness/session": (7.3, 3.55, 1.65, "what a lab\nmeasured"),
    "stiffness/identification": (9.25, 3.55, 2.15, "readings predicted,\nleast squares"),
    "stiffness/diagnosis": (11.7, 3.55, 1.65, "what the\nmodel lacks"),
    "stiffness/planning": (13.65, 3.55, 1.15, "what to\nmeasure"),
    "stiffness/effects": (7.3, 2.1, 2.2, "one file per cause,\nCATALOGUE"),
    "stiffness/statics": (9.75, 2.1, 2.55, "THE equation\n(statics.py)"),
    "stiffness/memory": (12.75, 2.1, 2.0, "play of gaps,\npreload"),
    "stiffness/robot": (7.3, 0.65, 2.2, "TOML, URDF,\nbuilt-in arms"),
    "stiffness/kinematics": (9.75, 0.65, 2.55, "inverse kinematics,\nJacobian"),
    "stiffness/model": (12.5, 0.65, 2.25, "model file"),
}
HIGH = 1.05
WAY_OF_A_POSE = (
    "toolpaths/languages", "compensator/path", "compensator/process", "compensator/solve",
    "stiffness/statics", "stiffness/memory", "compensator/program", "toolpaths/writing",
)  # fmt: skip
WAY_OF_A_READING = (
    "stiffness/session", "stiffness/identification", "stiffness/statics", "stiffness/diagnosis", "stiffness/model",
)  # fmt: skip


def box(ax: Axes, place: tuple[float, float, float, float], face: str, edge: str, width: float) -> None:
    x, y, w, h = place
    style = "round,pad=0,rounding_size=0.09"
    ax.add_patch(FancyBboxPatch((x, y), w, h, boxstyle=style, facecolor=face, edgecolor=edge, linewidth=width))


def numbered(ax: Axes, way: tuple[str, ...], colour: str, side: float) -> None:
    """A number in the corner of every folder that is passed, in order."""
    for k, name in enumerate(way, 1):
        x, y, w, _ = FOLDERS[name]
        at = x + (0.0 if side < 0 else w), y + HIGH
        ax.plot(*at, "o", markersize=15, color=colour, zorder=5)
        ax.text(*at, str(k), color="white", ha="center", va="center", fontsize=9, weight="bold", zorder=6)


def arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    style = {"arrowstyle": "-|>", "mutation_scale": 22, "linewidth": 2.5, "color": ARROW}
    ax.add_patch(FancyArrowPatch(start, end, **style))


def draw() -> None:
    plt.rcParams["font.family"] = "DejaVu Sans"
    figure, ax = plt.subplots(figsize=(15, 9.6), dpi=110)
    for name, (x, y, w, h, colour) in PACKAGES.items():
        box(ax, (x, y, w, h), colour, EDGE, 1.5)
        ax.text(x + 0.25, y + h - 0.28, name, fontsize=15, weight="bold", va="center")
        ax.text(x + w - 0.25, y + h - 0.28, LINES[name], fontsize=10.5, va="center", ha="right", style="italic")
    for name, (x, y, w, what) in FOLDERS.items():
        box(ax, (x, y, w, HIGH - 0.22 if y == 8.0 else HIGH), "white", EDGE, 1.0)
        ax.text(x + w / 2, y + HIGH - 0.24 - (0.17 if y == 8.0 else 0), name.split("/")[1], ha="center", va="center",
                fontsize=10.5, weight="bold")  # fmt: skip
        low = y + (0.27 if y == 8.0 else 0.38)
        ax.text(x + w / 2, low, what, ha="center", va="center", fontsize=8.6, linespacing=1.25)
    arrow(ax, (3.6, 6.15), (3.6, 5.4))
    arrow(ax, (11.0, 6.15), (11.0, 5.4))
    ax.text(3.8, 5.78, "imports", fontsize=10, color=ARROW, va="center")
    ax.text(11.2, 5.78, "imports", fontsize=10, color=ARROW, va="center")
    numbered(ax, WAY_OF_A_POSE, POSE, -1)
    numbered(ax, WAY_OF_A_READING, READING, 1)
    for x, colour, words in ((1.2, POSE, "the way of one pose"), (5.2, READING, "the way of one reading")):
        ax.plot(x, 0.12, "o", markersize=12, color=colour)
        ax.text(x + 0.25, 0.12, words, fontsize=11, va="center")
    rule = "between folders arrows run one way: a test reads them"
    ax.text(14.9, 0.12, rule, fontsize=10, va="center", ha="right", color=ARROW)
    ax.set(xlim=(0.7, 15.3), ylim=(-0.1, 9.7))
    ax.axis("off")
    figure.savefig(TARGET, bbox_inches="tight", metadata={"Software": None})


if __name__ == "__main__":
    draw()
