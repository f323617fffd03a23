"""The pictures of traces.md: how a ball-bar, a two-sided touch, a tracker that follows the tool and a part are
measured, and what circles look like when something is wrong. Sketches, enlarged: python -m docs.make_trace_pictures"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

IMAGES = Path(__file__).parent / "images"
READ, MODEL, GREY = "#0072b2", "#d55e00", "0.75"
GAP = 0.12  # of the radius, enlarged


def main() -> None:
    """Write docs/images/traces-measuring.png and traces-telling.png."""
    figure, axes = plt.subplots(1, 4, figsize=(14, 3.9), constrained_layout=True)
    for draw, a in zip((_ball_bar, _touch, _stream, _part), axes, strict=True):
        draw(a)
    figure.savefig(IMAGES / "traces-measuring.png", dpi=110, metadata={"Software": None})
    figure, axes = plt.subplots(1, 4, figsize=(14, 3.9), subplot_kw={"aspect": "equal"}, constrained_layout=True)
    for (name, law), a in zip(LAWS.items(), axes, strict=True):
        _circle(a, name, law)
    figure.savefig(IMAGES / "traces-telling.png", dpi=110, metadata={"Software": None})


def _frame(a: Any, title: str) -> None:
    a.set(xticks=[], yticks=[])
    a.set_title(title, size=9.5)
    for spine in a.spines.values():
        spine.set_color(GREY)


def _ball_bar(a: Any) -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    a.plot(np.cos(angle), np.sin(angle), color=GREY)
    tip = np.array([np.cos(0.9), np.sin(0.9)])
    a.plot([0, tip[0]], [0, tip[1]], color="k", lw=3)
    a.plot(0, 0, "o", color="k", ms=13)
    a.plot(*tip, "o", color=READ, ms=10)
    for radius, ends in ((1.16, (1.25, 2.0)), (0.84, (2.0, 1.25))):
        at = radius * np.array([[np.cos(t), np.sin(t)] for t in ends])
        bent = f"arc3,rad={0.2 * np.sign(radius - 1)}"
        a.annotate("", at[1], at[0], arrowprops={"arrowstyle": "->", "connectionstyle": bent})
    a.text(0.06, -0.25, "centre: roughly\nknown is enough", size=8)
    a.text(tip[0] + 0.1, tip[1] + 0.05, "tool: distance\nis read", size=8, color=READ)
    a.set(xlim=(-1.4, 1.75), ylim=(-1.4, 1.4), aspect="equal")
    _frame(a, "ball-bar: both ways round,\ntwo planes, two feeds, dry")


def _touch(a: Any) -> None:
    q = np.linspace(-1, 1, 50)
    up, down = q - GAP, q + GAP
    a.plot(q, up, color=READ)
    a.plot(q, down, color=MODEL)
    for x, way in ((-0.5, 1), (0.5, -1)):
        y = x - GAP * way
        a.annotate("", (x + 0.2 * way, y + 0.2 * way), (x, y), arrowprops={"arrowstyle": "->", "lw": 2})
    a.axvline(0, color=GREY, lw=0.8)
    a.annotate("", (0, GAP), (0, -GAP), arrowprops={"arrowstyle": "<->"})
    a.text(0.06, -0.03, "lost motion =\ndifference / lever", size=8, va="top")
    a.set(xlabel="angle of one joint", ylabel="dial gauge")
    _frame(a, "dial gauge or probe: the same angle\nfrom below and from above")


def _stream(a: Any) -> None:
    s = np.linspace(0, 1, 200)
    path = np.column_stack([s * 2, 0.4 * np.sin(2 * np.pi * s)])
    late = np.column_stack([s * 2 - 0.12, 0.4 * np.sin(2 * np.pi * s)])[20::20]
    a.plot(*path.T, color=GREY, lw=2)
    a.plot(*late.T, "o", color=READ, ms=4)
    a.annotate("", late[4], path[100], arrowprops={"arrowstyle": "<->"})
    a.text(0.95, 0.28, "lag = feed x time:\none number, estimated", size=8)
    a.plot([0.2, late[1, 0]], [-0.9, late[1, 1]], color="k", lw=0.8, ls=":")
    a.plot(0.2, -0.95, "s", color="k", ms=12)
    a.text(0.35, -0.98, "tracker", size=8)
    a.set(xlim=(-0.2, 2.2), ylim=(-1.15, 0.8))
    _frame(a, "tracker that follows the tool:\nreadings with time, or with rows")


def _part(a: Any) -> None:
    corner = np.array([[-1, -0.7], [1, -0.7], [1, 0.7], [-1, 0.7], [-1, -0.7]])
    a.plot(*corner.T, color="0.5", lw=1.5)
    for k in range(4):
        share = np.linspace(0.06, 0.94, 12)[:, None]
        p = corner[k] + share * (corner[k + 1] - corner[k])
        along = corner[k + 1] - corner[k]
        out = np.array([along[1], -along[0]]) / np.linalg.norm(along)
        off = 0.18 + 0.1 * np.sin(9 * share) if k % 2 == 0 else 0.08 + 0 * share
        for one, d in zip(p, off, strict=True):
            a.annotate("", one + d * out, one, arrowprops={"arrowstyle": "->", "color": READ, "lw": 0.9})
    a.text(0, 0, "deviation along the\noutward normal,\n+ : material was left", size=8, ha="center", va="center")
    a.set(xlim=(-1.4, 1.4), ylim=(-1.15, 1.15), aspect="equal")
    _frame(a, "the part: walls with different normals,\nan uneven allowance")


def _flips(t: Any, sense: float, at: float) -> Any:
    """The way that a joint turns last whose motion turns round at two places."""
    return sense * np.sign(np.sin(t - at))


LAWS = {
    "play of a joint:\na step where it turns round": lambda t, s, feed: 0.07 * _flips(t, s, 0.6) * np.cos(t - 0.2),
    "friction: the step takes a travel": lambda t, s, feed: (
        0.07 * s * np.tanh(4 * np.sin(t - 0.6 - 0.25 * s)) * np.cos(t - 0.2)
    ),
    "servo lag of a joint: round, grows\nwith the feed (solid slow, dotted fast)": (
        lambda t, s, feed: 0.05 * feed * s * np.sin(2 * t - 0.5)
    ),
    "geometry: the same both ways": lambda t, s, feed: 0.09 * np.cos(2 * t - 0.7),
}


def _circle(a: Any, name: str, law: Any) -> None:
    t = np.linspace(0, 2 * np.pi, 721)
    a.plot(np.cos(t), np.sin(t), color=GREY, lw=1)
    for sense, colour in ((1.0, READ), (-1.0, MODEL)):
        for feed, style in ((1.0, "-"), (2.0, ":")):
            r = 1 + law(t, sense, feed)
            if style == "-" or np.ptp(law(t, sense, 2.0) - law(t, sense, 1.0)) > 0:
                a.plot(r * np.cos(t), r * np.sin(t), color=colour, ls=style, lw=1.5)
    a.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3))
    _frame(a, name)


if __name__ == "__main__":
    main()
