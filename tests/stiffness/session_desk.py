"""A lab with a UR10 on the plant: its sessions, and rows of samples.csv that a test can spoil."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from stiffness.session.session import Session, load_session
from tests.plant import Arm, Plant, Tool, lab
from tests.plant.lab_design import random_setups

ROBOT = Path(__file__).parents[2] / "stiffness/robot/data/ur10.toml"
TOOL = Tool((0.03, -0.05, 0.15), (0.3, -0.4, 0.5), mass=2.5, com=(0.01, 0.0, 0.06))
QUIET = lab.Noise(tracker=1e-9, force=0.0, torque=0.0)
TARGETS = (
    lab.Target("tcp", 6, TOOL.xyz),
    lab.Target("elbow", 3, (0.2, 0.06, 0.05)),
    lab.Target("side", 6, (0.08, 0.04, 0.02), exact=False),
)


def ur10() -> Plant:
    return Plant(Arm.load(ROBOT, tool=TOOL), stiffness=[5e4, 5e4, 3e4, 1e4, 1e4, 8e3], gap=4e-5)


def write(folder: Path, **more: Any) -> tuple[Session, lab.Notes]:
    """A session of the plant, read back."""
    design = {"count": 4, "seed": 1, "force": 60.0, **more.pop("design", {})}
    given: dict[str, Any] = {"noise": QUIET, "seed": 2, **more}
    notes = lab.measure(ur10(), random_setups(Arm.load(ROBOT, tool=TOOL), **design), TARGETS, **given)
    return load_session(notes.write(folder, "ur10")), notes


class Rows:
    """samples.csv as rows that a test can spoil."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with (folder / "samples.csv").open(encoding="utf-8") as file:
            self.order: list[dict[str, str]] = list(csv.DictReader(file))

    def write(self) -> Path:
        with (self.folder / "samples.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(self.order[0]))
            writer.writeheader()
            writer.writerows(self.order)
        return self.folder / "session.toml"
