"""Corners between lines and arcs: the properties that make a rounding, on random elements."""

from __future__ import annotations

import math

import numpy as np
import pytest

from toolpaths.reading.corner import PlaneElement, chamfer, rounding, side_of_length, smooth, turn

Element = tuple[PlaneElement, PlaneElement]


def elements(seed: int) -> Element:
    """Two elements that meet at the origin at an angle: lines or arcs."""
    g = np.random.default_rng(seed)
    heading = g.uniform(0, math.tau)
    bend = g.choice((1, -1)) * g.uniform(0.4, 2.6)
    before, after = (math.cos(heading), math.sin(heading)), (math.cos(heading + bend), math.sin(heading + bend))
    return element(g, before, backwards=True), element(g, after, backwards=False)


def element(g: np.random.Generator, way: tuple[float, float], *, backwards: bool) -> PlaneElement:
    """An element that goes through the origin in a direction: it ends or starts there."""
    if g.random() < 0.4:
        length = g.uniform(5, 9)
        far = (way[0] * length, way[1] * length)
        return PlaneElement((-far[0], -far[1]), (0.0, 0.0)) if backwards else PlaneElement((0.0, 0.0), far)
    radius, side = g.uniform(4, 9), g.choice((1.0, -1.0))
    center = (-side * way[1] * radius, side * way[0] * radius)
    sweep = g.uniform(1.0, 2.0)
    angle = -side * sweep if backwards else side * sweep
    c, s = math.cos(angle), math.sin(angle)
    u, v = -center[0], -center[1]
    other = (center[0] + c * u - s * v, center[1] + s * u + c * v)
    ends = (other, (0.0, 0.0)) if backwards else ((0.0, 0.0), other)
    return PlaneElement(*ends, center, side * sweep)


@pytest.mark.parametrize("seed", range(60))
def test_a_rounding_touches_both_elements(seed: int) -> None:
    """Its ends lie on them, it leaves and arrives in their directions, its radius is the one that was asked for."""
    first, second = elements(seed)
    radius = 0.3
    arc = rounding(first, second, radius)
    on_it = PlaneElement(arc.start, arc.end, arc.center, arc.sweep)
    for point, on in ((arc.start, first), (arc.end, second)):
        assert math.dist(point, arc.center) == pytest.approx(radius, abs=1e-9)
        if on.center is None:
            way = on.direction(point)
            assert abs((point[0] - on.start[0]) * way[1] - (point[1] - on.start[1]) * way[0]) < 1e-9
        else:
            assert math.dist(point, on.center) == pytest.approx(math.dist(on.start, on.center), abs=1e-9)
        np.testing.assert_allclose(on_it.direction(point), on.direction(point), rtol=0, atol=1e-7)
        assert on.holds(point)
    assert turn(arc.center, arc.start, arc.end, arc.sweep) == pytest.approx(abs(arc.sweep), abs=1e-9)
    assert 0 < abs(arc.sweep) < math.pi and max(math.hypot(*arc.start), math.hypot(*arc.end)) < 3


def test_a_rounding_that_does_not_fit() -> None:
    first, second = PlaneElement((-1.0, 0.0), (0.0, 0.0)), PlaneElement((0.0, 0.0), (0.0, 1.0))
    assert rounding(first, second, 0.9).sweep == pytest.approx(math.pi / 2)
    with pytest.raises(ValueError, match="no arc of radius 1100 mm fits"):
        rounding(first, second, 1.1)


def test_chamfers() -> None:
    first, second = PlaneElement((-5.0, 0.0), (0.0, 0.0)), PlaneElement((0.0, 0.0), (3.0, 4.0))
    begin, end = chamfer(first, second, 2.0)
    assert begin == (-2.0, 0.0) and end == pytest.approx((1.2, 1.6))
    side = side_of_length(first, second, 1.5)
    assert math.dist(*chamfer(first, second, side)) == pytest.approx(1.5)
    with pytest.raises(ValueError, match="a chamfer of 6000 mm on a line of 5000 mm"):
        chamfer(first, second, 6.0)
    with pytest.raises(ValueError, match="beside an arc"):
        chamfer(first, PlaneElement((0.0, 0.0), (2.0, 0.0), (1.0, 0.0), math.pi), 1.0)


def test_what_goes_on_smoothly_has_no_corner() -> None:
    line = PlaneElement((-5.0, 0.0), (0.0, 0.0))
    assert smooth(line, PlaneElement((0.0, 0.0), (2.0, 2.0), (0.0, 2.0), math.pi / 2))
    assert not smooth(line, PlaneElement((0.0, 0.0), (2.0, 0.1)))
    assert not smooth(line, PlaneElement((0.0, 0.0), (-2.0, 0.0)))
