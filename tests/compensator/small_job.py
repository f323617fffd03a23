"""A small job that works, and ways to spoil it: every refusal test changes one thing of it."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from benchmarks.milled import MATERIAL

ABB = "abb-irb6600-175-255"
STIFFNESS = [2.0e6, 1.7e6, 1.3e6, 2.8e5, 0.96e5, 0.37e5]
MODEL: dict[str, Any] = {
    "schema": "model/1",
    "robot": ABB,
    "effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}},
}
GAPS = {"gap_rad": [6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4], "breakaway_nm": [40.0, 40.0, 30.0, 10.0, 8.0, 4.0]}
WORN = {**MODEL, "effects": {**MODEL["effects"], "preload-softening": {"ratio": [0.75] + [1.0] * 5}, "backlash": GAPS}}
CELL: dict[str, Any] = {
    "schema": "cell/1",
    "robot": ABB,
    "tip": "tool0",
    "model": "model.toml",
    "gravity": "calibrated-out",
    "tool": {"xyz": [30.0, -20.0, 240.0], "rpy": [0.0, 25.0, 0.0], "mass": 30.0, "com": [10.0, 0.0, 110.0]},
    "workobject": {"xyz": [1500.0, -150.0, 800.0], "rpy": [0.0, 0.0, 20.0]},
    "process": {"kind": "constant", "frame": "workobject", "wrench": [-300.0, 200.0, 250.0, 5.0, -4.0, 3.0]},
}
AXIS = ("x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind")
# two rapids down to the part, a plunge, an L, up again
ROWS: list[list[Any]] = [
    [0, 0, 80, 0, 0, 1, 0, "rapid"],
    [0, 0, 5, 0, 0, 1, 0, "rapid"],
    [0, 0, -2, 0, 0, 1, 300, "cut"],
    [100, 0, -2, 0, 0, 1, 1200, "cut"],
    [100, 60, -2, 0, 0, 1, 1200, "cut"],
    [100, 60, 80, 0, 0, 1, 0, "rapid"],
]


def merged(table: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """`table` with `change` put over it, table by table; None takes a key away."""
    out = dict(table)
    for key, value in change.items():
        if value is None:
            out.pop(key, None)
        elif isinstance(value, Mapping) and isinstance(out.get(key), Mapping):
            out[key] = merged(out[key], value)
        else:
            out[key] = value
    return out


def nothing_but_findings(stderr: str) -> bool:
    """Whether every line on standard error is a finding: what a run that went well tells there."""
    return all(line.startswith(("warning: ", "note: ")) for line in stderr.splitlines())


@dataclass(frozen=True)
class Files:
    """Input files of one job in one folder."""

    folder: Path
    toolpath: Path
    cell: Path

    @property
    def out(self) -> Path:
        """Where outputs of the job go: a folder that is empty at first."""
        return self.folder / "out"

    def left(self) -> list[str]:
        """Names of everything in the output folder."""
        return sorted(p.name for p in self.out.rglob("*"))


def write_csv(path: Path, header: Sequence[str], rows: Sequence[Sequence[Any]]) -> Path:
    """A csv file."""
    with open(path, "w", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([header, *rows])
    return path


def files(
    folder: Path,
    cell: Mapping[str, Any] | None = None,
    model: Mapping[str, Any] | None = None,
    rows: Sequence[Sequence[Any]] = ROWS,
    header: Sequence[str] = AXIS,
) -> Files:
    """The job with changes to its cell and model; `process` and `effects` are replaced whole."""
    cell_table, model_table = CELL, MODEL
    if cell and "process" in cell:
        cell_table = merged(CELL, {"process": None})
    if model and "effects" in model:
        model_table = merged(MODEL, {"effects": None})
    (folder / "model.toml").write_text(tomli_w.dumps(merged(model_table, model or {})))
    path = folder / "cell.toml"
    path.write_text(tomli_w.dumps(merged(cell_table, cell or {})))
    (folder / "out").mkdir(exist_ok=True)
    return Files(folder, write_csv(folder / "path.csv", header, rows), path)


def columns(path: Path, *names: str) -> np.ndarray:
    """(N, k) numbers of a csv with a header."""
    with open(path, newline="") as stream:
        return np.array([[float(row[n]) for n in names] for row in csv.DictReader(stream)])


# a slot and two half immersions at two feeds; forces of 700/150/200/20/20/1 by the closed form, with 1 N of noise
FORCES = """shape,diameter_mm,flutes,ap_mm,entry_deg,exit_deg,feed_per_tooth_mm,fx_n,fy_n,fz_n
flat,20,4,3,-90,90,0.05,-96.8,-183.9,44.6
flat,20,4,3,-90,90,0.1,-122.0,-286.8,82.2
flat,20,4,3,0,90,0.05,19.8,-135.9,21.2
flat,20,4,3,-90,0,0.1,-162.2,-90.6,40.8
"""


def milling(folder: Path, **changes: Any) -> dict[str, Any]:
    """A process that mills ``path.csv`` out of a mesh, with a material of its own; both are written."""
    import trimesh

    (folder / "own.toml").write_text(MATERIAL)
    mesh = trimesh.creation.box(bounds=[[-20.0, -30.0, -25.0], [130.0, 90.0, 0.0]])
    mesh.export(folder / "stock.stl")
    table: dict[str, Any] = {
        "kind": "milling",
        "material": "own.toml",
        "spindle_rpm": 6000.0,
        "spindle": "m3",
        "cutter": {"shape": "flat", "diameter": 12.0, "flutes": 3, "length": 20.0},
        "stock": {"file": "stock.stl", "grid": 1.5},
        "coupled": False,
    }
    return merged(table, changes)
