"""A robot cell, its files for the product on one side, the plant with the same figures on the other."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from compensator.tasks.compensate import Done, compensate_file, preview_file
from tests.plant import Arm, Memory, Plant, Tool, Walk
from tests.plant.geometry import Array, placement
from tests.plant.joints import Bearings

MM = 1e-3
TOOL = {"xyz": [40.0, -10.0, 220.0], "rpy": [0.0, 30.0, 0.0], "mass": 35.0, "com": [20.0, 5.0, 110.0]}
STILL = 5e-7  # rad: what a robot takes for a change of direction; printed digits are no reversal


def robot_file(name: str) -> Path:
    """The built-in robot file: both sides read it, each with its own reader."""
    return Path(str(resources.files("stiffness") / "robot" / "data" / f"{name}.toml"))


@dataclass(frozen=True)
class Bench:
    """One cell, its files in `folder`, and a plant that is what the model says."""

    folder: Path
    robot: str
    effects: Mapping[str, Mapping[str, Any]]
    workobject: Mapping[str, Sequence[float]]
    process: Mapping[str, Any]
    start: Sequence[float] | None = None  # deg
    tool: Mapping[str, Any] = field(default_factory=lambda: TOOL)
    mount: Sequence[float] = (0.0, 0.0, 0.0)  # deg
    gravity: str = "uncompensated"
    extra: Mapping[str, Any] = field(default_factory=dict)  # more tables of the cell

    @property
    def base_work(self) -> Array:
        """(4,4) base -> work object."""
        place = self.workobject
        return placement(MM * np.array(place["xyz"]), np.radians(place.get("rpy", (0, 0, 0))))

    @property
    def q_start(self) -> Array | None:
        """(n,) rad."""
        return None if self.start is None else np.radians(self.start)

    def cell(self) -> Path:
        """Writes cell and model."""
        model = {"schema": "model/1", "robot": self.robot, "effects": self.effects}
        (self.folder / "model.toml").write_text(tomli_w.dumps(model))
        cell: dict[str, Any] = {
            "schema": "cell/1",
            "robot": self.robot,
            "model": "model.toml",
            "gravity": self.gravity,
            "mount": {"rpy": list(self.mount)},
            "tool": self.tool,
            "workobject": self.workobject,
            "process": self.process,
            **self.extra,
        }
        if self.start is not None:
            cell["start"] = {"joints": list(self.start)}
        path = self.folder / "cell.toml"
        path.write_text(tomli_w.dumps(cell))
        return path

    def compensate(self, toolpath: Path, program: str = "out.csv") -> tuple[Done, Table]:
        """Through the product, from files to files, and the rows of the csv."""
        cell = self.cell()
        done = compensate_file(toolpath, cell, self.folder / program)
        if not program.endswith(".csv"):
            compensate_file(toolpath, cell, self.folder / "out.csv")
        return done, Table.read(self.folder / "out.csv")

    def preview(self, toolpath: Path) -> tuple[Done, Table]:
        """The nominal path, through the product."""
        done = preview_file(toolpath, self.cell(), csv=self.folder / "preview.csv")
        return done, Table.read(self.folder / "preview.csv")

    def plant(self, **other: Any) -> Plant:
        """The robot as the model file describes it; `other` replaces arguments of Plant."""
        tool = Tool(
            MM * np.array(self.tool["xyz"]),
            np.radians(self.tool.get("rpy", (0, 0, 0))),
            self.tool.get("mass", 0.0),
            MM * np.array(self.tool.get("com", (0, 0, 0))),
        )
        arm = Arm.load(robot_file(self.robot), tool=tool, mount_rpy=np.radians(self.mount))
        given = {"calibrated_out": self.gravity == "calibrated-out", **_laws(self.effects, arm.n), **other}
        return Plant(arm, **given)

    def in_base(self, poses: Array) -> Array:
        """(N,4,4) of the work object -> base."""
        return np.array(self.base_work @ poses)

    def walk(self, plant: Plant, table: Table, *, nominal: bool = False, interpolate: int = 1) -> Walk:
        """What a controller does with the poses of the file: its own kinematics, then the plant."""
        poses = self.in_base(table.nominal if nominal else table.command)
        q = plant.follow(poses, table.q[0])
        start = None if self.q_start is None else Memory.fresh(self.q_start)
        return plant.run(q, table.wrench, start=start, interpolate=interpolate, keep_between=True)


def _laws(effects: Mapping[str, Mapping[str, Any]], n: int) -> dict[str, Any]:
    given: dict[str, Any] = {"stiffness": effects["joint-stiffness"]["k_nm_per_rad"], "still": STILL}
    for name, p in effects.items():
        if name == "preload-softening":
            given["ratio"] = p["ratio"]
        elif name == "backlash":
            side = np.unique(p.get("side", 1.0))
            given.update(gap=p["gap_rad"], breakaway=p["breakaway_nm"], side_sign=side.item())
        elif name == "joint-hardening":
            windup, knee = np.array(p["windup_rad"]), np.array(p["knee_nm"])
            given["hardening"] = lambda torque, _, a=windup, t=knee: a * np.tanh(torque / t)
        elif name == "joint-friction":
            given["friction"] = _bearings(p)
        elif name == "tool-compliance":
            given["tool_spring"] = np.linalg.inv(compliance(p))
        elif name != "joint-stiffness":
            raise ValueError(name)
    return given


def _bearings(p: Mapping[str, Any]) -> Bearings:
    """Dry bearings that slip one after the other, at the loads at which the operators do.

    On a first loading the link yields by 1 - (share of the operators that still stick) of what it would without them,
    and by 1 / (1 + grip of the bearings that still stick).
    """
    held = np.array(p["held"])
    weight = np.array([p.get("weight_quarter", 0 * held), p.get("weight_half", 0 * held), 0 * held + 1,
                       p.get("weight_double", 0 * held)])  # fmt: skip
    loads = np.array([0.25, 0.5, 1.0, 2.0])[:, None] * np.array(p["friction_nm"]) / held
    sticks = np.cumsum((weight / weight.sum(axis=0) * held)[::-1], axis=0)[::-1]
    together = sticks / (1 - sticks)
    grip = together - np.vstack([together[1:], 0 * held])
    at = np.cumsum(np.diff(loads, axis=0, prepend=0) * (1 - sticks), axis=0)  # K x link, where each slips
    return Bearings(grip * at, grip)


def compliance(p: Mapping[str, Any]) -> Array:
    """(6,6): diagonal, and the entries below it row by row."""
    c = np.zeros((6, 6))
    c[np.tril_indices(6, -1)] = p.get("coupling", np.zeros(15))
    return c + c.T + np.diag([*p["linear_m_per_n"], *p["angular_rad_per_nm"]])


@dataclass(frozen=True)
class Table:
    """The rows of a program as csv, in SI."""

    kind: list[str]
    command: Array  # (N,4,4) work object
    nominal: Array  # (N,4,4) work object
    q: Array  # (N,n) rad
    wrench: Array  # (N,6) base axes
    deflection: Array  # (N,3) m, base axes
    line: Array  # (N,)

    @classmethod
    def read(cls, path: Path) -> Table:
        """By the column names of the interface."""
        with open(path, newline="") as stream:
            rows = list(csv.DictReader(stream))

        def columns(*names: str) -> Array:
            return np.array([[float(row[name]) for name in names] for row in rows])

        pose = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")
        joints = [name for name in rows[0] if name[0] == "q" and name.endswith("_deg")]
        return cls(
            kind=[row["kind"] for row in rows],
            command=_poses(columns(*pose)),
            nominal=_poses(columns(*(f"nominal_{c}" for c in pose))),
            q=np.radians(columns(*joints)),
            wrench=columns("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm"),
            deflection=MM * columns("dx_mm", "dy_mm", "dz_mm"),
            line=columns("source_line")[:, 0].astype(int),
        )

    @property
    def cut(self) -> Array:
        """(N,) bool."""
        return np.array([kind == "cut" for kind in self.kind])


def _poses(rows: Array) -> Array:
    """(N,7) mm and quaternion -> (N,4,4), by v + 2 w (u x v) + 2 u x (u x v)."""
    out = np.tile(np.eye(4), (len(rows), 1, 1))
    w, u = rows[:, 3:4], rows[:, 4:]
    for k, axis in enumerate(np.eye(3)):
        cross = np.cross(u, axis)
        out[:, :3, k] = axis + 2 * w * cross + 2 * np.cross(u, cross)
    out[:, :3, 3] = MM * rows[:, :3]
    return out


def write_poses(path: Path, rows: Sequence[Sequence[object]]) -> Path:
    """A csv toolpath: x y z (mm), i j k, feed, kind."""
    with open(path, "w", newline="") as stream:
        csv.writer(stream).writerows([["x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind"], *rows])
    return path
