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
