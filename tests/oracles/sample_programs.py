"""Programs to write in tests: a small one made by hand, and random ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame
from toolpaths.writing.program import Program

SPINDLE = ToolFrame(
    "spindle-a", Frame(Rotation.from_euler("y", 30, degrees=True).as_matrix(), np.array([0.01, -0.02, 0.25])),
    35.0, np.array([0.0, 0.005, 0.12]),
)  # fmt: skip
WORKOBJECT = np.eye(4)
WORKOBJECT[:3, :3] = Rotation.from_euler("ZYX", [30, -20, 10], degrees=True).as_matrix()
WORKOBJECT[:3, 3] = [1.5, -0.2, 0.8]
STAMP = (
    "version 1.2.3", "cell sha256:0123456789ab", "model sha256:cdef01234567", "toolpath sha256:89abcdef0123",
    "predicted error 0.0123 mm", "program sha256:456789abcdef",
)  # fmt: skip


def small() -> Program:
    """Two rapids, a square cut with a feed change, an exact pose, a retract; angles chosen by hand."""
    xyz = [
        (0, 0, 50), (0, 0, 5), (0, 0, 0), (40, 0, 0), (40, 20, 0),
        (40.0123, 20.0006, 0.00004), (0, 20, 0), (0, 20, 50),
    ]  # fmt: skip
    degrees = np.array([
        [0, -90, 90, 0, 45, 0], [-0.0, -89, 89, -1, 45, 1],
        [10, -88, 88, -91, 44, 91], [95, -87, 87, 179, 43, -179],
        [-95, -86, 86, -181, -42, 181], [-100, -85, 85, 10, -41, 270],
        [-5, -84, 84, 10, 40, -270.5], [-5, -83, 83, 10, 39, 0],
    ])  # fmt: skip
    down = Rotation.from_euler("x", 180, degrees=True)
    n = len(xyz)
    turned = Rotation.from_rotvec(np.radians(2.0) * np.outer(np.arange(n), [0, 0, 1]))
    return Program(
        name="PART1",
        position=np.array(xyz, dtype=float) * 1e-3,
        rotation=(turned * down).as_matrix(),
        joints=np.radians(degrees),
        feed=np.array([np.nan, np.nan, 0.005, 0.02, 0.02, 0.02, 0.03, np.nan]),
        kind=np.array([0, 0, 1, 1, 1, 1, 1, 0], dtype=np.uint8),
        tool=np.ones(n, dtype=np.int32),
        line=np.arange(10, 10 + n, dtype=np.int32),
        tools={1: SPINDLE},
        workobject=Frame.of(WORKOBJECT),
        rapid_speed=0.5,
        configuration=np.array([0, 0, 1, 2, 3, 4, 6, 7], dtype=np.int32),
        exact=np.array([0, 0, 0, 0, 1, 0, 0, 0], dtype=bool),
        start_joints=np.radians([0.0, -100.0, 100.0, 0.0, 45.0, 0.0]),
        comments=((0, "T1 M6"), (2, "S12000 M3 \u2013 Fr\u00e4sen")),
        robot="a robot",
        source="part.nc",
        stamp=STAMP,
    )


def random_program(n: int, seed: int, name: str = "RANDOM", lock: bool = True) -> Program:
    """n poses all over the place; a third of the orientations in or next to gimbal lock, some half turns."""
    g = np.random.default_rng(seed)
    rotation = Rotation.random(n, rng=g).as_matrix()
    if lock:
        angles = g.uniform(-180, 180, (n, 3))
        off = g.choice([0.0, 1e-9, 1e-7, 1e-5, 1e-3], n) * g.normal(size=n)
        angles[:, 1] = g.choice([-90.0, 90.0], n) + off
        locked = Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()
        rotation[::3] = locked[::3]
        axis = np.eye(3)[g.integers(0, 3, len(rotation[1::7]))]
        rotation[1::7] = Rotation.from_rotvec(np.pi * axis).as_matrix()
    kind = (g.random(n) < 0.8).astype(np.uint8)
    return Program(
        name=name,
        position=np.array([0.3, -1.4, 0.6]) + np.cumsum(g.normal(scale=2e-3, size=(n, 3)), axis=0),
        rotation=rotation,
        joints=g.uniform(-2 * np.pi, 2 * np.pi, (n, 6)),
        feed=np.where(kind == 1, g.choice([0.0011667, 0.02, 0.0333333], n), np.nan),
        kind=kind,
        tool=np.ones(n, dtype=np.int32),
        line=np.arange(1, n + 1, dtype=np.int32),
        tools={1: SPINDLE},
        workobject=Frame.of(WORKOBJECT),
        rapid_speed=0.5,
        configuration=g.integers(0, 8, n).astype(np.int32),
        robot="a robot",
        source="random.nc",
    )


def two_tools(name: str = "b", number: int = 2, mass: float | None = None) -> Program:
    """Seven cuts in a row, 10 mm each: three with the spindle, four with another tool."""
    other = ToolFrame(name, Frame(np.eye(3), np.array([0, 0, 0.3])), mass)
    tool = np.array([1, 1, 1, number, number, number, number], dtype=np.int32)
    xyz = np.column_stack((np.arange(7) * 1e-2, np.zeros(7), np.zeros(7)))
    return changed(random_program(7, 2), tools={1: SPINDLE, number: other}, tool=tool, position=xyz)


def on_the_spot() -> Program:
    """The tool turns about y between two straight moves, in small steps."""
    turns = np.radians(np.outer([0, 0, 0.1, 0.2, 0.3, 0.8, 1.3, 1.3], [0, 1, 0]))
    xyz = np.array([[0, 0, 0]] + [[5, 0, 0]] * 6 + [[9, 0, 0]]) * 1e-3
    return changed(random_program(8, 1, lock=False), position=xyz, rotation=Rotation.from_rotvec(turns).as_matrix())


def changed(program: Program, **values: object) -> Program:
    """The program with other values."""
    return replace(program, **values)
