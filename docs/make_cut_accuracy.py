"""Writes docs/cutting-accuracy.md: the engine of the cut against closed forms, exact booleans and brute force.

    python -m docs.make_cut_accuracy

Brute force is tests/oracles/milling.py: it asks every node of every move before, and shares no formula with the engine.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.remains import Remains
from tests.compensator.process.milling.milling_jobs import K7075, along_x, arc_force, block, path
from tests.compensator.process.milling.random_walks import BLOCK, SHAPES, nodes, random_walk, sweeps_of, wrong_nodes

Floats = npt.NDArray[np.float64]

PAGE = Path(__file__).parent / "cutting-accuracy.md"
SEEDS = (11, 12)
MOVES = 40
NEAR_SURFACE, ELSEWHERE = 20_000, 5_000  # nodes of a walk that are asked for
SIDES = {"up": -1, "climb": 1}
DEPTHS = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0)  # mm, of a cutter of radius 10 mm


def side_milling(depth: float, side: int) -> tuple[Cut, tuple[float, float]]:
    """A pass beside the slot that an earlier one left, 3 mm deep, with a radial depth in mm; the arc by hand, rad."""
    out = along_x(-20, 100, 2, z=-3)
    beside = along_x(-20, 40, 2, y=-side * depth, z=-3)
    away = np.array([[100, 60, 10], [-20, 60, 10]])
    rapid = np.zeros(len(out) + 2 + len(beside), dtype=bool)
    rapid[len(out) : len(out) + 3] = True
    walked = path(np.concatenate([out, away, beside]), rapid=rapid)
    cut = mill(walked, block((0, -40, -20), (80, 40, 0)), K7075, cell=1e-3)
    edge = float(np.arcsin(1 - depth / 10))
    return cut, ((edge, np.pi / 2) if side == 1 else (-np.pi / 2, -edge))


def closed_rows() -> Iterator[str]:
    """Radial depth; error of the mean force, and of the free end of the arc, on both sides."""
    for depth in DEPTHS:
        cells = []
        for side in SIDES.values():
            cut, arc = side_milling(depth, side)
            expected = arc_force(*arc, ap=3e-3, feed=1e-4, teeth=4)
            error = np.linalg.norm(cut.wrench[-1, :3] - expected) / np.linalg.norm(expected)
            off = max(abs(cut.entry[-1] - arc[0]), abs(cut.exit[-1] - arc[1]))
            cells += [f"{error:.3%}", f"{np.degrees(off):.3f}"]
        yield f"| {depth:g} | " + " | ".join(cells) + " |"


def node_rows() -> Iterator[str]:
    """A row per cutter and number of axes: nodes, those near a cut, those that are wrong, and by how much."""
    for name, (cutter, shape) in SHAPES.items():
        for turning in (False, True):
            near = every = wrong = 0
            worst = 0.0
            for seed in SEEDS:
                points, axes = random_walk(seed, turning, MOVES)
                walked = path(points, cutter, axis=axes)
                cut = mill(walked, block(*BLOCK), K7075, cell=cutter.radius / 10)
                remains = _left(cut)
                places = nodes(remains, NEAR_SURFACE, ELSEWHERE)
                found = wrong_nodes(remains, places, sweeps_of(walked, shape))
                every, near = every + len(places), near + found.near
                wrong, worst = wrong + found.wrong, max(worst, found.worst)
            counts = f"{every:,} | {near:,} | {wrong:,} | {wrong / near:.4%}"
            yield f"| {name} | {5 if turning else 3} | {counts} | {worst * 1e6:.1f} |"


def _left(cut: Cut) -> Remains:
    if cut.remains is None:
        raise ValueError("the walk cuts nothing")
    return cut.remains


def page() -> str:
    """The whole page."""
    return "\n".join([
        "# How exact the cut is",
        "",
        "Made by `python -m docs.make_cut_accuracy` (minutes: the brute force is slow). What is compared, and with",
        "what, stands in [cutting.md](cutting.md) and in `tests/oracles/milling.py`.",
        "",
        "## Closed forms",
        "",
        "A flat end mill of radius 10 mm comes back beside a slot that it has cut, grid 1 mm (a tenth of the radius):",
        "error of the mean force as a share of its norm, and of the ends of the arc in deg. Bounds: 0.5 % and 0.5 deg.",
        "",
        "| radial depth, mm | up: force | arc | climb: force | arc |",
        "| ---: | ---: | ---: | ---: | ---: |",
        *closed_rows(),
        "",
        "## Nodes against brute force",
        "",
        f"Random walks of {MOVES} moves that come back on themselves in a block of 60 x 60 x 25 mm, {len(SEEDS)} of",
        "each kind, on the grid of the product (a tenth of the radius). Of nodes drawn by chance, most of them near a",
        "cut, is asked whether they are in the material: of the field, and of every sweep by brute force. Wrong: the",
        "answers differ, and the surface is more than a micrometre away. The share is of the nodes within two cells of",
        "a cut. Bound: 0.1 %.",
        "",
        "| cutter | axes | nodes | near a cut | wrong | share of those near | worst, um |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
        *node_rows(),
        "",
    ])  # fmt: skip


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
