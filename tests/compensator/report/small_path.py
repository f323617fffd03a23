"""A small run of compensate for the tests of reports: a circle on an arm with backlash."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from compensator.process.milling.mill import Cut
from compensator.process.milling.path import MillingPath
from compensator.solve.compensation import Compensation

MODEL = """
schema = "model/1"
robot = "abb-irb6600-175-255"
gravity = "calibrated-out"
[effects.joint-stiffness]
k_nm_per_rad = [2.0e6, 1.8e6, 1.4e6, 2.8e5, 9.6e4, 3.7e4]
[effects.backlash]
gap_rad = [6.0e-5, 5.0e-5, 6.0e-5, 1.1e-4, 0.0, 2.2e-4]
"""
CELL = """
schema = "cell/1"
robot = "abb-irb6600-175-255"
tip = "tool0"
model = "model.toml"
[tool]
xyz = [0.0, 0.0, 250.0]
mass = 35.0
com = [0.0, 0.0, 120.0]
[workobject]
xyz = [1500.0, -100.0, 800.0]
[process]
kind = "constant"
frame = "path"
wrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]
"""


def prepared(folder: Path) -> Path:
    """Writes cell, model and a path: a circle between two rapids, off the axes."""
    rows = ["x_mm,y_mm,z_mm,i,j,k,feed_mm_min,kind", "40,-70,50,0,0,1,0,rapid", "98,10,5,0,0,1,0,rapid"]
    for a in np.linspace(0, 2 * np.pi, 37):
        rows.append(f"{30 + 60 * np.cos(a):.4f},{10 + 60 * np.sin(a):.4f},{3 * np.sin(a):.4f},0,0,1,1500,cut")
    (folder / "circle.csv").write_text("\n".join([*rows, "90,10,60,0,0,1,0,rapid"]) + "\n")
    (folder / "model.toml").write_text(MODEL)
    (folder / "cell.toml").write_text(CELL)
    return folder


def taken(c: Compensation, rows: np.ndarray) -> Compensation:
    """The poses of ``rows`` as a longer path; figures do not care that they repeat."""

    def of_rows(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return value[rows] if len(value) == len(c) else value
        if isinstance(value, Mapping):
            return {name: of_rows(column) for name, column in value.items()}
        return picked(value) if isinstance(value, Cut | MillingPath) else value

    def picked(record: Any) -> Any:
        return replace(record, **{f.name: of_rows(getattr(record, f.name)) for f in fields(record)})

    path = replace(picked(c.path), toolpath=c.path.toolpath.take(rows), tcp=c.path.tcp.take(rows))
    printed = c.printed.take(rows)
    command = replace(picked(c.command), nominal=lambda q: printed)
    parts: dict[str, Any] = {"command": command, "load": picked(c.load), "target": c.target.take(rows)}
    if c.plain is not None and len(c.plain) == len(c):
        parts["plain"] = taken(c.plain, rows)
    return replace(picked(c), path=path, state=c.state.take(rows), **parts)  # type: ignore[no-any-return]
