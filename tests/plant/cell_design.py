"""Three cells as a lab would set them up: arm, springs, reflectors, set-ups, and the form of their sessions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from .ailments_instrument import DAY
from .arm import Arm, Tool
from .lab_design import random_setups
from .lab_request import Form, Noise, Setup, Step, Target
from .wear import Wear

ROBOTS = Path(__file__).parents[2] / "stiffness" / "robot" / "data"  # data files, read by the plant's own reader
TCP = (0.02, -0.01, 0.25)
NOISE = Noise(tracker=2e-5, force=0.3, torque=0.1)
ORDERS = (  # (direction, level) of the states after state 0; no direction: unloaded
    ((0, 0.5), (0, 1.0), (0, 0.5), (0, 0.0)),
    ((0, 0.5), (0, 1.0), (1, 0.5), (1, 1.0)),
    ((0, 1.0), (0, 0.5), (1, 1.0), (2, 1.0)),
)


@dataclass(frozen=True)
class Cell:
    """A robot by name, its springs, and the loads that it is tried with."""

    name: str
    stiffness: tuple[float, ...]  # N*m/rad
    force: float  # N
    lever: float  # m, how far off the TCP a load pulls, along each axis
    upper: int  # the link of the second reflector from the ground
    frame: str  # of the wrench columns

    @property
    def arm(self) -> Arm:
        """The arm of the file with the sensor and tool of the lab."""
        return _load(self.name)

    @property
    def healthy(self) -> Wear:
        """Joint springs and nothing else."""
        return Wear.healthy(np.array(self.stiffness))

    @property
    def targets(self) -> list[Target]:
        """tcp and outrigger on the flange, one each on forearm, carousel or upper arm, and pedestal."""
        return [
            Target("tcp", 6, TCP),
            Target("outrigger", 6, (0.05, 0.45, 0.2)),
            Target("forearm", 3, (0.1, 0.1, 0.1)),
            Target("upper", self.upper, (-0.1, 0.12, 0.15)),
            Target("pedestal", 0, (0.25, 0.2, 0.05)),
        ]


CELLS = {
    cell.name: cell
    for cell in (
        Cell("abb-irb6600-175-255", (2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4), 800.0, 0.3, 2, "tool"),
        Cell("ur10", (6.0e4, 5.5e4, 4.0e4, 1.2e4, 1.1e4, 0.9e4), 60.0, 0.25, 1, "base"),
        Cell("kuka-kr210-r2700", (2.4e6, 2.1e6, 1.5e6, 3.1e5, 1.1e5, 5.2e4), 900.0, 0.3, 2, "tool"),
    )
}


@cache
def _load(name: str) -> Arm:
    held = Tool(TCP, (0.0, 0.0, 0.0), 5.0, (0.01, 0.0, 0.12))
    return Arm.load(ROBOTS / f"{name}.toml", tool=held)


def design(cell: Cell, setups: int, seed: int) -> list[Setup]:
    """Random postures and approaches; loads at a lever, two levels, one to three directions, some unloaded again."""
    rng = np.random.default_rng([seed, 77])
    return [
        replace(setup, steps=(Step(), *_loads(cell, rng, ORDERS[i % len(ORDERS)])))
        for i, setup in enumerate(random_setups(cell.arm, setups, seed, directions=0))
    ]


def _loads(cell: Cell, rng: np.random.Generator, order: Sequence[tuple[int, float]]) -> list[Step]:
    ways = rng.normal(size=(3, 3))
    ways *= cell.force / np.linalg.norm(ways, axis=1, keepdims=True)
    arms = rng.uniform(-cell.lever, cell.lever, (3, 3))
    return [Step(level * ways[d], level * np.cross(arms[d], ways[d])) for d, level in order]


def climate(time: float) -> float:
    """Deg C of a hall that warms up and swings."""
    return round(21.0 + 6.0 * (1 - np.exp(-time / 2500.0)) + 1.5 * float(np.sin(time / 900.0)), 2)


def form(cell: Cell, setups: Sequence[Setup], seed: int) -> Form:
    """The form of a session: clock, climate, and three columns that nothing need follow."""
    rng, count = np.random.default_rng([seed, 78]), len(setups)
    again = min(8, count)
    readings = len(cell.targets) * (sum(len(s.steps) for s in setups) + again)
    extra: dict[str, list[float]] = {
        "humidity": rng.normal(45.0, 5.0, count).round(1).tolist(),
        "brake": rng.integers(0, 2, count).tolist(),
        "spindle": (6000.0 * rng.integers(0, 3, count)).tolist(),
    }
    return Form(
        frame="tool" if cell.frame == "tool" else "base",
        again=again,
        seconds=round(DAY / readings, 2),
        climate=climate,
        reference_temperature=20.0,
        extra=extra,
    )
