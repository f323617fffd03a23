"""The lab's force sensor: the wrench of a load in the axes and about the point that the session file names."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .arm import Arm
from .geometry import Array
from .instruments import Crooked
from .lab_request import Form, Noise, Setup, Step, Target
from .walk import Walk

FORCES = ("fx", "fy", "fz", "mx", "my", "mz")
Key = tuple[int, int, int, int]  # set-up, state, repeat, target: all counted from 0


class Sensor:
    """Tared: it shows neither tool nor payload."""

    def __init__(
        self,
        arm: Arm,
        setups: Sequence[Setup],
        targets: Sequence[Target],
        noise: Noise,
        form: Form,
        walk: Walk,
        rng: np.random.Generator,
        crooked: Crooked | None = None,
    ) -> None:
        self.arm, self.setups, self.noise, self.form, self.walk, self.rng = arm, setups, noise, form, walk, rng
        self.targets, self.crooked = {t.name: t for t in targets}, crooked
        self.pulls = any(step.pull for setup in setups for step in setup.steps)
        self.last: tuple[tuple[int, int, int], Array] | None = None

    def columns(self, key: Key, row: int) -> tuple[Array, Array, dict[str, object]]:
        """The true wrench (6,), base axes; the point (3,) it is about; the cells of the wrench columns."""
        step = self.setups[key[0]].steps[key[1]]
        f, m = np.array(step.force, dtype=float), np.array(step.moment, dtype=float)
        flange = self.walk.links[row][self.arm.n]
        tcp = flange @ self.arm.tool.pose
        point = tcp[:3, 3]
        if step.pull is not None:
            target = self.targets[step.pull]
            point = (self.walk.links[row][target.link] @ np.append(target.at, 1.0))[:3]
        true = np.concatenate([f, m])
        if not self.form.wrench:
            return true, point, {}
        if self.crooked is not None and step.pull is None:
            R = tcp[:3, :3]
            seen = self.crooked.shown(np.concatenate([R.T @ f, R.T @ m]))
            f, m = R @ seen[:3], R @ seen[3:]
        named = step.pull is not None and self.form.load_columns
        about = {"tcp": tcp[:3, 3], "flange": flange[:3, 3], "base": np.zeros(3)}[self.form.about]
        m = m + np.cross(point - (point if named else about), f)
        axes = tcp[:3, :3] if self.form.frame == "tool" else np.eye(3)
        shown = np.concatenate([axes.T @ f, axes.T @ m]) + self._noise(key)
        cells: dict[str, object] = dict(zip(FORCES, shown.tolist(), strict=True))
        return true, point, cells | self._place(step)

    def _place(self, step: Step) -> dict[str, object]:
        """Cells of load_link and load_at."""
        if step.pull is not None and not self.form.load_columns and self.targets[step.pull].link != self.arm.n:
            raise ValueError(f"the pull at {step.pull} is not on the flange: it needs load columns")
        if not self.pulls or not self.form.load_columns:
            return {}
        if step.pull is None:
            return {"load_link": "", "load_at": ""}
        return {"load_link": self.targets[step.pull].link, "load_at": step.pull}

    def _noise(self, key: Key) -> Array:
        scale = [self.noise.force] * 3 + [self.noise.torque] * 3
        if self.form.sensed == "row":
            return np.array(self.rng.normal(scale=scale))
        if self.last is None or self.last[0] != key[:3]:
            self.last = (key[:3], np.array(self.rng.normal(scale=scale)))
        return self.last[1]
