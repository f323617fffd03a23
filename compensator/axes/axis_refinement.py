"""The refinement of rails and tables along a path: sequential quadratic programs over the coefficients of their curves.

As in ``refinement``: Gauss-Newton steps, travel of joints in place of crossings, in windows of coefficients that
overlap. A step is taken where every key of it is free. Range, speed and acceleration of rails, joint limits and the
ways of joints from key to key are bounds of the program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from compensator.axes.axis_cost import AxisCost
from compensator.axes.axis_curve import CurveBasis, program
from compensator.turn.lean_refinement import bend
from compensator.turn.turn_cost import ROUGH
from compensator.turn.turn_kinematics import moves
from compensator.turn.windows import (
    DAMPING,
    STILL,
    Refined,
    descended,
    refined_in_windows,
    smooth_weights,
    travelled,
)

Floats = npt.NDArray[np.float64]

STEPS = 8
TRUST = 0.1  # m of a step
CREEP = 1e-5  # m: ways of an axis from key to key below it cost as their squares


def refined_axes(cost: AxisCost, basis: CurveBasis, coefficients: Floats, time: Floats) -> Refined:
    """Coefficients that cost less than ``coefficients`` (M, A), which are free, or the same.

    Args:
        time: (K,) s of the keys.
    """
    now = coefficients.copy()
    shapes = tuple(basis.at(time, derivative) for derivative in range(3))
    price = cost.travel(shapes[0] @ now)

    def solve(part: slice, held: int, given: Floats) -> Floats | None:
        now[part] = given
        found = _Window(cost, basis, part, held, rest=now, shapes=shapes, price=price).solved(given)
        if found is not None:
            now[part] = found
        return found

    return refined_in_windows(coefficients, solve)


@dataclass(frozen=True, eq=False)
class _Window:
    """Some coefficients: ``held`` of the first ones stay, and ``rest`` (M, A) beyond them.

    Attributes:
        shapes: (K, M) values, speeds and accelerations at the keys. price: (K - 1, n) m3/rad.
    """

    cost: AxisCost
    basis: CurveBasis
    part: slice
    held: int
    rest: Floats
    shapes: tuple[sp.csr_matrix, ...]
    price: Floats

    def solved(self, given: Floats) -> Floats | None:
        """(m, A); None where a program failed."""
        return descended(given, size=self._size, step=self._step, moved=np.add, steps=STEPS)

    @property
    def keys(self) -> slice:
        """Those that the coefficients move."""
        moved = np.flatnonzero(np.diff(self.shapes[0][:, self.part].indptr))
        return slice(int(moved[0]), int(moved[-1]) + 1)

    def _whole(self, given: Floats) -> Floats:
        out = self.rest.copy()
        out[self.part] = given
        return out

    def _size(self, given: Floats) -> float:
        """m3, the smooth cost that steps make smaller; infinite where a key is not free."""
        cost, keys, whole = self.cost, self.keys, self._whole(given)
        places, bend = (self.shapes[k][keys] @ whole for k in (0, 2))
        if not cost.allows(places, keys).all():
            return np.inf
        at = cost.postures(places, keys)
        way, (weight, rough, before, after) = moves(at.commands), smooth_weights(cost.motion, keys)
        bent = (after * way[1:] - before * way[:-1]) / cost.acceleration
        own = np.sum(weight * at.sd**2) + self._axes(weight, places, bend)
        return float(own + travelled(self.price[keys.start : keys.stop - 1], way) + np.sum(rough * bent**2))

    def _axes(self, weight: Floats, places: Floats, bend: Floats) -> float:
        """m3, the price of what axes do."""
        free, toll = self.cost.free, self.cost.toll[self.keys.start : self.keys.stop - 1]
        rough = np.sum(weight * np.where(free.moving, ROUGH * bend / free.acceleration, 0.0).T ** 2)
        gone = np.abs(np.diff(places[:, free.moving], axis=0)) * free.size[free.moving]
        return float(rough + np.sum(toll[:, None] * (np.sqrt(gone**2 + CREEP**2) - CREEP)))

    def _step(self, given: Floats) -> Floats | None:
        """(m, A) that minimises the quadratic model; None where the program failed."""
        cost, keys, whole = self.cost, self.keys, self._whole(given)
        (m, width), shapes = given.shape, [shape[keys][:, self.part] for shape in self.shapes]
        at, g, slope = cost.slopes(self.shapes[0][keys] @ whole, keys)
        n, way = g.shape[1], moves(at.commands)
        weight, rough, before, after = smooth_weights(cost.motion, keys)
        joints = _by_key(g, shapes[0])
        ways = joints[n:] - joints[:-n]
        ends = bend(before, after, cost.acceleration, n) @ ways
        bent = (after * way[1:] - before * way[:-1]) / cost.acceleration
        price = self.price[keys.start : keys.stop - 1]
        rows = [
            (_by_key(slope[:, None], shapes[0]), weight, at.sd),
            (ways, price.ravel() / (2 * np.sqrt(way**2 + STILL**2).ravel()), way.ravel()),
            (ends, np.broadcast_to(rough, bent.shape).ravel(), bent.ravel()),
            *self._moving(weight, shapes, whole, keys),
        ]
        h = sum(2 * (j.T @ sp.diags(w) @ j) for j, w, _ in rows)
        gradient = np.sum([2 * (j.T @ (w * r)) for j, w, r in rows], axis=0)
        scale = float(h.diagonal().max())
        if scale == 0.0:
            return np.zeros_like(given)
        h = (h + DAMPING * scale * sp.eye(m * width)) / scale
        return self._program(h, gradient / scale, sp.vstack([ways, joints]), whole=whole, commands=at.commands)

    def _moving(
        self, weight: Floats, shapes: list[sp.csr_matrix], whole: Floats, keys: slice
    ) -> list[tuple[sp.csr_matrix, Floats, Floats]]:
        """Rows of ways and accelerations of each axis that moves."""
        free, out, toll = self.cost.free, [], self.cost.toll[keys.start : keys.stop - 1]
        for a in np.flatnonzero(free.moving):
            pick = np.eye(len(free))[a : a + 1]
            bend = self.shapes[2][keys] @ whole[:, a]
            out.append((sp.kron(shapes[2], pick, format="csr"), weight * (ROUGH / free.acceleration[a]) ** 2, bend))
            way = np.diff(self.shapes[0][keys] @ whole[:, a]) * free.size[a]
            pull = toll / (2 * np.sqrt(way**2 + CREEP**2))
            out.append((sp.kron(shapes[0][1:] - shapes[0][:-1], pick * free.size[a], format="csr"), pull, way))
        return out

    def _program(
        self, h: sp.spmatrix, gradient: Floats, joints: sp.spmatrix, *, whole: Floats, commands: Floats
    ) -> Floats | None:
        """Minimise x h x / 2 + gradient x with bounds of ways, joint limits, and of the axes."""
        cost, free, part, width = self.cost, self.cost.free, self.part, whole.shape[1]
        way, robot = moves(commands), cost.arm.bounds.robot
        most = np.maximum(cost.allowed[self.keys.start : self.keys.stop - 1], np.abs(way))
        near = cost.arm.within(commands)
        limits = np.minimum(robot.lower - near, 0.0), np.maximum(robot.upper - near, 0.0)
        rows, low = [joints], [(-most - way).ravel(), limits[0].ravel()]
        high = [(most - way).ravel(), limits[1].ravel()]
        for matrix, edge in ((self.basis.first, free.speed), (self.basis.second, free.acceleration)):
            now = matrix @ whole
            rows.append(sp.kron(matrix[:, part], sp.eye(width)))
            low.append(np.minimum(-edge - now, 0.0).ravel())
            high.append(np.maximum(edge - now, 0.0).ravel())
        trust = np.where(free.moving, TRUST / free.size, 0.0)
        least = np.minimum(np.maximum(free.low - whole[part], -trust), 0.0)
        greatest = np.maximum(np.minimum(free.high - whole[part], trust), 0.0)
        least[: self.held] = greatest[: self.held] = 0.0
        bounds = least.ravel(), greatest.ravel()
        lows, highs = np.concatenate(low), np.concatenate(high)
        found = program(h, gradient, sp.vstack(rows), low=lows, high=highs, bounds=bounds)
        return None if found is None else np.clip(found, *bounds).reshape(-1, width)


def _by_key(g: Floats, shape: sp.csr_matrix) -> sp.csr_matrix:
    """(K r, m A) of derivatives (K, r, A) by places, whose curves are ``shape`` (K, m)."""
    count, r, width = g.shape
    row = np.repeat(np.arange(count * r), width)
    column = (width * np.arange(count)[:, None, None] + np.arange(width) + np.zeros((1, r, 1), dtype=int)).ravel()
    by_place = sp.csr_matrix((g.ravel(), (row, column)), shape=(count * r, width * count))
    return (by_place @ sp.kron(shape, sp.eye(width), format="csr")).tocsr()

