"""The engine against brute force: every place of the cutter asked of every move before, on random walks."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stock import box_stock
from tests.compensator.process.milling.milling_jobs import K7075, path
from tests.oracles import milling as oracle

LOW, HIGH = np.array([-30.0, -30.0, -25.0]), np.array([30.0, 30.0, 0.0])
SHAPES: dict[str, tuple[Cutter, oracle.Shape]] = {
    "flat": (Cutter("flat", 0.010, 3, 0.014), oracle.flat(0.005, 0.014)),
    "bull": (Cutter("bull", 0.012, 4, 0.014, corner_radius=0.002), oracle.bull(0.006, 0.002, 0.014)),
    "ball": (Cutter("ball", 0.010, 2, 0.014), oracle.bull(0.005, 0.005, 0.014)),
    "taper": (Cutter("taper", 0.006, 2, 0.014, half_angle=np.radians(5)), oracle.cone(0.003, np.radians(5), 0.014)),
}
MOVES = 38


def walk(seed: int, turning: bool) -> tuple[np.ndarray, np.ndarray]:
    """Points (N, 3) mm and axes (N, 3): a walk to and fro in the upper part of the block, that comes back on itself."""
    rng = np.random.default_rng(seed)
    points, axes = [np.array([-40.0, -10.0, -2.0])], [np.array([0.0, 0.0, 1.0])]
    while len(points) <= MOVES:
        middle = np.array([0.0, 0.0, -3.5])
        way = rng.normal(size=3) * [6, 6, 0.8] + 0.15 * (middle - points[-1])
        point = points[-1] + way
        point[2] = np.clip(point[2], -7.0, -0.5)
        points.append(point)
        lean = axes[-1] + (rng.normal(size=3) * [0.06, 0.06, 0] if turning else 0.0)
        lean[:2] *= min(1.0, 0.25 / max(float(np.hypot(*lean[:2])), 1e-9))
        axes.append(lean / np.linalg.norm(lean))
    return np.array(points), np.array(axes)


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
@pytest.mark.parametrize("name", SHAPES)
def test_random_walks(name: str, turning: bool) -> None:
    """Force within 5 % and 0.5 N, moment twice of that about the radius, area 5 %: what the steps of the sums leave."""
    cutter, shape = SHAPES[name]
    points, axes = walk(7, turning)
    p = path(points, cutter, axis=axes)
    cut = mill(p, box_stock(LOW * 1e-3, HIGH * 1e-3), K7075, cell=cutter.radius / 10)
    good, seen = [], 0
    for k in range(8, len(p), 6):
        wrench, area = expected(p, cut, shape, k)
        size = float(np.linalg.norm(wrench[:3]))
        off = cut.wrench[k] - wrench
        force, moment = np.linalg.norm(off[:3]), np.linalg.norm(off[3:])
        bar = 0.05 * size + 0.5
        good += [force <= bar, moment <= 2 * bar * cutter.radius, abs(cut.area[k] - area) <= 0.05 * area + 1e-7]
        seen += size > 20.0
    assert seen > 2
    assert all(good)
