"""Draws docs/images/measuring-day.png: where tracker, reflectors and rope go. python -m docs.make_measuring_picture"""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.patches import Circle, FancyArrowPatch, Polygon, Rectangle

TARGET = Path(__file__).parent / "images" / "measuring-day.png"
ARM = ((0.0, 0.0), (0.0, 0.78), (0.25, 1.85), (1.45, 2.05), (1.75, 1.72), (1.85, 1.45))  # m, side view
STEEL, RED, BLUE = "#e08a2e", "#b3261e", "#1f5fa8"


def main() -> None:
    """Write the picture."""
    figure, axes = plt.subplots(figsize=(9.0, 4.6), dpi=110)
    axes.add_patch(Rectangle((-0.6, -0.08), 5.6, 0.08, color="#bbbbbb"))
    for (x0, z0), (x1, z1), width in zip(ARM, ARM[1:], (26, 20, 15, 11, 8), strict=False):
        axes.plot([x0, x1], [z0, z1], color=STEEL, linewidth=width, solid_capstyle="round", zorder=2)
    for x, z in ARM[1:-1]:
        axes.add_patch(Circle((x, z), 0.06, color="#444444", zorder=3))
    nests = {"link3": (0.95, 2.12), "aside": (2.02, 1.52), "tcp": (1.86, 1.36)}
    for name, (x, z) in nests.items():
        axes.add_patch(Circle((x, z), 0.045, color=BLUE, zorder=5))
        axes.plot([x, 4.15], [z, 1.02], color=BLUE, linewidth=0.8, linestyle=":", zorder=1)
        axes.annotate(name, (x, z), (x + 0.05, z + 0.08), color=BLUE, fontsize=10)
    axes.add_patch(Polygon([(3.95, 0.0), (4.35, 0.0), (4.2, 0.9), (4.1, 0.9)], color="#777777"))
    axes.add_patch(Circle((4.15, 1.02), 0.13, color="#333333"))
    pull = FancyArrowPatch((1.86, 1.36), (2.75, 0.1), arrowstyle="-|>", mutation_scale=18, color=RED, lw=2, zorder=4)
    axes.add_patch(pull)
    axes.annotate("force sensor at the flange,\nzeroed with the tool hanging", (1.8, 1.6), (1.9, 2.45), fontsize=10,
                  arrowprops={"arrowstyle": "-", "color": "#777777"})  # fmt: skip
    axes.text(3.75, 1.35, "tracker: on the floor,\nthree metres away,\nnot on the robot's table", fontsize=10)
    axes.text(2.45, 0.62, "rope, turnbuckle, load cell:\npull, then the reverse", color=RED, fontsize=10)
    axes.text(-1.45, 1.15, "every joint comes\nfrom the planned\nside", fontsize=10)
    axes.set_xlim(-1.5, 5.1)
    axes.set_ylim(-0.15, 2.75)
    axes.set_aspect("equal")
    axes.axis("off")
    figure.savefig(TARGET, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
