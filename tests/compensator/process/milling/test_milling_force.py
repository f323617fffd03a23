"""The mean force against closed forms: slot, half immersion, radial depth, plunge, ball on a plane, tilted end."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.process.milling.cutter import Cutter
from compensator.process.milling.mill import Cut, mill
from tests.compensator.process.milling.milling_jobs import FLAT20, K7075, along_x, arc_force, block, path

CELL = 1e-3  # a tenth of the radius


def last(cut: Cut) -> tuple[np.ndarray, float, float]:
    return cut.wrench[-1], float(np.degrees(cut.entry[-1])), float(np.degrees(cut.exit[-1]))


def close(given: np.ndarray, expected: np.ndarray, share: float = 0.005) -> None:
    assert np.linalg.norm(given - expected) <= share * np.linalg.norm(expected)


def test_slot_of_the_contract() -> None:
    cut = mill(path(along_x(-20, 40, 2, z=-3)), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    wrench, entry, exit = last(cut)
    close(wrench[:3], np.array([-168.05, -344.61, 93.20]))
    assert entry == pytest.approx(-90, abs=0.5) and exit == pytest.approx(90, abs=0.5)
    assert cut.ap[-1] == pytest.approx(3e-3, abs=1e-6)
    assert cut.area[-1] == pytest.approx(np.pi * 10e-3 * 3e-3, rel=0.005)
    assert cut.removal_rate[-1] == pytest.approx(20e-3 * 3e-3 * 1e-4 * 4 * 100, rel=0.005)
    # moment about the tip: half way up, the tangential force turns the tool back
    torque = -4 * 3e-3 / (2 * np.pi) * 10e-3 * (796e6 * 1e-4 * 2 + 27.7e3 * np.pi)
    np.testing.assert_allclose(wrench[5], torque, rtol=0.005)
    # the axial force pulls at the front of the cutter
    front = 4 * 3e-3 / (2 * np.pi) * 10e-3 * (222e6 * 1e-4 * np.pi / 2 + 1.4e3 * 2)
    moment = [1.5e-3 * wrench[1], -1.5e-3 * wrench[0] - front]
    np.testing.assert_allclose(wrench[3:5], moment, atol=0.005 * 10e-3 * 400)


@pytest.mark.parametrize(
    ("low", "high", "expected", "arc"),
    [(0, 40, [44.89, -247.17, 46.60], (0, 90)), (-40, 0, [-212.94, -97.44, 46.60], (-90, 0))],
    ids=["climb", "up"],
)
def test_half_immersion_of_the_contract(low: float, high: float, expected: list[float], arc: tuple[int, int]) -> None:
    """Path y is to the right of the feed, -y of the work object here."""
    stock = block((0, -high, -20), (80, -low, 0))
    wrench, entry, exit = last(mill(path(along_x(-20, 40, 2, z=-3)), stock, K7075, cell=CELL))
    close(wrench[:3], np.array(expected))
    assert (entry, exit) == (pytest.approx(arc[0], abs=0.5), pytest.approx(arc[1], abs=0.5))


@pytest.mark.parametrize("depth", [0.5, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("side", [-1, 1], ids=["up", "climb"])
def test_side_milling_at_a_wall_that_an_earlier_pass_left(depth: float, side: int) -> None:
    """The wall is that of a slot; the cutter comes back beside it, at a known radial depth."""
    out = along_x(-20, 100, 2, z=-3)
    shift = -depth if side == 1 else depth  # material at path y > 0 is at y < 0 of the work object
    beside = along_x(-20, 40, 2, y=shift, z=-3)
    away = np.array([[100, 60, 10], [-20, 60, 10]])
    points = np.concatenate([out, away, beside])
    rapid = np.zeros(len(points), dtype=bool)
    rapid[len(out) : len(out) + 3] = True
    rapid[len(out) - 1] = False
    cut = mill(path(points, rapid=rapid), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    wrench, entry, exit = last(cut)
    edge = np.arcsin(1 - depth / 10)
    arc = (edge, np.pi / 2) if side == 1 else (-np.pi / 2, -edge)
    close(wrench[:3], arc_force(*arc, ap=3e-3, feed=1e-4, teeth=4))
    assert (entry, exit) == (pytest.approx(np.degrees(arc[0]), abs=0.5), pytest.approx(np.degrees(arc[1]), abs=0.5))


def test_left_turning_spindle_mirrors_everything_in_y() -> None:
    points, stock = along_x(-20, 40, 2, z=-3), block((0, 0, -20), (80, 40, 0))
    mirrored = block((0, -40, -20), (80, 0, 0))
    right, left = (mill(path(points, sense=s), b, K7075, cell=CELL) for s, b in ((1, stock), (-1, mirrored)))
    sign = np.array([1, -1, 1, -1, 1, -1])  # forces are vectors, moments axial vectors
    np.testing.assert_allclose(left.wrench[-1], sign * right.wrench[-1], rtol=1e-9, atol=1e-9)
    assert (left.entry[-1], left.exit[-1]) == pytest.approx((right.entry[-1], right.exit[-1]))
    assert np.linalg.norm(right.wrench[-1, :3]) > 100


def test_plunge_of_a_flat_end_mill() -> None:
    """h = f all over the bottom: torque N / 2 pi (ktc f + kte) 2 pi R^2 / 2, thrust N (krc f + kre) R against feed."""
    down = np.column_stack([np.zeros(11), np.zeros(11), np.linspace(5, -5, 11)])
    cut = mill(path(down), block((-40, -40, -20), (40, 40, 0)), K7075, cell=CELL)
    w, f, n, r = cut.wrench[-1], 1e-4, 4, 10e-3
    assert w[2] == pytest.approx(-n * (168e6 * f + 30.8e3) * r, rel=0.005)
    assert w[5] == pytest.approx(-n * (796e6 * f + 27.7e3) * r**2 / 2, rel=0.005)
    np.testing.assert_allclose(w[[0, 1, 3, 4]], 0, atol=1e-3 * abs(w[2]))
    assert cut.area[-1] == pytest.approx(np.pi * r**2, rel=0.005)
    assert cut.removal_rate[-1] == pytest.approx(np.pi * r**2 * f * n * 100, rel=0.005)


def test_ball_on_a_plane() -> None:
    """A slot of a ball, integrated along the arc to its depth: h = f sin(kappa) cos(theta)."""
    ball, ap = Cutter("ball", 0.020, 2, 0.030), 1e-3
    cut = mill(path(along_x(-20, 40, 2, z=-1), ball), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    kappa = np.linspace(0, np.arccos(1 - ap / 10e-3), 2001)
    kappa = (kappa[1:] + kappa[:-1]) / 2
    theta = (np.arange(2000) + 0.5) / 2000 * np.pi - np.pi / 2
    on, db = np.full(len(theta), True), 10e-3 * (kappa[1] - kappa[0])
    expected = sum(element_force(theta, float(k), 1e-4, 0.0, on) for k in kappa) * np.pi / 2000 * db
    close(cut.wrench[-1, :3], 2 / (2 * np.pi) * expected, 0.01)
    assert cut.ap[-1] == pytest.approx(ap, abs=2e-6)


@pytest.mark.parametrize("tilt", [10.0, -10.0], ids=["leaning forward", "leaning back"])
def test_tilted_flat_end_mill(tilt: float) -> None:
    """A slot: all that is below the surface and goes forward cuts; leaning back the bottom does, too.

    In tool axes a place at rho, theta, s is s cos(tilt) - rho cos(theta) sin(tilt) above the tip, and the feed is
    f (cos(tilt), 0, -sin(tilt)).
    """
    a, depth = np.radians(tilt), 1e-3
    axis = (np.sin(a), 0.0, np.cos(a))
    cut = mill(path(along_x(-40, 40, 2, z=-1), axis=axis), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    fx, fz = 1e-4 * np.cos(a), -1e-4 * np.sin(a)
    theta = (np.arange(2000) + 0.5) / 2000 * 2 * np.pi - np.pi
    elements = [(10e-3, s, np.pi / 2, 4e-3 / 1000) for s in (np.arange(1000) + 0.5) * 4e-3 / 1000]
    elements += [(rho, 0.0, 0.0, 10e-3 / 1000) for rho in (np.arange(1000) + 0.5) * 10e-3 / 1000]
    expected = np.zeros(3)
    for rho, s, kappa, db in elements:
        on = s * np.cos(a) - rho * np.cos(theta) * np.sin(a) < depth
        expected += 2 * np.pi / 2000 * db * element_force(theta, kappa, fx, fz, on)
    close(cut.wrench[-1, :3], 4 / (2 * np.pi) * expected, 0.01)


def element_force(theta: np.ndarray, kappa: float, fx: float, fz: float, on: np.ndarray) -> np.ndarray:
    """Sum over the angles of the force of a unit of edge, (3,)."""
    ktc, krc, kac, kte, kre, kae = K7075
    h = fx * np.sin(kappa) * np.cos(theta) + fz * np.cos(kappa)
    on = on & (h > 0)
    edge = np.minimum(h / 1e-6, 1)
    zero = 0 * theta
    r = np.stack([np.cos(theta), np.sin(theta), zero])
    t = np.stack([-np.sin(theta), np.cos(theta), zero])
    z = np.array([[0.0], [0.0], [1.0]])
    n, a = np.sin(kappa) * r + np.cos(kappa) * z, np.sin(kappa) * z - np.cos(kappa) * r
    each = -(ktc * h + kte * edge) * t - (krc * h + kre * edge) * n + (kac * h + kae * edge) * a
    return np.asarray((each * on).sum(axis=1))


def test_nothing_engaged_and_no_feed_are_exactly_zero() -> None:
    air = mill(path(along_x(-20, 40, 2, z=1)), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    assert not air.wrench.any() and not air.area.any() and np.isnan(air.entry).all()
    standing = np.repeat(along_x(-20, 40, 2, z=-3), 2, axis=0)
    cut = mill(path(standing), block((0, -40, -20), (80, 40, 0)), K7075, cell=CELL)
    assert not cut.wrench[1::2].any() and cut.wrench[40::2].any()


def test_more_flutes_at_the_same_feed_per_tooth_give_as_many_times_the_force() -> None:
    stock, points = block((0, -40, -20), (80, 40, 0)), along_x(-20, 40, 2, z=-3)
    one, three = (mill(path(points, Cutter("flat", 0.02, n, 0.025)), stock, K7075, cell=CELL) for n in (1, 3))
    np.testing.assert_allclose(three.wrench, 3 * one.wrench, rtol=1e-12)
    assert FLAT20.flutes == 4
