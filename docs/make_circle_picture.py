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
SIDES = {1.0: "link rests on the side it turned to (+1, the paper)", -1.0: "link lags behind (-1, textbook)"}


def merged_reversals(circle: Circle) -> list[tuple[float, str]]:
    """(angle deg, joints) where joints turn around; joints that turn together share a label."""
    groups: list[tuple[float, list[int]]] = []
    for joint, angle in sorted(circle.reversals, key=lambda r: r[1]):
        degrees = float(np.degrees(angle))
        if groups and degrees - groups[-1][0] < 4.0:
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
    for degrees, joints in merged_reversals(circles["uncompensated"]):
        a = np.radians(degrees)
        inner, outer = 0.52 * RADIUS, 0.62 * RADIUS
        axes.plot(
            [inner * np.cos(a), outer * np.cos(a)], [inner * np.sin(a), outer * np.sin(a)], color="0.3", lw=1
        )
        axes.text(
            0.43 * RADIUS * np.cos(a), 0.43 * RADIUS * np.sin(a), joints, ha="center", va="center", fontsize=9
        )
    axes.text(0, 0, "joints that\nreverse here", ha="center", va="center", fontsize=8, color="0.3")
    axes.plot([-RADIUS * 1.5, -RADIUS * 1.5 + MAGNIFIED * 0.2], [-RADIUS * 1.55] * 2, color="k", lw=2)
    axes.text(-RADIUS * 1.5, -RADIUS * 1.5, "0.2 mm of error", fontsize=8)
    axes.set_aspect("equal")
    axes.axis("off")


def unrolled(axes: plt.Axes, circles: dict[str, Circle], *, labels: bool) -> None:
    """Radial error over the angle, with the reversals."""
    for name, circle in circles.items():
        colour, width, label = LOOK[name]
        axes.plot(np.degrees(circle.angle), circle.radial * 1e6, color=colour, lw=width, label=label)
    top = axes.get_ylim()[1]
    for degrees, joints in merged_reversals(circles["uncompensated"]):
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
    figure = plt.figure(figsize=(13, 9.4), dpi=110)
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.75], wspace=0.08, hspace=0.3, top=0.86, bottom=0.07)
    for row, (side, circles) in enumerate(results.items()):
        polar(figure.add_subplot(grid[row, 0]), circles)
        axes = figure.add_subplot(grid[row, 1])
        unrolled(axes, circles, labels=True)
        axes.set_title(SIDES[side] + "\nnumbers: joints that reverse", fontsize=10, loc="left", pad=16)
        axes.set_xlabel("angle around the circle (deg)")
    handles, labels = figure.axes[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.94), ncol=3, frameon=False)
    figure.suptitle(
        f"Milled circle, {2 * RADIUS:g} mm, on a robot with 0.5 to 1 arcmin of joint play "
        f"(left: error magnified {MAGNIFIED}x)",
        fontsize=13,
        y=0.975,
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
