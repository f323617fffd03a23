"""Cells of built-in robots with soft, worn joints, and the load that they are tried with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.compensator.plant_bench import Bench
from tests.plant import Walk
from tests.plant.geometry import Array

FORCE = np.array([600.0, -500.0, 624.5, 5.0, -3.0, 4.0])  # N, N*m, base axes: 1 kN
NEVER = 1e9
BREAKAWAY = [600.0, NEVER, NEVER, 50.0, NEVER, 30.0]
SOFT_MODEL: dict[str, Any] = {
    "preload-softening": {"ratio": [0.75, 0.9, 0.85, 0.8, 0.7, 0.9]},
    "backlash": {
        "gap_rad": [1.5e-4, 2.0e-4, 1.8e-4, 2.5e-4, 3.0e-4, 3.0e-4],
        "breakaway_nm": BREAKAWAY,
        "side": [1.0] * 6,
    },
}
ROBOTS: dict[str, tuple[list[float], list[float], list[float]]] = {  # work object mm, start deg, N*m/rad
    "abb-irb6600-175-255": (
        [1500, 0, 900],
        [0, 20, 15, 0, 50, 0],
        [2.0e6, 1.77e6, 1.38e6, 2.8e5, 9.6e4, 3.7e4],
    ),
    "kuka-kr210-r2700": ([1500, 0, 900], [0, -80, 90, 0, 60, 0], [2.2e6, 3.4e6, 2.8e6, 8e5, 6e5, 4.7e5]),
    "kuka-kr240-class": ([1500, 0, 900], [0, -80, 90, 0, 60, 0], [2.2e6, 3.4e6, 2.8e6, 8e5, 6e5, 4.7e5]),
    "kuka-kr500": ([1700, 0, 900], [0, -80, 90, 0, 60, 0], [4e6, 4e6, 3e6, 8e5, 6e5, 4.7e5]),
}
FLOOR, WALL = (0.0, 0.0, 0.0), (0.0, 90.0, 0.0)
EXTRAS = {
    "joint-hardening": {"windup_rad": [1e-4] * 6, "knee_nm": [500.0, 800.0, 600.0, 100.0, 100.0, 50.0]},
    "tool-compliance": {
        "linear_m_per_n": [2e-8, 3e-8, 1e-8],
        "angular_rad_per_nm": [1e-6, 2e-6, 1e-6],
        "coupling": [0, 0, 0, 0, 3e-8, 0, -4e-8, 0, 0, 0, 0, 0, 0, 0, 0],
    },
}


def bench(
    folder: Path,
    robot: str,
    *,
    side: float = 1.0,
    breakaway: list[float] = BREAKAWAY,
    without: tuple[str, ...] = (),
    more: dict[str, Any] | None = None,
    **other: Any,
) -> Bench:
    workobject, start, k = ROBOTS[robot]
    backlash = {**SOFT_MODEL["backlash"], "side": [side] * 6, "breakaway_nm": breakaway}
    effects = {
        "joint-stiffness": {"k_nm_per_rad": k},
        **SOFT_MODEL,
        "backlash": backlash,
        **(more or {}),
    }
    process = {"kind": "constant", "frame": "base", "wrench": FORCE.tolist()}
    kept = {name: p for name, p in effects.items() if name not in without}
    given = {"process": process, "start": start, "extra": {"solve": {"max_correction": 30.0}}, **other}
    return Bench(folder, robot, kept, {"xyz": workobject}, **given)


def undecided(walk: Walk, breakaway: list[float]) -> Array:
    """(N,) poses where the rules themselves leave open which flank a joint rests on.

    Within half a N*m of breakaway a joint with a gap has two states of rest: resting on the other flank
    changes the posture, and with it the torque. And a joint that has turned back by less than 2 urad has
    turned for one who looks closely only.
    """
    near = np.abs(np.abs(walk.torque) - breakaway) < 0.5
    move = np.abs(np.diff(walk.q_cmd, axis=0, prepend=walk.q_cmd[:1]))
    tiny = (move > 0) & (move < 2e-6)
    out: Array = np.any(near | tiny, axis=1)
    return out
