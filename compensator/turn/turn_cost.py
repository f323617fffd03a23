"""Turn cost: what a turn about the tool axis along a path costs, in m2, as a mean over the length of the cut.

    variance      square of the standard deviation of the deflection that the compensation relies on
    crossings     at every crossing of a gap, the square of what it moves the cutting edge by, over LASTS of path; every
                  reversal beside that as if the joint had WINDUP of lost motion, whatever the model knows of it
    acceleration  ROUGH squared where a joint accelerates with its limit at the programmed feed; the square of the share

A joint crosses its gap as far as it travels back: the play operator of the gap itself, along the corrected
commands. These are the nominal angles less what the joints give under the process.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.added_poses import sharp_corners
from compensator.path.chosen_turn import TurnValue
from compensator.path.planned_path import PlannedPath
from compensator.turn.reliance import Reliance
from compensator.turn.turn_grid import TurnGrid
from compensator.turn.turn_kinematics import TurnKinematics, moves
from stiffness.effects.effect import REVERSAL
from stiffness.effects.memory import Clamp
from stiffness.memory.clamp_scan import scan
from stiffness.memory.last_direction import last_direction
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

LASTS = 0.01  # m of the path along which a crossing leaves its error: where it falls is not known better
WINDUP = 5e-5  # rad, 10 arc seconds: a sixth of the minute that reducers have as lost motion by their catalogues
ROUGH = 3e-5  # m: what an acceleration at the limit is worth
ENDLESS = 4 * np.pi  # rad, in place of no bound: PIQP writes a line to standard error for a row without any
AIR = 0.5  # of max_joint_step: between two poses in the air


@dataclass(frozen=True, repr=False, eq=False)
class KeyMotion:
    """The way between K poses of a path, the keys.

    Attributes:
        length: (K - 1,) m; 0 where the way is not all cut.
        time: (K - 1,) s at the programmed feed; of the air: nothing is timed, 0.
        cut: (K - 1,) the way is all cut, with one tool.
        corner: (K,) at a corner of the toolpath, where every controller slows down.
        poses: (K - 1,) steps of the path in it; infinite where a joint move leads to another tool.
    """

    length: Floats
    time: Floats
    cut: Bools
    corner: Bools
    poses: Floats

    @classmethod
    def of(cls, path: PlannedPath, rows: npt.NDArray[np.intp], feed: Floats, changes: list[int]) -> KeyMotion:
        """Of the poses ``rows`` (K,); ``feed`` (N,) m/s of cuts; ``changes``: poses that another tool goes to."""
        toolpath = path.toolpath
        step = np.linalg.norm(np.diff(toolpath.on_part, axis=0), axis=1)
        cutting = (toolpath.kind[1:] == CUT) & (feed[1:] > 0)
        cutting[[k - 1 for k in changes]] = False
        time = np.divide(step, feed[1:], out=np.zeros_like(step), where=cutting)
        inside = rows[:-1]
        whole = np.logical_and.reduceat(cutting, inside)
        corner = np.zeros(len(toolpath), dtype=bool)
        corner[1:-1] = sharp_corners(toolpath)
        length, lasts = (np.where(whole, np.add.reduceat(a, inside), 0.0) for a in (step, time))
        poses = np.diff(rows).astype(float)
        poses[np.searchsorted(rows, changes) - 1] = np.inf
        return cls(length=length, time=lasts, cut=whole, corner=corner[rows], poses=poses)

    @property
    def weight(self) -> Floats:
        """(K,) m of the cut that each key stands for."""
        half = np.append(0.0, self.length) + np.append(self.length, 0.0)
        return np.asarray(half / 2)

    @property
    def smooth(self) -> Bools:
        """(K,) inside of a cut and not at a corner: accelerations count."""
        timed = self.cut & (self.time > 0)
        return np.asarray(np.append(False, timed) & np.append(timed, False) & ~self.corner)

    def allowed(self, velocity: Floats, max_joint_step: float) -> Floats:
        """(K - 1, n) rad that each joint may go on the way to the next key; ENDLESS to another tool."""
        fast = np.where(np.isnan(velocity), np.inf, velocity)
        timed = np.where(self.time[:, None] > 0, self.time[:, None] * fast, np.inf)
        most = np.minimum(0.8 * timed, AIR * max_joint_step * self.poses[:, None])
        return np.where(np.isfinite(most), most, ENDLESS)


@dataclass(frozen=True, repr=False, eq=False)
class TurnCost:
    """The cost of turns along the keys of a path.

    Attributes:
        acceleration: (n,) rad/s2, limits; infinite where not known.
        sd, give: (K, T) m and (K, T, n) rad, of the grid; where it is not free those of the nearest turn that is.
    """

    kinematics: TurnKinematics
    motion: KeyMotion
    grid: TurnGrid
    reliance: Reliance
    acceleration: Floats
    sd: Floats
    give: Floats

    @classmethod
    def of(
        cls, kinematics: TurnKinematics, motion: KeyMotion, grid: TurnGrid, found: Reliance, acceleration: Floats
    ) -> TurnCost:
        """With the gaps of ``sd`` filled."""
        limits = np.where(np.isnan(acceleration), np.inf, acceleration)
        give = np.stack([_filled(part) for part in np.moveaxis(found.give, 2, 0)], axis=2)
        return cls(kinematics, motion, grid, found, acceleration=limits, sd=_filled(found.sd), give=give)

    def deviation(self, turn: Floats, some: slice = slice(None)) -> tuple[Floats, Floats]:
        """(K,) m, the standard deviation at turns (K,) rad, and its derivative: cubics through the grid."""
        value, slope = _between(self.sd[some], *self.grid.index(turn), self.grid.step)
        return np.maximum(value, 0.0), slope

    def commands(self, turn: Floats, some: slice = slice(None)) -> tuple[Floats, Floats]:
        """(K, n) rad, corrected commands at turns (K,) rad without regard to full turns, and their derivatives."""
        q, slope = self.kinematics.angles(turn, some)
        give, more = _between(self.give[some], *self.grid.index(turn), self.grid.step)
        return q - give, slope - more

    def crossing(self, turn: Floats) -> tuple[Floats, Floats]:
        """What gaps and WINDUP move the cutting edge by where a joint reverses, (K, n) m each, at turns (K,) rad."""
        column = np.round(turn / self.grid.step).astype(np.intp) % len(self.grid.turns)
        k = np.arange(len(turn))
        gap, lever = self.reliance.crossing[k, column], self.reliance.lever[k, column]
        return np.nan_to_num(gap), np.nan_to_num(lever) * WINDUP

    def travel_price(self, turn: Floats, step: Floats) -> Floats:
        """(K - 1, n) m3 for each rad that joints travel: a crossing for each run in one direction, as long as it is.

        Args:
            step: (K - 1, n) rad, the ways of the joints at turns (K,) rad.
        """
        return priced_travel(self.motion, step, *self.crossing(turn), width=self.reliance.gap)

    def value(self, turn: Floats, q: Floats | None = None) -> TurnValue:
        """What turns (K,) rad cost; ``q``: (K, n) rad, their commands, where they are solved for."""
        q = self.commands(turn)[0] if q is None else q
        sd, _ = self.deviation(turn)
        gaps = (*self.crossing(turn), self.reliance.gap)
        return valued(self.motion, moves(q), sd, gaps=gaps, acceleration=self.acceleration)


def valued(
    motion: KeyMotion, step: Floats, sd: Floats, *, gaps: tuple[Floats, Floats, Floats], acceleration: Floats
) -> TurnValue:
    """What the ways (K - 1, n) rad between keys cost, and the standard deviation (K,) m at them.

    Args:
        gaps: (K, n) m each, what gaps and WINDUP move the cutting edge by; (n,) rad of the gaps.
        acceleration: (n,) rad/s2, limits.
    """
    weight, size = motion.weight, float(max(motion.length.sum(), 1e-9))
    rough = np.sum(weight * np.max(accelerations(step, motion) / acceleration, axis=1) ** 2)
    gap, windup, width = gaps
    steep = np.sum(crossings(step, motion.cut, width) * gap[1:] ** 2)
    turned = crossings(step, motion.cut, np.full(step.shape[1], WINDUP))
    steep += np.sum(turned * windup[1:] ** 2)
    return TurnValue(
        variance=float(np.sum(weight * sd**2)) / size,
        crossings=LASTS * float(steep) / size,
        acceleration=ROUGH**2 * float(rough) / size,
        reversals=float(turned.sum()),
        sd=float(np.sum(weight * sd)) / size,
    )


def priced_travel(motion: KeyMotion, step: Floats, gap: Floats, windup: Floats, *, width: Floats) -> Floats:
    """(K - 1, n) m3 for each rad: ``TurnCost.travel_price``, of what gaps and WINDUP move the edge by, (K, n) m."""
    longest = np.maximum(runs(step, motion.cut), WINDUP)
    price = gap[1:] ** 2 / np.maximum(longest, width) + windup[1:] ** 2 / longest
    return np.where(motion.cut[:, None], LASTS * price, 0.0)


def accelerations(step: Floats, motion: KeyMotion) -> Floats:
    """(K, n) rad/s2 from moves (K - 1, n) rad; 0 where none counts."""
    time = np.where(motion.time > 0, motion.time, 1.0)[:, None]
    out = np.zeros((len(step) + 1, step.shape[1]))
    out[1:-1] = np.diff(step / time, axis=0) / ((time[1:] + time[:-1]) / 2)
    return np.where(motion.smooth[:, None], np.abs(out), 0.0)


def crossings(step: Floats, cut: Bools, gap: Floats) -> Floats:
    """(K - 1, n) shares of its gap (n,) rad that each joint crosses on moves (K - 1, n) rad; in the cut only."""
    half = np.maximum(gap, REVERSAL) / 2
    one = np.ones_like(step)
    starts = np.zeros((1, step.shape[1]))
    state = scan(Clamp(step / half, -one, one), starts)[0]
    crossed = np.abs(np.diff(state, axis=0, prepend=starts)) / 2
    return np.where(cut[:, None] & (gap > 0), crossed, 0.0)


def runs(step: Floats, cut: Bools) -> Floats:
    """(K - 1, n) rad that a joint travels in one direction, all of the run that each way belongs to."""
    sign = last_direction(step)
    new = np.ones(sign.shape, dtype=bool)
    new[1:] = (sign[1:] != sign[:-1]) | (cut[1:] != cut[:-1])[:, None]
    out = np.empty_like(step)
    for j in range(step.shape[1]):
        begin = np.flatnonzero(new[:, j])
        length = np.abs(np.add.reduceat(step[:, j], begin))
        out[:, j] = np.repeat(length, np.diff(np.append(begin, len(step))))
    return out


def _filled(values: Floats) -> Floats:
    """(K, T) without NaN: where a turn is not free, that of the nearest."""
    out, known = values.copy(), np.isfinite(values)
    turns = values.shape[1]
    for reach in range(1, turns // 2 + 1):
        if known.all():
            break
        for shift in (reach, -reach):
            take = ~known & np.roll(np.isfinite(values), shift, axis=1)
            out[take] = np.roll(values, shift, axis=1)[take]
            known |= take
    return np.nan_to_num(out)


def _between(
    values: Floats, below: npt.NDArray[np.intp], share: Floats, step: float
) -> tuple[Floats, Floats]:
    """(K, ...) of periodic cubics (Catmull and Rom) along rows of ``values`` (K, T, ...), and their derivatives."""
    k, turns = np.arange(len(values)), values.shape[1]
    share = share.reshape(-1, *(1,) * (values.ndim - 2))
    a, b, c, d = (values[k, (below + o) % turns] for o in (-1, 0, 1, 2))
    slope_b, slope_c = (c - a) / 2, (d - b) / 2
    two, three = 2 * (b - c) + slope_b + slope_c, 3 * (c - b) - 2 * slope_b - slope_c
    value = b + share * (slope_b + share * (three + share * two))
    return value, (slope_b + share * (2 * three + 3 * share * two)) / step
