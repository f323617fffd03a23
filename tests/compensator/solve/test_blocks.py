"""A run whose columns are worked on in small blocks against the same run at once: the same bytes."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import compensator.solve.flank_poses as flank_poses
import compensator.solve.joint_state as joint_state
import stiffness.kinematics.spherical as spherical
import toolpaths.columns as columns
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import MODEL, WORN, Files, files

BLOCK = 16


def wavy(poses: int, *, rapid: bool) -> list[list[object]]:
    """A closed curve with a swaying tool; in the middle of it a rapid."""
    t = np.linspace(0, 2 * np.pi, poses)
    tilt = 0.1 * np.sin(3 * t)
    rows = np.column_stack([60 * np.sin(t), 40 * np.sin(2 * t), 3 * np.cos(t), tilt, 0 * t, np.sqrt(1 - tilt**2)])
    kinds = ["rapid" if rapid and k == poses // 2 else "cut" for k in range(poses)]
    return [[*row, 1200, kind] for row, kind in zip(rows.tolist(), kinds, strict=True)]


def written(job: Files, name: str, **options: Any) -> dict[str, str]:
    """Hashes of what a run writes; of the summary without its seconds."""
    folder = job.out / name
    folder.mkdir(parents=True)
    compensate_file(job.toolpath, job.cell, folder / "p.mod", json=folder / "s.json", **options)
    preview_file(job.toolpath, job.cell, csv=folder / "p.csv", json=folder / "v.json")
    out = {}
    for file in sorted(folder.iterdir()):
        data = file.read_bytes()
        if file.suffix == ".json":
            told = json.loads(data)
            assert told.pop("seconds") > 0 and told["n_poses"] > 0
            data = json.dumps(told).encode()
        out[file.name] = hashlib.sha256(data).hexdigest()
    return out


@pytest.mark.parametrize(
    ("poses", "worn"),
    [(2, False), (71, False), (BLOCK - 1, True), (BLOCK, True), (BLOCK + 1, True), (71, True)],
)
def test_blocks_give_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, poses: int, worn: bool
) -> None:
    process = {"kind": "constant", "frame": "path", "wrench": [-160.0, 90.0, 120.0, 5.0, -4.0, 3.0]}
    cell = {"gravity": "uncompensated", "process": process}
    job = files(tmp_path, cell, WORN if worn else MODEL, rows=wavy(poses, rapid=poses > 40))
    whole = written(job, "whole")
    monkeypatch.setattr(columns, "BLOCK", BLOCK)
    monkeypatch.setattr(spherical, "BLOCK", 7)
    monkeypatch.setattr(joint_state, "STATELESS", BLOCK + 1)
    monkeypatch.setattr(flank_poses, "TOGETHER", 3)
    assert written(job, "blocks") == whole and len(whole) == 4
