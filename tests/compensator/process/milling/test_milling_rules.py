"""The settled points of the contract: what a pose is engaged with does not depend on how the path is cut into moves."""

from __future__ import annotations

import numpy as np
import pytest

from compensator.process.milling.cutter import Cutter, ToolCylinder
from compensator.process.milling.findings import cut_findings
from compensator.process.milling.kernels.hits import ABOVE_EDGE, HOLDER_HIT, RAPID_HIT, SHANK_HIT, SIDEWAYS
from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.milling_load import CoefficientShares, CutColumns
from compensator.process.milling.path import arriving_axes
from tests.compensator.process.milling.milling_jobs import FLAT20, K7075, along_x, block, path
from toolpaths import columns

CELL = 1e-3
STOCK = block((0, -40, -20), (80, 40, 0))


def cut(points: np.ndarray, **how: object) -> Cut:
    return mill(path(points, **how), STOCK, K7075, cell=CELL)  # type: ignore[arg-type]


def arc(radius: float, step: float, z: float, turn: float = np.pi) -> np.ndarray:
    """Points of an arc about (40, 0), mm; chords of ``step``."""
    angle = np.linspace(0, turn, round(radius * turn / step) + 1)
    return np.column_stack([40 - radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), z)])


@pytest.mark.parametrize("step", [0.01, 0.05, 0.2, 0.5])
def test_short_moves_do_not_change_what_is_engaged(step: float) -> None:
    long = cut(along_x(-12, 20, 2, z=-3))
    short = cut(np.concatenate([along_x(-12, 18, 2, z=-3), along_x(18, 20, step, z=-3)[1:]]))
    np.testing.assert_allclose(short.wrench[-1], long.wrench[-1], rtol=0, atol=0.01 * np.linalg.norm(long.wrench[-1]))
    assert np.degrees(short.entry[-1]) == pytest.approx(-90, abs=1.0)
    assert np.degrees(short.exit[-1]) == pytest.approx(90, abs=1.0)
    assert short.removal_rate[-1] == pytest.approx(long.removal_rate[-1], rel=0.01)


@pytest.mark.parametrize("step", [0.05, 0.4])
def test_short_moves_round_an_arc(step: float) -> None:
    """A slot along an arc of 20 mm: half of the cutter, whatever the chords."""
    lead = np.array([[20, -30, -3], [20, -12, -3]])
    c = cut(np.concatenate([lead, arc(20, step, -3)]))
    middle = len(c) - 20
    assert np.degrees(c.entry[middle]) == pytest.approx(-90, abs=1.5)
    assert np.degrees(c.exit[middle]) == pytest.approx(90, abs=1.5)
    assert c.area[middle] == pytest.approx(np.pi * 10e-3 * 3e-3, rel=0.01)


@pytest.mark.parametrize("again", [along_x(-20, 60, 2, z=-3), arc(20, 0.3, -3)], ids=["line", "arc"])
def test_a_pass_on_the_same_line_is_air(again: np.ndarray) -> None:
    """Also where the file has rounded its places to a micrometre."""
    rounded = np.round(again, 3) if len(again) > 100 else again
    up = np.array([[again[-1, 0], again[-1, 1], 10], [again[0, 0], again[0, 1], 10]])
    points = np.concatenate([again, up, rounded])
    rapid = np.zeros(len(points), dtype=bool)
    rapid[len(again) : len(again) + 2] = True
    rapid[len(again) + 2] = True
    c = cut(points, rapid=rapid)
    first, second = c.area[2 : len(again)], c.area[len(again) + 3 :]
    assert first.max() > 50e-6
    assert second.max() < 0.01 * first.max()
    assert not np.any(c.hits & RAPID_HIT)


def test_a_floor_that_the_path_only_touches_gives_no_force() -> None:
    """Coming back over the floor of a slot, a micrometre lower or not."""
    back = along_x(60, -20, 2, z=-3)
    for lower in (0.0, 0.001):
        points = np.concatenate([along_x(-20, 60, 2, z=-3), back - [0, 0, lower]])
        c = cut(points)
        assert np.abs(c.wrench[60:, :3]).max() < 1e-6


def test_the_move_that_arrives_gives_feed_and_axes() -> None:
    """At a corner: the pose on it belongs to the move before, the next one to the move after."""
    points = np.concatenate([along_x(-20, 40, 2, z=-3), [[40.0, y, -3] for y in np.arange(2, 21, 2)]])
    axes = arriving_axes(path(points))
    np.testing.assert_allclose(axes[30, :, 0], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(axes[31, :, 0], [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(axes[:, :, 2], np.tile([0, 0, -1.0], (len(points), 1)), atol=1e-12)
    np.testing.assert_allclose(axes[0], axes[1])  # the first pose takes the next that exists
    assert not cut(points).wrench[0].any()


def test_a_plunge_keeps_the_last_feed_across() -> None:
    points = np.array([[0, 0, 5], [5, 5, 5], [5, 5, -2], [9, 5, -2.0]])
    axes = arriving_axes(path(points))
    np.testing.assert_allclose(axes[2, :, 0], axes[1, :, 0], atol=1e-12)
    np.testing.assert_allclose(axes[1, :, 0], [np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-12)


def test_the_edge_terms_rise_over_a_micrometre_of_chip() -> None:
    stock = block((0, -40, -20), (80, 40, 0))
    forces = []
    for feed in (1e-9, 0.25e-6, 0.5e-6):
        edge = np.array([0, 0, 0, 1e4, 0, 0.0])
        c = mill(path(along_x(-20, 20, 2, z=-3), feed_per_tooth=feed), stock, edge, cell=CELL)
        forces.append(np.linalg.norm(c.wrench[-1, :3]))
    assert forces[0] < 0.01 * forces[2]
    assert forces[1] == pytest.approx(0.5 * forces[2], rel=0.01)


def test_peak_of_a_straight_tooth_and_of_a_helix() -> None:
    """One straight tooth in a slot: the largest force of a tooth, found by hand. A helix spreads it over the height."""
    h, k = 1e-4 * np.cos(np.linspace(-np.pi / 2, np.pi / 2, 100001)), K7075
    force = 3e-3 * np.sqrt(
        (k[0] * h + k[3]) ** 2 + (k[1] * h + k[4]) ** 2 + (k[2] * h + k[5]) ** 2
    )  # fmt: skip
    one = Cutter("flat", 0.020, 1, 0.025)
    straight = cut(along_x(-20, 20, 2, z=-3), cutter=one)
    assert straight.peak[-1] == pytest.approx(force.max(), rel=0.005)
    helical = cut(along_x(-20, 20, 2, z=-18), cutter=Cutter("flat", 0.020, 1, 0.025, helix=np.radians(45)))
    flat = cut(along_x(-20, 20, 2, z=-18), cutter=one)
    assert flat.peak[-1] == pytest.approx(6 * force.max(), rel=0.005)
    assert helical.peak[-1] == pytest.approx(helix_peak(18e-3, 45.0), rel=0.02)
    np.testing.assert_allclose(helical.wrench, flat.wrench)  # the mean does not know the helix


def helix_peak(ap: float, helix: float) -> float:
    """Largest norm over a turn of one tooth in a slot, by brute force."""
    z = (np.arange(400) + 0.5) * ap / 400
    best = 0.0
    for turned in np.linspace(0, 2 * np.pi, 2001):
        angle = turned - z * np.tan(np.radians(helix)) / 10e-3
        h = 1e-4 * np.cos(angle)
        on = h > 0
        ktc, krc, kac, kte, kre, kae = K7075
        t, n, a = (ktc * h + kte) * on, (krc * h + kre) * on, (kac * h + kae) * on
        f = [np.sum(t * np.sin(angle) - n * np.cos(angle)), np.sum(-t * np.cos(angle) - n * np.sin(angle)), np.sum(a)]
        best = max(best, float(np.linalg.norm(f)) * ap / 400)
    return best


def test_run_out_raises_the_peak_and_not_the_mean() -> None:
    round_, out = (cut(along_x(-20, 20, 2, z=-3), cutter=Cutter("flat", 0.02, 2, 0.025, runout=r)) for r in (0.0, 2e-5))
    assert out.peak[-1] > 1.1 * round_.peak[-1]
    np.testing.assert_allclose(out.wrench, round_.wrench)


def bits(c: Cut) -> int:
    return int(np.bitwise_or.reduce(c.hits))


def test_a_rapid_through_material_is_found() -> None:
    points = np.array([[-20, 0, 12], [-20, 0, 10], [-20, 0, -3], [100, 0, -3.0]])
    rapid = [True, False, True, True]
    assert bits(cut(points + np.array([0, 0, 3.5]), rapid=rapid)) == 0
    c = cut(points, rapid=rapid)
    assert bits(c) == RAPID_HIT
    assert c.remains is not None and c.remains.removed == 0.0 and not c.removed.any()  # rapids never remove material
    assert [(f.kind, f.pose) for f in cut_findings(c)] == [("rapid", 3)]


def test_a_rapid_out_of_the_slot_that_was_just_cut_hits_nothing() -> None:
    points = np.concatenate([along_x(-20, 40, 2, z=-3), [[40, 0, 20.0]]])
    assert bits(cut(points, rapid=np.arange(len(points)) == len(points) - 1)) == 0


def test_material_above_the_edge_stays_and_is_found() -> None:
    short = Cutter("flat", 0.020, 4, 0.010)
    c = cut(along_x(-20, 60, 2, z=-15), cutter=short)
    assert bits(c) & ABOVE_EDGE
    assert c.ap[-1] == pytest.approx(10e-3, abs=1e-6)
    assert c.remains is not None
    assert c.remains.depth(np.array([[0.03, 0, -0.002], [0.03, 0, -0.010]])) == pytest.approx([-2e-3, 5e-3], abs=4e-3)
    assert bits(cut(along_x(-20, 60, 2, z=-10), cutter=short)) == 0


def test_shank_and_holder_in_the_stock_are_found() -> None:
    shank = Cutter("flat", 0.020, 4, 0.010, stack=(ToolCylinder(0.012, 0.03, False),))
    holder = Cutter("flat", 0.020, 4, 0.010, stack=(ToolCylinder(0.01, 0.004, False), ToolCylinder(0.03, 0.05, True)))
    slender = Cutter("flat", 0.020, 4, 0.010, stack=(ToolCylinder(0.008, 0.03, False),))
    twice = np.concatenate([along_x(-40, 60, 2, z=-9), along_x(60, -40, 2, z=-16)])
    assert bits(cut(twice, cutter=shank)) == SHANK_HIT
    assert bits(cut(twice, cutter=holder)) == HOLDER_HIT
    assert bits(cut(twice, cutter=slender)) == 0


def test_a_drill_that_moves_sideways_is_found() -> None:
    drill = Cutter("drill", 0.010, 2, 0.040, half_angle=np.radians(59))
    hole = np.column_stack([np.full(11, 20.0), np.zeros(11), np.linspace(2, -8, 11)])
    c = cut(hole, cutter=drill)
    assert bits(c) == 0 and c.wrench[-1, 2] < -10
    assert bits(cut(np.concatenate([hole, hole[-1:] + np.array([1.0, 0, 0])]), cutter=drill)) == SIDEWAYS


def test_the_longest_engaged_height_of_two_levels() -> None:
    """A cutter over a step: entry and exit are over all heights, ap is that of the higher side."""
    first = along_x(-20, 100, 2, y=15, z=-2)
    c = cut(np.concatenate([first, [[100, 15, 20], [-20, 5, 20]], along_x(-20, 40, 2, y=5, z=-4)]),
            rapid=np.isin(np.arange(61 + 2 + 31), [61, 62, 63]))  # fmt: skip
    assert c.ap[-1] == pytest.approx(4e-3, abs=1e-6)
    lower, upper = 20.0 * 4 - 0, 0.0
    assert lower > upper
    # removed: 20 x 4 less the 2 mm that the first pass took from y = 5 on
    assert c.removal_rate[-1] == pytest.approx((20 * 4 - 10 * 2) * 1e-6 * 1e-4 * 400, rel=0.01)


def test_removal_over_a_long_move_that_leaves_the_stock() -> None:
    c = cut(np.array([[-20, 0, -3], [70, 0, -3], [100, 0, -3.0]]))
    # the last move leaves the block at x = 80: what is left of the slot is removed, the rest is air
    assert c.removed.sum() == pytest.approx(80 * 20 * 3 * 1e-9, rel=0.02)
    assert FLAT20.radius == 0.01


def test_the_engagement_of_some_poses_alone() -> None:
    """As in the whole walk, on the same grid; on twice as coarse a one within a hundredth of the force."""
    points = np.concatenate([along_x(-12, 60, 0.5, z=-3), along_x(60, 20, 0.5, y=8, z=-5)])
    whole, rows = cut(points), np.array([40, 100, 190, 220])
    assert (whole.area[rows] > 0).all()
    some = mill(path(points), STOCK, K7075, cell=CELL, only=rows)
    np.testing.assert_array_equal(some.wrench[rows], whole.wrench[rows])
    assert not np.delete(some.area, rows).any()
    coarse = mill(path(points), STOCK, K7075, cell=2 * CELL, only=rows).wrench[rows]
    size = np.linalg.norm(whole.wrench[rows, :3], axis=1)
    assert (np.linalg.norm(coarse - whole.wrench[rows], axis=1) < 0.01 * size).all()


def test_shares_are_told_where_they_are_kept_and_nowhere_else() -> None:
    """The nearest pose that is kept would be another wrench."""
    whole = CoefficientShares(None, np.arange(10 * 36, dtype=float).reshape(10, 6, 6))
    some = whole.only(np.array([7, 2, 7, 5]))
    np.testing.assert_array_equal(some.at(np.array([5, 2])), whole.values[[5, 2]])
    for missing in (4, 8, 0):
        with pytest.raises(KeyError, match="not at all of those asked for"):
            some.at(np.array([5, missing]))
    with pytest.raises(KeyError, match="at 0 poses"):
        whole.only(np.array([], dtype=np.intp)).at(np.array([3]))


def test_what_is_asked_of_a_cut_at_some_poses_is_that_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares on the disk are those in memory; columns of some poses are rows of the whole ones."""
    points = np.concatenate([along_x(-12, 60, 0.5, z=-3), along_x(60, 20, 0.5, y=8, z=-5)])
    held = mill(path(points), STOCK, K7075, cell=CELL, shares=True)
    monkeypatch.setattr(columns, "BLOCK", 100)
    cut = mill(path(points), STOCK, K7075, cell=CELL, shares=True)
    rows = np.array([40, 0, 100, 190, 41])
    assert held.shares is not None and cut.shares is not None and "disk" in repr(cut.shares)
    np.testing.assert_array_equal(cut.shares[:], held.shares[:])
    np.testing.assert_allclose(cut.shares[rows] @ K7075, cut.wrench[rows], rtol=1e-12, atol=1e-12)
    whole = CutColumns(cut, np.arange(len(cut)) % 3 == 0)
    for name, values in whole.items():
        np.testing.assert_array_equal(whole.at(name, rows), values[rows], err_msg=name)
