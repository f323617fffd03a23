"""A small study: the small job's path on a box of placements, with a wall that some of them run into."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.compensator import small_job

STRAIGHT = {"xyz": [0.0, 0.0, 240.0], "rpy": [0.0, 0.0, 0.0], "com": [0.0, 0.0, 110.0]}
WALL = {"name": "wall", "box": [[0.0, 390.0, 300.0], [2500.0, 410.0, 1500.0]]}
BOX = "x=1100:3500:5,y=-300:400:3"  # out of reach far out, through the wall at y = 400
SD = {"k_nm_per_rad": small_job.STIFFNESS, "sd_nm_per_rad": [0.05 * k for k in small_job.STIFFNESS]}


def files(folder: Path, **cell: Any) -> small_job.Files:
    """Its files; the model knows its standard deviations."""
    model = {"effects": {"joint-stiffness": SD}}
    return small_job.files(folder, cell={"tool": STRAIGHT, "scene": [WALL], **cell}, model=model)

K = [6.0e4, 6.0e4, 4.0e4, 1.2e4, 1.2e4, 1.0e4]
OFFSET: dict[str, Any] = {
    "tool": {"xyz": [0.0, 30.0, 150.0], "rpy": [0.0, 0.0, 0.0], "mass": 2.0, "com": [0.0, 0.0, 80.0]},
    "workobject": {"xyz": [700.0, 100.0, 100.0], "rpy": [0.0, 0.0, 20.0]},
    "process": {"kind": "constant", "frame": "workobject", "wrench": [-60.0, 40.0, 50.0, 0.5, -0.4, 0.3]},
}
OFFSET_BOX = "x=500:1700:5,y=-300:300:2"  # out of reach far out


def offset_wrist(folder: Path, robot: str = "ur10", **cell: Any) -> small_job.Files:
    """The same path under an arm whose wrist axes do not meet in a point."""
    springs = {"k_nm_per_rad": K, "sd_nm_per_rad": [0.05 * k for k in K]}
    model = {"robot": robot, "effects": {"joint-stiffness": springs}}
    return small_job.files(folder, cell={"robot": robot, "tip": None, **OFFSET, "scene": [WALL], **cell}, model=model)
