"""How much an ailment changes what the instruments show, and the factor that makes it so much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from .ailment import Ailment
from .cell_design import NOISE, Cell
from .geometry import Array
from .lab import Truth, measure
from .lab_request import Form, Noise, Setup, Step
from .wear import Wear
from .worn_plant import WornPlant

QUIET = Noise(0.0, 0.0, 0.0, 0.0)
CLOSE = 0.01  # relative, of the size asked for


@dataclass(frozen=True)
class Bench:
    """One session's design, to be measured without noise."""

    cell: Cell
    setups: Sequence[Setup]
    form: Form

    def shown(self, wear: Wear) -> Array:
        """(N,3) m: what the tracker shows of this cell, less what a bent force sensor would lead one to expect."""
        plant, targets = WornPlant(self.cell.arm, wear), self.cell.targets
        notes = measure(plant, self.setups, targets, noise=QUIET, form=self.form, tracker=wear.tracker)
        seen = np.array([[row[c] for c in "xyz"] for row in notes.rows], dtype=float) * 1e-3
        if wear.sensor is not None:
            seen -= self._misled(wear, notes.truth)
        return seen

    def _misled(self, wear: Wear, truth: Truth) -> Array:
        """(N,3) m: healthy positions under the wrench that the sensor shows, minus those under the true one."""
        plant = WornPlant(self.cell.arm, self.cell.healthy)
        wrong = measure(plant, told(self.setups, wear, truth), self.cell.targets, noise=QUIET, form=self.form)
        right = measure(plant, self.setups, self.cell.targets, noise=QUIET, form=self.form)
        return wrong.truth.position - right.truth.position

    def change(self, wear: Wear) -> float:
        """m, RMS per axis, against the healthy cell."""
        return rms(self.shown(wear) - self.shown(self.cell.healthy))

    @cached_property
    def shares(self) -> Array:
        """(3N,n): what one more per cent of each joint's compliance does to the healthy readings, orthonormal."""
        still = self.shown(self.cell.healthy)
        columns = []
        for k in range(self.cell.arm.n):
            stiffness = np.array(self.cell.stiffness)
            stiffness[k] /= 1.01
            columns.append((self.shown(Wear.healthy(stiffness)) - still).ravel())
        return np.array(np.linalg.qr(np.array(columns).T)[0])

    def left(self, change: Array) -> Array:
        """(N,3) m: a change of the readings less what joint stiffnesses can take of it."""
        flat = change.ravel()
        return (flat - self.shares @ (self.shares.T @ flat)).reshape(change.shape)

    def floor(self) -> float:
        """m, RMS per axis: tracker noise, and what the noise of the force sensor makes of a prediction."""
        plant = WornPlant(self.cell.arm, self.cell.healthy)
        rng = np.random.default_rng(0)

        def jitter(step: Step) -> Step:
            force, moment = rng.normal(scale=NOISE.force, size=3), rng.normal(scale=NOISE.torque, size=3)
            return replace(step, force=step.force + force, moment=step.moment + moment)

        noisy = [replace(s, steps=tuple(jitter(step) for step in s.steps)) for s in self.setups]
        off = [
            measure(plant, s, self.cell.targets, noise=QUIET, form=self.form).truth.position
            for s in (noisy, self.setups)
        ]
        return float(np.hypot(NOISE.tracker, rms(off[0] - off[1])))


def rms(values: Array) -> float:
    """Root mean square of all numbers."""
    return float(np.sqrt(np.mean(values**2)))


def told(setups: Sequence[Setup], wear: Wear, truth: Truth) -> list[Setup]:
    """The set-ups with the loads that a bent sensor shows, turned into base axes."""
    if wear.sensor is None:
        return list(setups)
    out, row = [], 0
    for setup in setups:
        row += 1  # the move
        steps = []
        for step in setup.steps:
            R = truth.walk.tcp[row, :3, :3]
            row += 1
            local = np.concatenate([R.T @ np.asarray(step.force), R.T @ np.asarray(step.moment)])
            shown = wear.sensor.shown(local)
            steps.append(replace(step, force=R @ shown[:3], moment=R @ shown[3:]))
        out.append(replace(setup, steps=tuple(steps)))
    return out


def factor(
    bench: Bench, ailment: Ailment, wanted: float, of: Literal["change", "left"] = "change"
) -> tuple[float, float, float]:
    """The factor that changes the readings by `wanted` m (RMS per axis), the change that it makes, and what is left
    of that beyond joint stiffnesses. of: which of the two is `wanted`.

    Guesses in proportion, kept inside what is known to be too little and too much; a factor that an ailment
    refuses is too much.
    """
    if wanted == 0:
        return 0.0, 0.0, 0.0
    healthy = bench.shown(bench.cell.healthy)
    low, high, s, made, change = 0.0, np.inf, ailment.start, 0.0, np.zeros_like(healthy)
    for _ in range(30):
        try:
            wear, _ = ailment.apply(bench.cell.healthy, bench.cell.arm, s)
            change = bench.shown(wear) - healthy
            made = rms(change if of == "change" else bench.left(change))
        except ValueError:
            made = np.inf
        if abs(made / wanted - 1) < CLOSE:
            return s, rms(change), rms(bench.left(change))
        low, high = (s, high) if made < wanted else (low, s)
        guess = s * wanted / made if 0 < made < np.inf else np.nan
        middle = (low + high) / 2 if high < np.inf else 3 * s
        s = guess if low < guess < min(high, 30 * s) else middle
    where = f"{ailment.effect} at {', '.join(ailment.where)} on {bench.cell.name}"
    raise ValueError(f"{where}: {wanted * 1e6:.0f} um not reached, {made * 1e6:.0f} um at {s:.3g}")
