"""Milling by brute force: every point asked of every move before, with formulas of its own. numpy, slow.

A cutter is its radius over the height above the tip; a point is cut if at some share of a move it is inside. Nothing of
the product is used but the numbers that describe a cutter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
SAMPLES = 21  # shares of a move that are tried first
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Shape:
    """Radius over height: ``height`` ascending from 0 to the length, ``radius`` there, m."""

    height: Floats
    radius: Floats

    def outside(self, rho: Floats, s: Floats) -> Floats:
        """Below 0 inside; above 0 outside. Near the surface about the distance along rho or s."""
        return np.maximum(rho - np.interp(s, self.height, self.radius), np.maximum(-s, s - self.height[-1]))


def flat(radius: float, length: float) -> Shape:
    """A flat end mill."""
    return Shape(np.array([0.0, length]), np.array([radius, radius]))


def bull(radius: float, corner: float, length: float) -> Shape:
    """A bull nose; with a corner as large as the radius a ball."""
    angle = np.linspace(0.0, np.pi / 2, 20001)
    height = np.append(corner * (1 - np.cos(angle)), length)
    return Shape(height, np.append(radius - corner + corner * np.sin(angle), radius))


def cone(tip: float, half_angle: float, length: float) -> Shape:
    """A taper with a sharp corner."""
    return Shape(np.array([0.0, length]), np.array([tip, tip + length * np.tan(half_angle)]))


def drill(radius: float, point_angle: float, length: float) -> Shape:
    """A drill."""
    return Shape(np.array([0.0, radius / np.tan(point_angle / 2), length]), np.array([0.0, radius, radius]))


@dataclass(frozen=True)
class Sweep:
    """A move: tip from ``start`` to ``end`` (3,), axis from ``first`` to ``last`` (3,) along the shortest turn."""

    shape: Shape
    start: Floats
    end: Floats
    first: Floats
    last: Floats

    def outside(self, points: Floats) -> Floats:
        """The least of ``Shape.outside`` over the move, (P,)."""
        share = np.linspace(0.0, 1.0, SAMPLES)
        values = np.stack([self._at(points, np.full(len(points), t)) for t in share])
        best = values.argmin(axis=0)
        low, high = share[np.maximum(best - 1, 0)], share[np.minimum(best + 1, SAMPLES - 1)]
        least = values.min(axis=0)
        for _ in range(20):
            a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            va, vb = self._at(points, a), self._at(points, b)
            least = np.minimum(least, np.minimum(va, vb))
            low, high = np.where(va < vb, low, a), np.where(va < vb, b, high)
        return least

    def _at(self, points: Floats, t: Floats) -> Floats:
        angle = 2.0 * np.arcsin(min(float(np.linalg.norm(self.last - self.first)) / 2.0, 1.0))
        if angle > 1e-12:
            a, b = np.sin((1 - t) * angle) / np.sin(angle), np.sin(t * angle) / np.sin(angle)
            axis = a[:, None] * self.first + b[:, None] * self.last
        else:
            axis = np.broadcast_to(self.first, points.shape)
        q = points - self.start - t[:, None] * (self.end - self.start)
        s = np.sum(q * axis, axis=1)
        return self.shape.outside(np.linalg.norm(q - s[:, None] * axis, axis=1), s)


def outside_all(sweeps: list[Sweep], points: Floats) -> Floats:
    """The least over all sweeps, (P,): below 0 where something has cut."""
    least = np.full(len(points), np.inf)
    for sweep in sweeps:
        near = _in_reach(sweep, points)
        if near.any():
            least[near] = np.minimum(least[near], sweep.outside(points[near]))
    return least


def _in_reach(sweep: Sweep, points: Floats) -> npt.NDArray[np.bool_]:
    """Points in the box around a sweep."""
    reach = float(sweep.shape.radius.max() + sweep.shape.height[-1])
    low, high = np.minimum(sweep.start, sweep.end) - reach, np.maximum(sweep.start, sweep.end) + reach
    return np.asarray(np.all((points > low) & (points < high), axis=1))


def box(low: Floats, high: Floats) -> Callable[[Floats], Floats]:
    """Outside of a box: above 0; inside below."""
    return lambda points: np.maximum(low - points, points - high).max(axis=1)


def mean_force(
    *, shape: Shape, material: Callable[[Floats], npt.NDArray[np.bool_]], tip: Floats, axes: Floats, feed: Floats,
    teeth: int, coefficients: Floats, heights: int = 200, angles: int = 720,
) -> tuple[Floats, float]:  # fmt: skip
    """Force and moment (6,) on the tool in path axes about the tip, by summing elements; and the engaged area, m2.

    Normals of the side from its radius over height; a flat bottom is a side of its own.

    Args:
        material: points (P, 3) in the work object -> whether they are in the material.
        tip: (3,); axes: (3, 3) columns x, y, z. feed: (3,) m per tooth, in the work object.
    """
    h = np.linspace(0.0, shape.height[-1], heights + 1)
    s = (h[1:] + h[:-1]) / 2
    rho = np.interp(s, shape.height, shape.radius)
    slope = np.diff(np.interp(h, shape.height, shape.radius)) / np.diff(h)
    length = np.hypot(np.diff(np.interp(h, shape.height, shape.radius)), np.diff(h))
    theta = (np.arange(angles) + 0.5) / angles * 2 * np.pi - np.pi
    r = np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=1)
    t = np.stack([-np.sin(theta), np.cos(theta), 0 * theta], axis=1)
    z = np.array([0.0, 0.0, 1.0])
    f = axes.T @ feed
    ktc, krc, kac, kte, kre, kae = coefficients
    sin, cos = 1 / np.hypot(1, slope), slope / np.hypot(1, slope)  # of kappa
    flat = shape.radius[0] * (np.arange(heights) + 0.5) / heights if shape.radius[0] > 0 else np.zeros(0)
    none = np.zeros(len(flat))
    both = ((rho, flat), (s, none), (sin, none), (cos, none + 1))
    rho, s, sin, cos = (np.concatenate(v)[:, None, None] for v in both)
    length = np.concatenate([length, none + shape.radius[0] / heights])
    n, a, place = sin * r + cos * z, sin * z - cos * r, rho * r - s * z
    chip = n @ f
    on = chip > 0
    on[on] = material(tip + place[on] @ axes.T)
    edge = np.minimum(chip / 1e-6, 1.0)
    force = -(ktc * chip + kte * edge)[..., None] * t - (krc * chip + kre * edge)[..., None] * n
    force = (force + (kac * chip + kae * edge)[..., None] * a) * (on * length[:, None])[..., None] * 2 * np.pi / angles
    both = np.concatenate([force, np.cross(place, force)], axis=2)
    area = float(np.sum(on * (length * rho[:, 0, 0])[:, None])) * 2 * np.pi / angles
    return teeth / (2 * np.pi) * both.sum(axis=(0, 1)), area
