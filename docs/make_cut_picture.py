"""Draws docs/images/cut-axes.png: axes, angles and signs of a cut, and the slot that docs/cutting.md works by hand.

    python -m docs.make_cut_picture        needs the extra `docs` (matplotlib)

The forces in it are those that the page works by hand; a test compares them with the product's.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Polygon, Rectangle, Wedge

PICTURE = Path(__file__).parent / "images" / "cut-axes.png"
AP, FEED, TEETH = 3.0, 0.1, 4  # mm
KTC, KRC, KAC, KTE, KRE, KAE = 796.0, 168.0, 222.0, 27.7, 30.8, 1.4  # N/mm2, N/mm
UP, CLIMB, TOOL, FORCE, AXIS = "#f3d9b1", "#cfe3cf", "#5b6770", "#b03a2e", "#1b4f72"


def slot_force() -> tuple[float, float, float]:
    """N, mean force on the tool in a slot, path axes."""
    share = TEETH * AP / (2 * np.pi)
    half = FEED * np.pi / 2
    return -share * (KRC * half + 2 * KRE), -share * (KTC * half + 2 * KTE), share * (2 * KAC * FEED + np.pi * KAE)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str, width: float = 1.8) -> None:
    """From start to end."""
    look = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 14}
    axes.annotate("", xy=end, xytext=start, arrowprops=look)


def plain(axes: Axes, title: str, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Equal axes without ticks."""
    axes.set_aspect("equal")
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.axis("off")
    axes.set_title(title, fontsize=11)


def place(theta: float, radius: float = 1.0) -> tuple[float, float]:
    """On the page, x up and y to the right: theta counts clockwise from x."""
    a = np.radians(theta)
    return float(radius * np.sin(a)), float(radius * np.cos(a))


def from_the_spindle(axes: Axes) -> None:
    """Seen into the work: z goes away."""
    plain(axes, "seen from the spindle into the work", (-2.1, 2.3), (-1.75, 2.35))
    axes.add_patch(Rectangle((-1.9, 0), 1.9, 1.85, color=UP, lw=0))
    axes.add_patch(Rectangle((0, 0), 1.9, 1.85, color=CLIMB, lw=0))
    axes.add_patch(Circle((0, 0), 1.0, facecolor="white", edgecolor=TOOL, lw=2))
    axes.text(-1.85, 1.62, "up milling\nmaterial at y < 0", fontsize=9, va="center")
    axes.text(1.85, 1.62, "climb milling\nmaterial at y > 0", fontsize=9, va="center", ha="right")
    arrow(axes, (0, 0), (0, 2.15), AXIS)
    arrow(axes, (0, 0), (2.1, 0), AXIS)
    axes.text(0.08, 2.15, "x: feed", color=AXIS, fontsize=10, va="center")
    axes.text(2.1, 0.1, "y", color=AXIS, fontsize=10)
    axes.plot(0, 0, marker="x", color=AXIS, ms=9, mew=2)
    axes.add_patch(Circle((0, 0), 0.1, fill=False, edgecolor=AXIS, lw=1.5))
    axes.text(0, -0.16, "z, into the work", color=AXIS, fontsize=9, ha="center", va="top")
    theta = 50.0
    at = place(theta)
    axes.plot([0, at[0]], [0, at[1]], color=TOOL, lw=1, ls="--")
    axes.add_patch(Arc((0, 0), 1.1, 1.1, theta1=90 - theta, theta2=90, color=TOOL, lw=1.2))
    axes.text(*place(theta / 2, 0.68), "θ", fontsize=11, ha="center", va="center")
    axes.plot(*at, "o", color=TOOL, ms=6)
    out, along = place(theta, 1.5), place(theta + 90, 0.5)
    arrow(axes, at, out, TOOL)
    arrow(axes, at, (at[0] + along[0], at[1] + along[1]), TOOL)
    axes.text(out[0] + 0.05, out[1], "r", fontsize=10)
    axes.text(at[0] + along[0] + 0.06, at[1] + along[1], "t: motion of the edge", fontsize=9, va="center")
    ends = ((-90.0, "θ = -90°:\nup milling enters", "right"), (90.0, "θ = 90°:\nclimb milling leaves", "left"))
    for angle, word, side in ends:
        spot = place(angle)
        axes.plot(*spot, "o", color="black", ms=4)
        axes.text(spot[0] * 1.06, -0.1, word, fontsize=8.5, va="top", ha=side)
    axes.add_patch(Arc((0, 0), 2.5, 2.5, theta1=232, theta2=308, color=TOOL, lw=1.6))
    end = np.radians(232)
    tip = (1.25 * np.cos(end), 1.25 * np.sin(end))
    arrow(axes, (tip[0] + 0.02, tip[1] - 0.015), (tip[0] - 0.03, tip[1] + 0.024), TOOL)
    axes.text(0, -1.4, "M3 turns clockwise here; M4 mirrors all in y", fontsize=9, ha="center", va="top")


def from_the_side(axes: Axes) -> None:
    """A bull nose: the outline, kappa, n and a; where the wrench stands."""
    plain(axes, "seen from the side (from y > 0), a bull nose", (-1.75, 2.5), (-1.2, 2.75))
    axes.add_patch(Rectangle((-1.6, -0.75), 4.0, 1.55, color="#e8e8e8", lw=0))
    kappa = np.linspace(0, np.pi / 2, 30)
    corner = np.column_stack([0.45 + 0.55 * np.sin(kappa), 0.55 - 0.55 * np.cos(kappa)])
    half = np.concatenate([[[0, 0]], corner, [[1.0, 2.3], [0, 2.3]]])
    axes.add_patch(Polygon(np.concatenate([half, half[::-1] * [-1, 1]]), facecolor="white", edgecolor=TOOL, lw=2))
    swept = np.concatenate([half[:-1], [[0, 2.3]]])
    axes.plot(swept[:-1, 0], swept[:-1, 1], color=TOOL, lw=2)
    axes.plot([-1.6, -1.0], [0.8, 0.8], color="0.6", lw=1)
    axes.plot([1.0, 2.4], [0.8, 0.8], color="0.6", lw=1)
    axes.add_patch(Rectangle((-1.6, 0.0), 0.6, 0.8, color="white", lw=0))
    axes.plot([-1.6, -0.45], [0, 0], color="0.6", lw=1)
    axes.plot([0, 0], [0, 2.55], color=TOOL, lw=0.8, ls="-.")
    axes.plot(0, 0, "o", color=FORCE, ms=7)
    words = "TCP = tip: force and moment\nof a pose stand here"
    axes.text(-0.1, -0.14, words, fontsize=9, ha="right", va="top", color=FORCE)
    arrow(axes, (0, 0), (0, -1.05), AXIS)
    axes.text(0.07, -1.0, "z", color=AXIS, fontsize=10)
    arrow(axes, (0, 0), (1.75, 0), AXIS)
    axes.text(1.8, -0.02, "x: feed", color=AXIS, fontsize=10, va="center")
    k = np.radians(50)
    at = (0.45 + 0.55 * np.sin(k), 0.55 - 0.55 * np.cos(k))
    n, a = (np.sin(k), -np.cos(k)), (-np.cos(k), -np.sin(k))
    arrow(axes, at, (at[0] + 0.6 * n[0], at[1] + 0.6 * n[1]), TOOL)
    arrow(axes, at, (at[0] + 0.6 * a[0], at[1] + 0.6 * a[1]), TOOL)
    axes.text(at[0] + 0.66 * n[0], at[1] + 0.66 * n[1], "n", fontsize=10)
    axes.text(at[0] + 0.72 * a[0] - 0.02, at[1] + 0.7 * a[1], "a", fontsize=10, ha="right")
    axes.plot([0.45, 0.45], [0.55, 0.05], color=TOOL, lw=0.8, ls="--")
    axes.plot([0.45, at[0]], [0.55, at[1]], color=TOOL, lw=0.8, ls="--")
    axes.add_patch(Wedge((0.45, 0.55), 0.25, 270, 320, color="#c9d2d8", lw=0))
    axes.text(0.58, 0.2, "κ", fontsize=10)
    arrow(axes, (-1.3, 0.0), (-1.3, 0.8), "black", 1.2)
    arrow(axes, (-1.3, 0.8), (-1.3, 0.0), "black", 1.2)
    axes.text(-1.36, 0.4, "ap", fontsize=10, va="center", ha="right")
    axes.text(0.06, 2.45, "to the spindle", fontsize=9, va="center")


def slot(axes: Axes) -> None:
    """Forces on the tool, to scale."""
    fx, fy, fz = slot_force()
    plain(axes, "a slot: mean force ON THE TOOL", (-2.6, 2.2), (-1.75, 2.35))
    axes.add_patch(Rectangle((-1.9, -1.6), 3.8, 3.45, color="#e8e8e8", lw=0))
    axes.add_patch(Rectangle((-1, -1.6), 2, 1.6, color="white", lw=0))
    axes.add_patch(Circle((0, 0), 1.0, facecolor="white", edgecolor=TOOL, lw=2))
    axes.add_patch(Wedge((0, 0), 1.0, 0, 180, width=0.12, color=UP, lw=0))
    arrow(axes, (0, 1.15), (0, 2.15), AXIS)
    axes.text(0.08, 2.1, "feed, 0.1 mm per tooth", color=AXIS, fontsize=9)
    scale = 1.5 / abs(fy)
    whole = (fy * scale, fx * scale)
    arrow(axes, (0, 0), whole, FORCE, 2.6)
    arrow(axes, (0, 0), (whole[0], 0), FORCE, 1.2)
    arrow(axes, (0, 0), (0, whole[1]), FORCE, 1.2)
    axes.text(whole[0] - 0.05, 0.1, f"Fy = {fy:.2f} N", color=FORCE, fontsize=9, ha="right", va="bottom")
    axes.text(0.06, whole[1] / 2, f"Fx = {fx:.2f} N", color=FORCE, fontsize=9, va="center")
    axes.plot(-0.62, 0.42, marker="x", color=FORCE, ms=8, mew=2)
    axes.add_patch(Circle((-0.62, 0.42), 0.1, fill=False, edgecolor=FORCE, lw=1.5))
    axes.text(-0.46, 0.42, f"Fz = {fz:.2f} N,\ninto the work", color=FORCE, fontsize=9, va="center")
    given = f"D 20 mm, {TEETH} flutes, ap {AP:g} mm, 796/168/222 N/mm², 27.7/30.8/1.4 N/mm"
    axes.text(0, -1.66, given, fontsize=7.5, ha="center", va="top")


def main() -> None:
    """Draw it."""
    figure, (first, second, third) = plt.subplots(1, 3, figsize=(14.0, 4.9), dpi=100)
    from_the_spindle(first)
    from_the_side(second)
    slot(third)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.93, wspace=0.03)
    figure.savefig(PICTURE, facecolor="white")


if __name__ == "__main__":
    main()
