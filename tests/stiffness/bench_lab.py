"""A laboratory for identification: the plant, its reflectors, and sessions written to a folder."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from stiffness.session.session import Session, load_session
from tests.plant import Arm, Plant, Tool
from tests.plant.lab import Form, Noise, Target, measure
from tests.plant.lab_design import random_setups

STIFFNESS = {
    "abb-irb6600-175-255": [2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4],
    "ur10": [6.0e4, 5.5e4, 4.0e4, 1.2e4, 1.1e4, 0.9e4],
}
FORCE = {"abb-irb6600-175-255": 800.0, "ur10": 60.0}


@dataclass(frozen=True)
class Lab:
    """A robot of the project on the plant; ``gap`` in rad, decided by torque above ``breakaway`` (N*m)."""

    robot: str = "abb-irb6600-175-255"
    gap: tuple[float, ...] | None = None
    breakaway: float = 0.0

    @property
    def stiffness(self) -> np.ndarray:
        return np.array(STIFFNESS[self.robot])

    def plant(self) -> Plant:
        file = Path(str(resources.files("stiffness") / "robot" / "data" / f"{self.robot}.toml"))
        held = Tool(np.array([0.02, -0.01, 0.25]), np.zeros(3), 5.0, np.array([0.01, 0.0, 0.12]))
        arm = Arm.load(file, tool=held)
        gap = None if self.gap is None else np.array(self.gap)
        slack = None if gap is None else np.full(6, self.breakaway)
        return Plant(arm, stiffness=self.stiffness, gap=gap, breakaway=slack, gravity_on=True)

    def session(
        self,
        folder: Path,
        seed: int,
        *,
        setups: int = 30,
        noise: Noise | None = None,
        form: Form | None = None,
        levels: tuple[float, ...] = (0.4, 1.0),
    ) -> tuple[Session, list[int]]:
        """A session of random set-ups, and the lines of samples.csv that were made wrong."""
        plant = self.plant()
        targets = [
            Target("tcp", 6, np.array([0.02, -0.01, 0.25])),
            Target("side", 6, np.array([0.15, 0.0, 0.2])),
            Target("elbow", 3, np.array([0.1, 0.1, 0.1])),
        ]
        plan = random_setups(plant.arm, setups, seed, force=FORCE[self.robot], levels=levels)
        notes = measure(plant, plan, targets, noise=noise or Noise(), form=form or Form(), seed=seed + 1000)
        return load_session(notes.write(folder, self.robot)), [int(k) for k in notes.truth.wrong_rows]
