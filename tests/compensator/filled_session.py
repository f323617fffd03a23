"""The readings of a planned session: the plant is driven to the set-ups that `plan --program` wrote, and read there."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from tests.compensator.plant_bench import robot_file
from tests.compensator.small_job import ABB
from tests.plant import Arm, Plant, Tool
from tests.plant.lab import Form, Noise, Setup, Step, Target, measure

LOAD = ("fx", "fy", "fz", "mx", "my", "mz")


def rows_of(file: Path) -> list[dict[str, str]]:
    """Rows of a csv with a header."""
    with file.open(newline="") as stream:
        return list(csv.DictReader(stream))


def fill_in(day: Path, stiffness: Sequence[float]) -> None:
    """Put places and loads into ``day``/samples.csv, as an arm with the tool of the small job shows them.

    Args:
        stiffness: (6,) N*m/rad.
    """
    rows = rows_of(day / "samples.csv")
    session = tomllib.loads((day / "session.toml").read_text())
    held = Tool(np.array([0.03, -0.02, 0.24]), np.radians([0.0, 25.0, 0.0]), 30.0, np.array([0.01, 0.0, 0.11]))
    plant = Plant(Arm.load(robot_file(ABB), tool=held), stiffness=np.array(stiffness), gravity_on=True)
    targets = [Target(name, r["link"], np.array(r["position"]) / 1e3) for name, r in session["reflectors"].items()]
    setups = [_setup(list(of)) for _, of in groupby(rows, lambda r: r["setup"])]
    read = measure(plant, setups, targets, noise=Noise(), form=Form(registered=False), seed=3).rows
    read_at = {(str(r["setup"]), str(r["state"]), r["reflector"]): r for r in read}
    with (day / "samples.csv").open("w", newline="") as stream:
        out = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        out.writeheader()
        for row in rows:
            seen = read_at[row["setup"], row["state"], row["reflector"]]
            out.writerow({**row, **{key: seen[key] for key in ("x", "y", "z", *LOAD)}})


def _setup(rows: Sequence[dict[str, str]]) -> Setup:
    q = np.radians([float(rows[0][f"q{k}"]) for k in range(1, 7)])
    side = np.array([float(rows[0][f"approach{k}"]) for k in range(1, 7)])
    loads = [[float(r[key]) for key in LOAD] for r in rows if r["reflector"] == "tcp"]
    return Setup(q, np.radians(3.0) * side, [Step(w[:3], w[3:]) for w in loads])
