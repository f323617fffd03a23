"""Draws docs/images/milled-circle.png and prints the numbers of docs/milled-circle.md.

python docs/make_circle_picture.py        from the top of the checkout, with the extras [test,docs]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from tests.compensator.milled_circle import RADIUS, Circle, experiment  # noqa: E402

MAGNIFIED = 100
LOOK = {  # colour, width, what it is called
    "uncompensated": ("#c0392b", 1.6, "uncompensated program"),
    "stiffness only": ("#e08e0b", 1.6, "compensated for stiffness only"),
    "stiffness and play": ("#1f6f43", 2.2, "compensated for stiffness and joint play"),
}
SIDES = {1.0: "Link rests on the side it turned to (side +1)", -1.0: "Link lags behind (side -1)"}


def merged_reversals(circle: Circle, apart: float) -> list[tuple[float, str]]:
    """(angle deg, joints) where joints turn around; those less than `apart` deg apart share a label."""
    groups: list[tuple[float, list[int]]] = []
    for joint, angle in sorted(circle.reversals, key=lambda r: r[1]):
        degrees = float(np.degrees(angle))
        if groups and degrees - groups[-1][0] < apart:
            groups[-1][1].append(joint)
        else:
            groups.append((degrees, [joint]))
    return [(a, ", ".join(str(j) for j in sorted(set(joints)))) for a, joints in groups]


def polar(axes: plt.Axes, circles: dict[str, Circle]) -> None:
    """The circle from above, its error magnified."""
    turn = np.linspace(0, 2 * np.pi, 400)
    axes.plot(RADIUS * np.cos(turn), RADIUS * np.sin(turn), color="0.55", lw=0.8, ls="--", zorder=1)
    for name, circle in circles.items():
        r = RADIUS + MAGNIFIED * circle.radial * 1e3
        colour, width, _ = LOOK[name]
        axes.plot(r * np.cos(circle.angle), r * np.sin(circle.angle), color=colour, lw=width, zorder=2)
    for degrees, joints in merged_reversals(circles["uncompensated"], 14.0):
        ray = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        axes.plot(*np.outer(ray, [0.62 * RADIUS, 1.62 * RADIUS]), color="0.75", lw=0.8, zorder=0)
        axes.text(*(1.78 * RADIUS * ray), "joint " + joints, ha="center", va="center", fontsize=9)
    axes.plot([-MAGNIFIED * 0.1, MAGNIFIED * 0.1], [-RADIUS * 0.12] * 2, color="k", lw=2)
    axes.text(0, 0, "0.2 mm of error", ha="center", fontsize=9)
    axes.set_xlim(-2.1 * RADIUS, 2.1 * RADIUS)
    axes.set_aspect("equal")
    axes.axis("off")


def unrolled(axes: plt.Axes, circles: dict[str, Circle], *, labels: bool) -> None:
    """Radial error over the angle, with the reversals."""
    for name, circle in circles.items():
        colour, width, label = LOOK[name]
        axes.plot(np.degrees(circle.angle), circle.radial * 1e6, color=colour, lw=width, label=label)
    top = axes.get_ylim()[1]
    for degrees, joints in merged_reversals(circles["uncompensated"], 5.0):
        axes.axvline(degrees, color="0.75", lw=0.8, zorder=0)
        if labels:
            axes.text(degrees, top, joints, ha="center", va="bottom", fontsize=8)
    axes.axhline(0, color="0.55", lw=0.8, ls="--", zorder=1)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.set_ylabel("radial error (µm)")
    axes.grid(axis="y", color="0.92")


def picture(results: dict[float, dict[str, Circle]], target: Path) -> None:
    """One row per way in which the link sits in its gap."""
    figure = plt.figure(figsize=(13.5, 9.6), dpi=100)
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.35], wspace=0.06, hspace=0.34)
    figure.subplots_adjust(top=0.855, bottom=0.06, left=0.01, right=0.985)
    for row, (side, circles) in enumerate(results.items()):
        polar(figure.add_subplot(grid[row, 0]), circles)
        axes = figure.add_subplot(grid[row, 1])
        unrolled(axes, circles, labels=True)
        axes.set_title(SIDES[side] + "; on top: which joint reverses", fontsize=11, loc="left", pad=18)
        axes.set_xlabel("angle around the circle (deg)")
    handles, labels = figure.axes[1].get_legend_handles_labels()
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.953)}
    figure.legend(handles, labels, ncol=3, frameon=False, fontsize=11, **place)
    figure.suptitle(
        f"Milled circle, {2 * RADIUS:g} mm, on a robot with 0.5 to 1 arcmin of joint play "
        f"(circles: error drawn {MAGNIFIED}x)",
        fontsize=14,
        y=0.985,
    )
    target.parent.mkdir(exist_ok=True)
    figure.savefig(target)


def numbers(results: dict[float, dict[str, Circle]]) -> str:
    """A table in Markdown, µm."""
    lines = ["| side | program | roundness | radial error, 99 % | radial error, worst |", "| --- " * 5 + "|"]
    for side, circles in results.items():
        for name, circle in circles.items():
            e = circle.radial * 1e6
            share = np.percentile(np.abs(e), 99)
            lines.append(
                f"| {side:+g} | {LOOK[name][2]} | {np.ptp(e):.0f} | {share:.1f} | {np.abs(e).max():.0f} |"
            )
    return "\n".join(lines)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        results = {side: experiment(Path(folder), side, per_move=8) for side in SIDES}
    picture(results, HERE / "images" / "milled-circle.png")
    print(numbers(results))


if __name__ == "__main__":
    main()
