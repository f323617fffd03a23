"""The engine against brute force: every place of the cutter asked of every move before, on random walks."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stock import box_stock
from tests.compensator.process.milling.milling_jobs import K7075, path
from tests.compensator.process.milling.random_walks import BLOCK, SHAPES, nodes, random_walk, sweeps_of, wrong_nodes
from tests.oracles import milling as oracle

LOW, HIGH = np.array(BLOCK)
MOVES = 38


def expected(p: MillingPath, cut: Cut, shape: oracle.Shape, k: int) -> tuple[np.ndarray, float]:
    """Wrench (6,) in path axes and engaged area at pose k."""
    position, axis = p.position, p.axis
    sweeps = [
        oracle.Sweep(shape, position[i], position[i + 1], axis[i], axis[i + 1]) for i in range(k - 1)
    ]  # fmt: skip
    block = oracle.box(LOW * 1e-3, HIGH * 1e-3)

    def material(points: np.ndarray) -> np.ndarray:
        inside = block(points) < 0
        inside[inside] = oracle.outside_all(sweeps, points[inside]) > 0
        return inside

    way = position[k] - position[k - 1]
    return oracle.mean_force(
        shape=shape, material=material, tip=position[k], axes=cut.axes[k],
        feed=1e-4 * way / np.linalg.norm(way),
        teeth=p.cutters[0].flutes, coefficients=K7075, heights=160, angles=120,
    )  # fmt: skip


@pytest.mark.parametrize("turning", [False, True], ids=["3 axes", "5 axes"])
@pytest.mark.parametrize("name", [n for n in SHAPES if n != "drill"])
def test_random_walks(name: str, turning: bool) -> None:
    """Force within 5 % and 0.5 N, moment twice of that about the radius, area 5 %: what the steps of the sums leave."""
    cutter, shape = SHAPES[name]
    points, axes = random_walk(7, turning, MOVES)
    p = path(points, cutter, axis=axes)
    cut = mill(p, box_stock(LOW * 1e-3, HIGH * 1e-3), K7075, cell=cutter.radius / 10)
    good, seen = [], 0
    for k in range(10, len(p), 9):
        wrench, area = expected(p, cut, shape, k)
        size = float(np.linalg.norm(wrench[:3]))
        off = cut.wrench[k] - wrench
        force, moment = np.linalg.norm(off[:3]), np.linalg.norm(off[3:])
        bar = 0.05 * size + 0.5
        good += [force <= bar, moment <= 2 * bar * cutter.radius, abs(cut.area[k] - area) <= 0.05 * area + 1e-7]
        seen += size > 20.0
    assert seen > 1
    assert all(good)


def test_nodes_are_right() -> None:
    """In the material or not, as docs/cutting-accuracy.md has it; brute force with a cutter 60 um larger disagrees."""
    cutter, shape = SHAPES["bull"]
    points, axes = random_walk(3, True, 15)
    walked = path(points, cutter, axis=axes)
    cut = mill(walked, box_stock(LOW * 1e-3, HIGH * 1e-3), K7075, cell=cutter.radius / 10)
    assert cut.remains is not None
    places = nodes(cut.remains, 1500, 300)
    found = wrong_nodes(cut.remains, places, sweeps_of(walked, shape))
    assert found.near > 700 and found.wrong == 0
    larger = sweeps_of(walked, oracle.bull(0.00606, 0.00206, 0.014))
    assert wrong_nodes(cut.remains, places, larger).wrong > 3
