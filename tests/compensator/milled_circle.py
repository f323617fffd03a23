"""The milled circle on a plant with joint play: uncompensated, for stiffness only, for both."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.compensator.plant_bench import MM, Bench, Table
from tests.plant import Memory, Walk
from tests.plant.geometry import Array

ROBOT = "abb-irb6600-175-255"
RADIUS = 125.0  # mm
GAP = [2.0e-4, 1.5e-4, 1.5e-4, 3.0e-4, 3.0e-4, 3.0e-4]  # rad: 0.5 to 1 arcmin
BREAKAWAY = [4000.0, 50.0, 50.0, 800.0, 800.0, 800.0]  # N*m: gravity holds joints 2 and 3, the motion decides
MODEL: dict[str, dict[str, Any]] = {
    "joint-stiffness": {"k_nm_per_rad": [2.0e6, 1.774e6, 1.378e6, 2.82e5, 1.5e5, 6.0e4]},
    "backlash": {"gap_rad": GAP, "breakaway_nm": BREAKAWAY, "side": [1.0] * 6},
}
GCODE = f"""%
(full circle, diameter {2 * RADIUS:g} mm, counter-clockwise)
G90 G94 G17 G21 G54
T1 M6
S9000 M3
G0 X{RADIUS + 30:g} Y-30 Z40
G0 X{RADIUS:g} Y-30
G1 Z0 F1500
G1 X{RADIUS:g} Y0 F900
G3 X{-RADIUS:g} Y0 I{-RADIUS:g} J0
G3 X{RADIUS:g} Y0 R{RADIUS:g}
G1 Y30
G0 Z40
M5
M30
%
"""


def bench(folder: Path, side: float) -> Bench:
    """The cell of the circle; side +1: the link rests where it turned to (paper), -1: it lags (textbook)."""
    model = {**MODEL, "backlash": {**MODEL["backlash"], "side": [side] * 6}}
    return Bench(
        folder,
        ROBOT,
        model,
        workobject={"xyz": [1450.0, 150.0, 700.0], "rpy": [0.0, 0.0, 0.0]},
        process={"kind": "constant", "frame": "path", "wrench": [-150.0, 90.0, -60.0, 0.0, 0.0, 0.0]},
        start=[0.0, 20.0, 15.0, 0.0, 50.0, 0.0],
        tool={"xyz": [60.0, 0.0, 410.0], "rpy": [0.0, 35.0, 0.0], "mass": 35.0, "com": [20.0, 5.0, 290.0]},
        gravity="calibrated-out",
        extra={"sampling": {"chord": 0.002}},
    )


@dataclass(frozen=True)
class Circle:
    """The full circle as milled; SI."""

    angle: Array  # (M,) rad, from the centre, rising
    radial: Array  # (M,) m, outwards
    height: Array  # (M,) m
    knot: Array  # (M,) True at poses of the program
    direction: Array  # (M,n) last rotation of every joint

    @property
    def reversals(self) -> list[tuple[int, float]]:
        """(joint counted from 1, angle rad) where a joint turns around on the circle."""
        rows, joints = np.nonzero(np.diff(self.direction, axis=0))
        return [(int(j) + 1, float(self.angle[k + 1])) for k, j in zip(rows, joints, strict=True)]


def circle_of(job: Bench, walk: Walk, table: Table, per_move: int) -> Circle:
    """The rows of a walk that are on the circle, in the work object."""
    lines = GCODE.splitlines()
    arcs = [k + 1 for k, line in enumerate(lines) if line.startswith("G3")]
    on = np.flatnonzero(np.isin(table.line, arcs))
    rows = slice((on[0] - 1) * per_move, on[-1] * per_move + 1)
    back = np.linalg.inv(job.base_work)
    xyz = (walk.tcp[rows] @ np.array([0, 0, 0, 1.0])) @ back.T
    angle = np.unwrap(np.arctan2(xyz[:, 1], xyz[:, 0]))
    angle += 2 * np.pi * np.round((0 - angle[0]) / (2 * np.pi))
    return Circle(
        angle,
        np.hypot(xyz[:, 0], xyz[:, 1]) - RADIUS * MM,
        xyz[:, 2],
        walk.knot[rows],
        walk.direction[rows],
    )


def mill(job: Bench, table: Table, *, nominal: bool, per_move: int, plant: Bench | None = None) -> Circle:
    """Run a program on the plant, `per_move` steps between two poses."""
    machine = (plant or job).plant()
    q = machine.follow(job.in_base(table.nominal if nominal else table.command), table.q[0])
    walk = machine.run(
        q, table.wrench, start=Memory.fresh(job.q_start), interpolate=per_move, keep_between=True
    )
    return circle_of(job, walk, table, per_move)


def experiment(folder: Path, side: float, per_move: int = 6) -> dict[str, Circle]:
    """uncompensated, stiffness only and play tracked, on one and the same plant."""
    path = folder / "circle.nc"
    path.write_text(GCODE)
    whole = bench(folder, side)
    _, raw = whole.preview(path)
    _, tracked = whole.compensate(path)
    stiff = replace(whole, effects={"joint-stiffness": MODEL["joint-stiffness"]})
    _, plain = stiff.compensate(path)
    return {
        "uncompensated": mill(whole, raw, nominal=True, per_move=per_move),
        "stiffness only": mill(whole, plain, nominal=False, per_move=per_move),
        "stiffness and play": mill(whole, tracked, nominal=False, per_move=per_move),
    }
