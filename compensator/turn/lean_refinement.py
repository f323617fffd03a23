"""The refinement of turn and lean: sequential quadratic programs in windows that overlap, three numbers per key.

As in ``refinement``: Gauss-Newton steps, travel in place of crossings. A step is taken where every key of it is free
and within the cone; joint limits and the ways from key to key are bounds of the program. Long runs of joints go on in
their direction: travel is cheap in them, and with three numbers per key they would be cut up by small ways back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from compensator.path.lean import within_cone
from compensator.turn.lean_cost import LeanCost
from compensator.turn.turn_cost import ENDLESS
from compensator.turn.turn_kinematics import moves
from compensator.turn.windows import (
    DAMPING,
    STILL,
    Refined,
    descended,
    minimised,
    refined_in_windows,
    smooth_weights,
    travelled,
)

Floats = npt.NDArray[np.float64]

STEPS = 8
TRUST = np.radians([10.0, 2.0, 2.0])  # of a step
ONWARDS = STILL  # rad: of each way of a long run, so that rounding does not turn it back
UPRIGHT = np.radians(0.01)  # leans below it are priced as their squares


def refined_lean(cost: LeanCost, state: Floats, allowed: Floats) -> Refined:
    """States that cost less than ``state`` (K, 3) rad, which is free, or the same.

    Args:
        allowed: (K - 1, n) rad that each joint may go from key to key.
    """
    price, runs = cost.travel(state)

    def solve(part: slice, held: int, now: Floats) -> Floats | None:
        ways = slice(part.start, part.stop - 1)
        return _Window(cost, part, held, price=price[ways], runs=runs[ways], allowed=allowed[ways]).solved(now)

    return refined_in_windows(state, solve)


@dataclass(frozen=True, eq=False)
class _Window:
    """Some keys: ``held`` of the first ones stay; ``price`` (m - 1, n) m3/rad, directions of ``runs`` that stay, and
    ``allowed`` rad of the ways."""

    cost: LeanCost
    part: slice
    held: int
    price: Floats
    runs: Floats
    allowed: Floats

    def solved(self, state: Floats) -> Floats | None:
        """(m, 3) rad; None where a program failed."""
        return descended(state, size=self._size, step=self._step, moved=self._moved, steps=STEPS)

    def _moved(self, state: Floats, step: Floats) -> Floats:
        out = state + step
        leans = np.any(step[:, 1:], axis=1, keepdims=True)
        out[:, 1:] = np.where(leans, within_cone(out[:, 1:], self.cost.room.cone), out[:, 1:])
        return out

    def _size(self, state: Floats) -> float:
        """m3, the smooth cost that steps make smaller; infinite where a key is not free."""
        if not self.cost.free(state, self.part).all():
            return np.inf
        at = self.cost.postures(state, self.part)
        way, (weight, rough, before, after) = moves(at.commands), smooth_weights(self.cost.motion, self.part)
        bent = (after * way[1:] - before * way[:-1]) / self.cost.acceleration
        own = weight * (at.sd**2 + self.cost.price(state))
        return float(np.sum(own) + travelled(self.price, way) + np.sum(rough * bent**2))

    def _step(self, state: Floats) -> Floats | None:
        """(m, 3) rad that minimises the quadratic model; None where the program failed."""
        at, g, slope = self.cost.slopes(state, self.part)
        m, n = len(state), g.shape[1]
        way, (weight, rough, before, after) = moves(at.commands), smooth_weights(self.cost.motion, self.part)
        own, joints = _blocks(slope[:, None]), _blocks(g)
        ways = _difference(m, n) @ joints
        ends = sp.csr_matrix(bend(before, after, self.cost.acceleration, n))
        bent = (after * way[1:] - before * way[:-1]) / self.cost.acceleration
        rows = (
            (own, weight, at.sd),
            (ways, self.price.ravel() / (2 * np.sqrt(way**2 + STILL**2).ravel()), way.ravel()),
            (ends @ ways, np.broadcast_to(rough, bent.shape).ravel(), bent.ravel()),
        )
        h = sum(2 * (j.T @ sp.diags(w) @ j) for j, w, _ in rows)
        gradient = np.sum([2 * (j.T @ (w * r)) for j, w, r in rows], axis=0)
        curved, pull = self._leaning(state, weight)
        gradient, h = gradient + pull, h + sp.diags(curved)
        scale = float(h.diagonal().max())
        if scale == 0.0:
            return np.zeros_like(state)
        h = (h + DAMPING * scale * sp.eye(3 * m)) / scale
        return self._program(h, gradient / scale, sp.vstack([ways, joints]), state=state, commands=at.commands)

    def _leaning(self, state: Floats, weight: Floats) -> tuple[Floats, Floats]:
        """Curvature and gradient (3 m,) of the price of leaning."""
        lean = state[:, 1:]
        each = weight * self.cost.price(np.array([[0.0, self.cost.room.cone, 0.0]]))[0] / self.cost.room.cone
        curved = np.zeros_like(state)
        curved[:, 1:] = (each / np.sqrt(np.sum(lean**2, axis=1) + UPRIGHT**2))[:, None]
        return curved.ravel(), (curved * state).ravel()

    def _program(
        self, h: sp.spmatrix, gradient: Floats, a: sp.spmatrix, *, state: Floats, commands: Floats
    ) -> Floats | None:
        """Minimise x h x / 2 + gradient x with bounds of ways, joint limits, cone and trust."""
        m, n = commands.shape
        solver, curvature, bounded = _solver(m, n)
        way, robot = moves(commands), self.cost.arm.bounds.robot
        most = np.maximum(self.allowed, np.abs(way))
        near = self.cost.arm.within(commands)
        back, ahead = (np.where(self.runs == sign, -ONWARDS, most) for sign in (1.0, -1.0))
        ways = np.minimum(-back, way) - way, np.maximum(ahead, way) - way
        limits = np.clip(robot.lower - near, -ENDLESS, 0.0), np.clip(robot.upper - near, 0.0, ENDLESS)
        low, high = (np.concatenate([ways[k].ravel(), limits[k].ravel()]) for k in (0, 1))
        opened = self.cost.room.open[self.part]
        edge = np.stack([np.full(m, np.inf), *(np.where(opened, self.cost.room.cone, 0.0),) * 2], axis=1)
        least, greatest = np.maximum(-edge - state, -TRUST), np.minimum(edge - state, TRUST)
        least[: self.held] = greatest[: self.held] = 0.0
        least, greatest = np.minimum(least, 0.0), np.maximum(greatest, 0.0)
        x = minimised(
            solver, h=curvature.filled(h), a=bounded.filled(a), g=gradient, lba=low, uba=high,
            lbx=least.ravel(), ubx=greatest.ravel(),
        )  # fmt: skip
        return None if x is None else np.asarray(np.clip(x.reshape(m, 3), least, greatest))


def _blocks(g: Floats) -> sp.csr_matrix:
    """(m r, 3 m) with blocks (m, r, 3) along the diagonal."""
    m, r, width = g.shape
    row = np.repeat(np.arange(m * r), width)
    column = (width * np.arange(m)[:, None, None] + np.arange(width) + np.zeros((1, r, 1), dtype=int)).ravel()
    return sp.csr_matrix((g.ravel(), (row, column)), shape=(m * r, width * m))


def _difference(m: int, n: int) -> sp.csr_matrix:
    """((m - 1) n, m n): each key less the one before."""
    size = (m - 1) * n
    return sp.diags([-np.ones(size), np.ones(size)], [0, n], shape=(size, m * n), format="csr")


def bend(before: Floats, after: Floats, limit: Floats, n: int) -> sp.spmatrix:
    """((m - 2) n, (m - 1) n): shares of the ways in the accelerations, of the limits (n,)."""
    size = len(before) * n
    shares = [(-before / limit).ravel(), (after / limit).ravel()]
    return sp.diags(shares, [0, n], shape=(size, size + n), format="csr")


@dataclass(frozen=True, eq=False)
class _Pattern:
    """Where a matrix has numbers, column by column."""

    rows: npt.NDArray[np.intp]
    columns: npt.NDArray[np.intp]
    sparsity: ca.Sparsity

    @classmethod
    def of(cls, ones: sp.spmatrix) -> _Pattern:
        """Where ``ones`` is not zero."""
        found = sp.coo_matrix(ones)
        order = np.lexsort((found.row, found.col))
        rows, columns = found.row[order], found.col[order]
        height, width = ones.shape
        sparsity = ca.Sparsity.triplet(height, width, rows.tolist(), columns.tolist())
        return cls(rows, columns, sparsity)

    def filled(self, matrix: sp.spmatrix) -> ca.DM:
        """The numbers of ``matrix``, that has none elsewhere."""
        return ca.DM(self.sparsity, np.asarray(sp.csr_matrix(matrix)[self.rows, self.columns]).ravel())


@lru_cache(maxsize=8)
def _solver(m: int, n: int) -> tuple[ca.Function, _Pattern, _Pattern]:
    """PIQP for m keys and n joints, and the patterns of its matrices."""
    ones = _blocks(np.ones((m, n, 3)))
    limits = _Pattern.of(sp.vstack([abs(_difference(m, n)) @ ones, ones]))
    band = sp.diags([np.ones(m)] * 5, [-2, -1, 0, 1, 2], shape=(m, m))
    curvature = _Pattern.of(sp.kron(band, np.ones((3, 3))))
    shapes = {"h": curvature.sparsity, "a": limits.sparsity}
    return ca.conic("window", "piqp", shapes, {"error_on_fail": False}), curvature, limits
