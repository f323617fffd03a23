"""A laboratory with a choice: any arm, stiffness, gaps, softer flanks, lever of the loads."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path

import numpy as np

from stiffness.session.session import Session, load_session
from tests.plant import Arm, Plant, Tool
from tests.plant.lab import Form, Noise, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import FORCE, STIFFNESS

KUKA = "kuka-kr210-r2700"
ALL_STIFFNESS = STIFFNESS | {KUKA: [2.4e6, 2.1e6, 1.5e6, 3.1e5, 1.1e5, 5.2e4]}
ALL_FORCE = FORCE | {KUKA: 900.0}


@dataclass(frozen=True)
class WornLab:
    """``gap`` rad and ``ratio`` per joint; ``lever`` m: how far off the TCP loads pull; reflectors on an outrigger."""

    robot: str
    gap: tuple[float, ...] | None = None
    ratio: tuple[float, ...] | None = None
    lever: float = 0.1
    form: Form = field(default_factory=Form)

    @property
    def stiffness(self) -> np.ndarray:
        return np.array(ALL_STIFFNESS[self.robot])

    def plant(self) -> Plant:
        file = Path(str(resources.files("stiffness") / "robot" / "data" / f"{self.robot}.toml"))
        held = Tool(np.array([0.02, -0.01, 0.25]), np.zeros(3), 5.0, np.array([0.01, 0.0, 0.12]))
        slack = None if self.gap is None else np.zeros(6)
        return Plant(
            Arm.load(file, tool=held), stiffness=self.stiffness, gap=self.gap, ratio=self.ratio, breakaway=slack
        )

    def session(
        self, folder: Path, seed: int, setups: int, *, levels: tuple[float, ...] = (0.4, 1.0), directions: int = 2
    ) -> Session:
        plant = self.plant()
        targets = [
            Target("tcp", 6, np.array([0.02, -0.01, 0.25])),
            Target("outrigger", 6, np.array([0.05, 0.45, 0.2])),
            Target("elbow", 3, np.array([0.1, 0.1, 0.1])),
        ]
        plan = random_setups(
            plant.arm, setups, seed, force=ALL_FORCE[self.robot], lever=self.lever, levels=levels, directions=directions
        )
        notes = measure(plant, plan, targets, noise=Noise(), form=self.form, seed=seed + 1000)
        return load_session(notes.write(folder, self.robot))
