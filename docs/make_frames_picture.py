"""Draws docs/images/frames-and-signs.png: the frames of a cell, and the signs of wrench, deflection and correction.

    python -m docs.make_frames_picture        needs the extra `docs` (matplotlib)

A small cell is compensated for it: postures, deflection and correction are what the program computes; a test holds
the signs that the picture shows.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from compensator.report.scene.scene import with_tcp
from compensator.solve.nominal_state import nominal_state
from compensator.tasks.compensate import compensate_file
from toolpaths.frame import Frame

Floats = npt.NDArray[np.float64]
PICTURE = Path(__file__).parent / "images" / "frames-and-signs.png"
LIGHT, DARK, AXIS, WORK = "#ecd0ae", "#444444", "#1b4f72", "#c9d2d8"
FORCE, DEFLECTION, CORRECTION = "#d55e00", "#cc2f6b", "#0072b2"  # as the report draws them
WRENCH = (350.0, 0.0, 450.0, 0.0, 0.0, 0.0)  # N, on the robot, base axes
CELL = """
schema = "cell/1"
robot = "abb-irb6600-175-255"
tip = "tool0"
model = "model.toml"
gravity = "calibrated-out"
[tool]
xyz = [0.0, 0.0, 350.0]
mass = 35.0
com = [0.0, 0.0, 120.0]
[workobject]
xyz = [1050.0, 0.0, 700.0]
[start]
joints = [0.0, 0.0, 20.0, 0.0, 60.0, 180.0]
[process]
kind = "constant"
frame = "base"
"""
MODEL = """
schema = "model/1"
robot = "abb-irb6600-175-255"
[effects.joint-stiffness]
k_nm_per_rad = [2.0e6, 1.8e6, 1.4e6, 2.8e5, 9.6e4, 3.7e4]
"""


@dataclass(frozen=True, repr=False)
class Shown:
    """One cutting pose in base axes, m and N.

    Attributes:
        links: base, links 1 to n, TCP. work: the work object.
        force, deflection, correction: (3,), the tool axis (3,) from the tip to the spindle.
    """

    links: Frame
    work: Frame
    force: Floats
    deflection: Floats
    correction: Floats
    axis: Floats


def shown() -> Shown:
    """A cut in the plane of the arm, compensated."""
    rows = ["x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind", "450,0,60,0,0,1,0,rapid", "450,0,0,0,0,1,600,cut"]
    rows += [f"{x},0,0,0,0,1,600,cut" for x in range(460, 660, 10)]
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "path.csv").write_text("\n".join(rows) + "\n")
        (folder / "model.toml").write_text(MODEL)
        (folder / "cell.toml").write_text(f"{CELL}wrench = {list(WRENCH)}\n")
        c = compensate_file(folder / "path.csv", folder / "cell.toml", folder / "out.csv").result
    pose = np.array([len(c) // 2])
    part = c.path.toolpath.take(pose)
    arm = c.job.arm.links(part, c.path.q[pose], c.wrench[pose], nominal_state(c).middle[pose])
    links = with_tcp(c.job.arm.tools, part, *arm)[0].take(0)
    work = c.job.placement.workobject
    axis = work.rotation @ part.axis[0]
    return Shown(links, work, c.wrench[pose[0], :3], c.error_before[pose[0]], c.correction[pose[0]], axis)


def arrow(axes: Axes, start: Floats, end: Floats, colour: str, width: float = 1.8) -> None:
    """From start to end, (2,)."""
    look = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    axes.annotate("", xy=end, xytext=start, arrowprops=look, zorder=6)


def side(v: Floats) -> Floats:
    """Base coordinates as the page has them, seen against y: x to the right, z up."""
    return np.asarray(v[..., [0, 2]])


def triad(axes: Axes, frame: Frame, length: float, words: str, at: tuple[float, float]) -> None:
    """x, y and z of a frame; an axis that goes into the page or comes out of it as a ring with cross or point."""
    origin = side(frame.origin)
    for k, name in enumerate("xyz"):
        direction = frame.rotation[:, k]
        flat = side(direction)
        if np.linalg.norm(flat) < 0.5:  # we look along +y
            axes.add_patch(Circle(origin, 0.16 * length, facecolor="white", edgecolor=AXIS, lw=1.4, zorder=7))
            mark = "x" if direction[1] > 0 else "o"
            axes.plot(*origin, mark, color=AXIS, ms=5 if mark == "x" else 3, mew=1.4, zorder=8)
            beside = origin + length * np.array([-0.2, -0.42])
            axes.text(*beside, name, color=AXIS, fontsize=9, ha="right", zorder=8)
        else:
            arrow(axes, origin, origin + length * flat, AXIS)
            end = origin + 1.16 * length * flat
            axes.text(*end, name, color=AXIS, fontsize=9, ha="center", va="center", zorder=8)
    axes.text(*at, words, fontsize=9.5, va="center")


def frames(axes: Axes, s: Shown) -> None:
    """The cell from the side."""
    axes.set_title("frames, the cell from the side (⊗ points away from you, ⊙ towards you)", fontsize=11)
    place, work = side(s.links.origin), side(s.work.origin)
    tip, flange = place[-1], place[-2]
    axes.add_patch(Rectangle((-0.55, -0.04), 3.05, 0.04, color="#bbbbbb"))
    axes.add_patch(Rectangle((work[0], work[1] - 0.46), 0.95, 0.46, color=WORK, zorder=1))
    axes.add_patch(Rectangle((work[0] + 0.03, 0), 0.89, work[1] - 0.46, color="#ececec", zorder=1))
    axes.add_patch(Polygon([(-0.25, 0), (0.25, 0), (0.18, 0.3), (-0.18, 0.3)], color=LIGHT))
    arm = np.concatenate([[[0.0, 0.3]], place[1:-2], [flange]])
    for (a, b), width in zip(pairwise(arm), (24, 20, 16, 13, 11, 11), strict=False):
        axes.plot(*np.transpose([a, b]), color=LIGHT, lw=width, solid_capstyle="round", zorder=2)
    for joint in place[1:-2]:
        axes.add_patch(Circle(joint, 0.03, color=DARK, zorder=3))
    housing = (flange[0] - 0.06, tip[1] + 0.12)
    axes.add_patch(Rectangle(housing, 0.12, flange[1] - housing[1], color="#aab3ba", zorder=3))
    axes.add_patch(Rectangle((tip[0] - 0.02, tip[1]), 0.04, 0.12, color="#5b6770", zorder=3))
    triad(axes, Frame(s.links.rotation[0], s.links.origin[0]), 0.28, "base", (0.3, 0.1))
    triad(axes, Frame(s.links.rotation[-2], s.links.origin[-2]), 0.22, "flange", (flange[0] + 0.33, flange[1]))
    tcp = "TCP: tip of the cutter on its axis,\nz out of the tool into the work"
    triad(axes, Frame(s.links.rotation[-1], s.links.origin[-1]), 0.22, tcp, (tip[0] + 0.33, tip[1] + 0.02))
    triad(axes, s.work, 0.28, "work object:\nframe of the CAM file", (work[0] + 0.03, work[1] - 0.35))
    start = tip + np.array([-0.16, 0.03])
    arrow(axes, start, start + 0.32 * side(s.axis), DARK, 2.4)
    words = "tool axis i j k of a file:\nfrom the tip to the spindle,\n-z of the TCP"
    axes.text(start[0] - 0.03, start[1] + 0.52, words, fontsize=9.5, ha="right", va="center")
    note = {"fontsize": 9, "color": DARK, "style": "italic", "va": "center"}
    axes.text(place[3][0] + 0.2, place[3][1] - 0.05, "robot file: joint angles → flange", **note)
    axes.text(flange[0] + 0.12, 0.5 * (flange[1] + tip[1]), "[tool] xyz rpy: flange → TCP", **note)
    way = {"arrowstyle": "->", "ls": ":", "color": DARK, "shrinkA": 12, "shrinkB": 12}
    axes.annotate("", xy=work, xytext=(0.0, 0.0), arrowprops=way)
    axes.text(0.55, 0.2, "[workobject] xyz rpy:\nbase → work object", **note)
    axes.set_xlim(-0.6, 3.0)
    axes.set_ylim(-0.16, 2.1)


def signs(axes: Axes, s: Shown) -> None:
    """At the tip, deflection and correction enlarged."""
    axes.set_title("signs, at the tip; deflection and correction enlarged", fontsize=11)
    scale = 1.0 / float(np.linalg.norm(s.deflection))
    off, correction = scale * side(s.deflection), scale * side(s.correction)
    axes.add_patch(Rectangle((-2.95, -1.25), 5.95, 1.25, color=WORK, alpha=0.45, lw=0, zorder=0))
    for at, colour, dash in ((off, DEFLECTION, "--"), (np.zeros(2), DARK, "-"), (correction, CORRECTION, "--")):
        outline = at + np.array([[-0.16, 0], [0.16, 0], [0.16, 1.2], [-0.16, 1.2]])
        axes.add_patch(Polygon(outline, lw=1.4, ls=dash, fill=False, edgecolor=colour, zorder=3))
    push = 0.9 * side(s.force) / float(np.linalg.norm(s.force))
    arrow(axes, -push, np.zeros(2), FORCE, 3.0)
    arrow(axes, np.zeros(2), off, DEFLECTION, 2.4)
    arrow(axes, np.zeros(2), correction, CORRECTION, 2.4)
    axes.plot(0, 0, "o", color=DARK, ms=6, zorder=9)
    size = 1e3 * side(s.deflection), 1e3 * side(s.correction)
    told = (
        (off + np.array([0.24, 0.75]), DEFLECTION, "left",
         "as the file stands, the tool is here\n\ndeflection = actual - commanded,\n"
         f"({size[0][0]:+.2f}, {size[0][1]:+.2f}) mm in x, z:\nthe arm gives way\nwhere the force pushes"),
        (np.array([-0.22, 0.98]), DARK, "right", "where the file wants the tool,\nand where the program brings it"),
        (correction + np.array([-0.24, 0.3]), CORRECTION, "right",
         "with the program, this is commanded\n\ncorrection = added to the command,\n"
         f"({size[1][0]:+.2f}, {size[1][1]:+.2f}) mm:\nminus the deflection"),
        (-push + np.array([0.12, -0.22]), FORCE, "left",
         "wrench: what the environment\ndoes TO the robot, about the TCP;\n"
         f"here a force of ({s.force[0]:+.0f}, {s.force[2]:+.0f}) N in x, z"),
    )  # fmt: skip
    for at, colour, ha, words in told:
        axes.text(*at, words, color=colour, fontsize=9.5, ha=ha, va="center", zorder=9)
    moment(axes, np.array([2.2, -0.42]))
    axes.set_xlim(-2.95, 3.0)
    axes.set_ylim(-1.25, 1.9)


def moment(axes: Axes, at: Floats) -> None:
    """The sense of a moment and of a rotation about y, which goes away from the reader: from z to x."""
    axes.plot(*at, "x", color=AXIS, ms=6, mew=1.5)
    axes.add_patch(Circle(at, 0.1, fill=False, edgecolor=AXIS, lw=1.4))
    turn = np.radians(np.linspace(150, 20, 40))
    ring = at + 0.33 * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.plot(*ring.T, color=AXIS, lw=1.8)
    arrow(axes, ring[-2], ring[-1] + 0.6 * (ring[-1] - ring[-3]), AXIS)
    words = "+my and +ry: right-hand rule,\nfrom z to x"
    axes.text(at[0], at[1] - 0.18, words, color=AXIS, fontsize=9.5, ha="center", va="top")


def main() -> None:
    """Draw it."""
    s = shown()
    figure, (first, second) = plt.subplots(1, 2, figsize=(15.5, 5.0), dpi=100, width_ratios=(1.0, 1.12))
    frames(first, s)
    signs(second, s)
    for axes in (first, second):
        axes.set_aspect("equal")
        axes.axis("off")
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.93, wspace=0.03)
    figure.savefig(PICTURE, facecolor="white", metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    main()
