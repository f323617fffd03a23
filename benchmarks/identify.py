"""Seconds to identify a model, and how they grow with the readings.

Sessions are made here from the product's own statics with noise: what a fit finds is a matter of the tests.
"""

from __future__ import annotations

import csv
import statistics
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from benchmarks.table import Row
from benchmarks.timing import interleaved, on_cores
from stiffness.effects import CATALOGUE
from stiffness.identification.prediction import SessionPredictor
from stiffness.identification.session_data import SessionData
from stiffness.identification.unknowns import unknowns
from stiffness.identify import identify
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.session.session import Session, load_session

Floats = npt.NDArray[np.float64]

SIZES = (1_000, 3_000, 10_000)
ROUNDS = 3
STIFFNESS = np.array([2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4])
TRACKER, FORCE, TORQUE = 2e-5, 0.3, 0.1  # m, N, N*m
NOTHING: Mapping[str, Mapping[str, Floats]] = {}
_ABB = "abb-irb6600-175-255"
_STATES = 5
_REFLECTORS = {"tcp": (6, [0.02, -0.01, 0.25]), "side": (6, [0.15, 0.0, 0.2]), "elbow": (3, [0.1, 0.1, 0.1])}
_HEADER = """schema = "measurement-session/1"
robot = "abb-irb6600-175-255"
samples = "samples.csv"
gravity = "uncompensated"
[units]
length = "m"
angle = "rad"
[wrench]
frame = "base"
about = "tcp"
[tool]
xyz = [0.02, -0.01, 0.25]
rpy = [0.0, 0.0, 0.0]
mass = 5.0
com = [0.01, 0.0, 0.12]
[reflectors.tcp]
link = 6
position = [0.02, -0.01, 0.25]
[reflectors.side]
link = 6
position = [0.15, 0.0, 0.2]
[reflectors.elbow]
link = 3
position = [0.1, 0.1, 0.1]
[instruments]
tracker = 2e-5
force = 0.3
torque = 0.1
"""


def run(sizes: tuple[int, ...] = SIZES, rounds: int = ROUNDS) -> Iterator[Row]:
    """Joint springs alone, and the default: springs, kinematics, gap and softer flank tried."""
    group = "identify (abb-irb6600-175-255; three reflectors, five states; two cores; kernels built anew)"
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        sessions = {size: session(Path(name), size) for size in sizes}
    tasks = {}
    for size, given in sessions.items():
        for what, effects in (("joint stiffness", ["joint-stiffness"]), ("default effects", None)):
            tasks[f"{what}, {size:,} readings"] = on_cores(2, lambda g=given, e=effects: identify([g], e))  # type: ignore[misc]
    for what, times in interleaved(tasks, rounds).items():
        yield Row(group, what, statistics.median(times), "s", "under 10 s" if "10,000" in what else "")


def session(
    folder: Path, readings: int, seed: int = 1, *, ill: Mapping[str, Mapping[str, Floats]] = NOTHING
) -> Session:
    """A session of about so many readings, by the product's own statics, with noise of tracker and sensor.

    Args:
        ill: effects beside the joint springs, with their values.
    """
    rng = np.random.default_rng(seed)
    robot = load_robot(_ABB)
    setups = -(-readings // (_STATES * len(_REFLECTORS)))
    low, high = np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0)
    rows: list[dict[str, object]] = []
    for k in range(setups):
        q = rng.uniform(low, high)
        approach = rng.choice([-1, 1], robot.n)
        for state in range(_STATES):
            size = np.array([800.0] * 3 + [80.0] * 3) * (0, 0.4, 1.0, 0.4, 1.0)[state]
            wrench = size * rng.uniform(-1, 1, 6)
            rows += [_row(robot, k, state, name, q, approach, wrench) for name in _REFLECTORS]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "session.toml").write_text(_HEADER, encoding="utf-8")
    with (folder / "samples.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return _read(load_session(folder / "session.toml"), rng, ill)


def _row(
    robot: Robot, setup: int, state: int, reflector: str, q: Floats, approach: Floats, wrench: Floats
) -> dict[str, object]:
    link, at = _REFLECTORS[reflector]
    pose = np.eye(4)
    for before, axis, angle, after in list(zip(robot.before, robot.axis, q, robot.after, strict=True))[:link]:
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(axis * angle).as_matrix()
        pose = pose @ before @ turn @ after
    row: dict[str, object] = {"setup": setup + 1, "state": state, "reflector": reflector}
    row |= {f"q{k + 1}": float(v) for k, v in enumerate(q)}
    row |= {f"approach{k + 1}": int(v) for k, v in enumerate(approach)}
    row |= dict(zip("xyz", (pose @ np.append(at, 1.0))[:3].tolist(), strict=True))
    return row | dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), wrench.tolist(), strict=True))


def _read(rigid: Session, rng: np.random.Generator, ill: Mapping[str, Mapping[str, Floats]]) -> Session:
    """The rigid session as instruments would show the elastic arm."""
    fixed = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}, **ill}
    nothing_free = unknowns([e for e in CATALOGUE if e.name in fixed], rigid.robot.n, list(fixed))
    data = SessionData.of(rigid)
    arm = SessionPredictor.of(data, nothing_free, fixed)
    true = arm.predict(arm.first_state(), np.zeros(0), np.zeros(data.station.size)).position
    load = rigid.samples.load
    sensed = load.wrench + rng.normal(scale=[FORCE] * 3 + [TORQUE] * 3, size=load.wrench.shape)
    position = true + rng.normal(scale=TRACKER, size=true.shape)
    return replace(rigid, samples=replace(rigid.samples, position=position, load=replace(load, wrench=sensed)))
