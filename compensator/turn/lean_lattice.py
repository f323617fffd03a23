"""The start of the choice: turn and lean along a path by dynamic programming over a lattice.

At every stage the turns are a grid, and the tool stands upright or leans with the whole cone in one of eight
directions. Between stages turn and lean are straight, so the tool stays within the cone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.turn.coarse_turn import BACK, TURNING
from compensator.turn.lean_cost import ArmRoom, LeanCost
from compensator.turn.lean_kinematics import LeanKinematics
from compensator.turn.turn_cost import LASTS

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

STAGES = 200  # keys that are decided on
TURNS = 72
FASTEST = 4  # grid steps that the turn may change by from stage to stage
STEP = 2 * np.pi / TURNS


def lattice(cone: float) -> Floats:
    """(9, 2) rad: upright, and eight directions."""
    angle = np.arange(8) * np.pi / 4
    return np.concatenate([np.zeros((1, 2)), cone * np.stack([np.cos(angle), np.sin(angle)], axis=1)])


def stages_of(count: int) -> Rows:
    """(S,) of ``count`` keys."""
    return np.unique(np.linspace(0, count - 1, min(count, STAGES)).round().astype(np.intp))


@dataclass(frozen=True, eq=False)
class LeanLattice:
    """Postures at S stages, L leans, T turns.

    Attributes:
        stages: (S,) keys. leans: (L, 2) rad.
        q: (S, L, T, n) rad. free: (S, L, T) whether the arm may be there.
    """

    stages: Rows
    leans: Floats
    q: Floats
    free: npt.NDArray[np.bool_]

    @classmethod
    def of(
        cls, kinematics: LeanKinematics, arm: ArmRoom, stages: Rows, *, cone: float, opened: npt.NDArray[np.bool_]
    ) -> LeanLattice:
        """Solved; ``opened`` (K,): keys whose tool may lean."""
        leans = lattice(cone)
        state = np.empty((len(leans), TURNS, 3))
        state[..., 0], state[..., 1:] = np.arange(TURNS) * STEP, leans[:, None]
        cells = state.reshape(-1, 3)
        q, free = [], []
        for stage in stages:
            some = np.full(len(cells), stage)
            angles, _, reach = kinematics.angles(cells, some)
            q.append(arm.within(angles))
            free.append(arm.free(angles, reach, some))
        shape = (len(stages), len(leans), TURNS)
        allowed = np.array(free).reshape(shape)
        allowed[:, 1:] &= opened[stages][:, None, None]
        return cls(stages, leans, np.array(q).reshape(*shape, -1), allowed)

    def straight(self, way: Floats, count: int) -> Floats:
        """(count, 3) rad, turn and lean at all keys, from those (S, 3) at the stages."""
        return np.stack([np.interp(np.arange(count), self.stages, column) for column in way.T], axis=1)

    def cheapest(self, price: Floats, way: Callable[[int, int], Floats]) -> Floats | None:
        """(S, 3) rad, turn (unwrapped) and lean of every stage; None where no way leads through.

        Args:
            price: (S, L, T), infinite where forbidden.
            way: stage k from 1, step s -> (L, L, T) price of going to each lean (first) and turn from each lean
                (second) of stage k - 1, s turns below.
        """
        steps, leans = np.arange(-FASTEST, FASTEST + 1), len(self.leans)
        total = price[0]
        came = np.zeros((len(price), leans, TURNS), dtype=np.intp)
        for k in range(1, len(price)):
            options = np.concatenate([np.roll(total, s, axis=1)[None] + way(k, int(s)) for s in steps], axis=1)
            came[k] = np.argmin(options, axis=1)  # (L, steps * L, T)
            total = np.take_along_axis(options, came[k][:, None], axis=1)[:, 0] + price[k]
        if not np.isfinite(total.min()):
            return None
        lean, turn = (int(v) for v in np.unravel_index(np.argmin(total), total.shape))
        out = np.empty((len(price), 3))
        for k in range(len(price) - 1, -1, -1):
            out[k] = turn * STEP, *self.leans[lean]
            step, lean = divmod(int(came[k, lean, turn % TURNS]), leans)
            turn -= int(steps[step])
        return out


def coarse_lean(cost: LeanCost, allowed: Floats) -> Floats | None:
    """(K, 3) rad, the way over the lattice that costs least; None where none leads along the path.

    Args:
        allowed: (K - 1, n) rad that each joint may go from key to key.
    """
    count = len(cost.wrench)
    stages = stages_of(count)
    grid = LeanLattice.of(cost.kinematics, cost.arm, stages, cone=cost.room.cone, opened=cost.room.open)
    sd, worth = _fields(cost, grid)
    middle = np.append(0, (stages[1:] + stages[:-1] + 1) // 2)
    weight = np.add.reduceat(cost.motion.weight, middle)
    leaning = cost.price(np.pad(grid.leans, ((0, 0), (1, 0))))
    price = np.where(grid.free, weight[:, None, None] * (sd**2 + leaning[:, None]), np.inf)
    most = np.add.reduceat(allowed, stages[:-1], axis=0)
    cut = np.logical_and.reduceat(cost.motion.cut, stages[:-1])
    worth[1:][~cut] = 0.0
    apart = bends(grid.leans)

    def way(k: int, step: int) -> Floats:
        travelled = travel(grid.q[k - 1], grid.q[k], step, most=most[k - 1], worth=worth[k][:, None])
        return travelled + TURNING * step**2 + TURNING * apart[:, :, None]

    found = grid.cheapest(price, way)
    return None if found is None else grid.straight(found, count)


def bends(leans: Floats) -> Floats:
    """(L, L) squares of the ways between leans (L, 2) rad, in steps of the turn."""
    return np.asarray(np.sum((leans[:, None] - leans[None]) ** 2, axis=2) / STEP**2)


def travel(before: Floats, after: Floats, step: int, *, most: Floats, worth: Floats | float) -> Floats:
    """(L, L, T) price of the joints' ways from (L, T, n) to (L, T, n) rad; infinite where one is too fast."""
    move = after[:, None] - np.roll(before, step, axis=1)[None]
    move = np.abs((move + np.pi) % (2 * np.pi) - np.pi)
    return np.where((move <= most).all(axis=3), np.sum(worth * move, axis=3), np.inf)


def _fields(cost: LeanCost, grid: LeanLattice) -> tuple[Floats, Floats]:
    """(S, L, T) m, standard deviation, and (S, L, T, n) price per rad of the ways of joints; 0 where not free."""
    sd, worth = np.zeros(grid.free.shape), np.zeros(grid.q.shape)
    for k, stage in enumerate(grid.stages):
        here = grid.free[k]
        if here.any():
            at = cost.at(grid.q[k][here], np.full(int(here.sum()), stage))
            sd[k][here], worth[k][here] = at.sd, (at.gap**2 + at.windup**2) * LASTS / BACK
    return sd, worth
