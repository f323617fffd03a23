"""Traces of programs that ran on the plant: circles and contours, their program csv, and what each instrument reads."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from tests.compensator.plant_bench import Bench, Table, write_poses
from tests.plant import Plant, Walk
from tests.plant.geometry import Array

MM = 1e-3


def circle(radius: float, points: int, sense: int, plane: str = "xy", turns: float = 1.0) -> Array:
    """(N,3) mm about the origin of the work object."""
    a = sense * np.linspace(0, turns * 2 * np.pi, points)
    flat = radius * np.column_stack([np.cos(a), np.sin(a), 0 * a])
    order = {"xy": [0, 1, 2], "xz": [0, 2, 1], "yz": [2, 0, 1]}[plane]
    return flat[:, order]


def both_ways(radius: float = 150.0, points: int = 180, planes: Sequence[str] = ("xy",)) -> list[list[object]]:
    """Rows of a csv toolpath: in every plane a circle counter-clockwise, then clockwise."""
    rows: list[list[object]] = []
    for plane in planes:
        for sense in (1, -1):
            for k, p in enumerate(circle(radius, points, sense, plane)):
                rows.append([*p.round(6), 0, 0, 1, 1000.0, "rapid" if k == 0 and not rows else "cut"])
    return rows


@dataclass(frozen=True)
class Ran:
    """A program that ran: its csv, and what the plant did."""

    bench: Bench
    program: Path
    table: Table
    walk: Walk

    @property
    def tcp(self) -> Array:
        """(N,3) m, base."""
        return self.walk.tcp[:, :3, 3]


def run(bench: Bench, rows: Sequence[Sequence[object]], plant: Plant, name: str = "run") -> Ran:
    """Plans the toolpath through the product and lets the plant run its joints from the start of the cell."""
    toolpath = write_poses(bench.folder / f"{name}-path.csv", rows)
    from compensator.tasks.compensate import preview_file

    program = bench.folder / f"{name}.csv"
    preview_file(toolpath, bench.cell(), csv=program)
    table = Table.read(program)
    return Ran(bench, program, table, plant.walk(table.q, table.wrench, start=bench.q_start))


def write_trace(
    ran: Ran, kind: str, columns: Mapping[str, Any], noise: float, name: str = "trace", **more: Any
) -> Path:
    """trace.toml and samples.csv beside the cell; columns in the units of the contract."""
    folder = ran.bench.folder
    names = list(columns)
    with open(folder / f"{name}-samples.csv", "w", newline="") as stream:
        out = csv.writer(stream)
        out.writerow(names)
        out.writerows(zip(*(columns[n] for n in names), strict=True))
    text = {
        "schema": "trace/1", "cell": "cell.toml", "program": ran.program.name, "samples": f"{name}-samples.csv",
        "kind": kind, **{"instrument": {"noise": noise}, **more},
    }  # fmt: skip
    path = folder / f"{name}.toml"
    path.write_text(tomli_w.dumps(text))
    return path


def positions(ran: Ran, noise: float, seed: int = 0, name: str = "positions", every: int = 1, **more: Any) -> Path:
    """A tracker that follows the tool; noise mm."""
    at = np.arange(0, len(ran.tcp), every)
    read = ran.tcp[at] / MM + np.random.default_rng(seed).normal(0, noise, (len(at), 3))
    columns = {"index": at, **dict(zip("xyz", read.T, strict=True))}
    return write_trace(ran, "positions", columns, noise, name, **more)


def ballbar(
    ran: Ran, noise: float, centre: Array, radius: float = 150.0, error: float = 0.0,
    aside: Sequence[float] = (0, 0, 0), seed: int = 0, name: str = "ballbar", **more: Any,
) -> Path:  # fmt: skip
    """A ball-bar whose true centre (3,) m stands `aside` mm from the one that is told, and is `error` mm too long."""
    at = np.arange(len(ran.tcp))
    read = np.linalg.norm(ran.tcp - centre - MM * np.array(aside), axis=1) / MM + error
    columns = {"index": at, "radius": read + np.random.default_rng(seed).normal(0, noise, len(at))}
    bar = {"center": list(np.array(centre) / MM), "radius": radius, "calibrated": False}
    return write_trace(ran, "ballbar", columns, noise, name, ballbar=bar, **more)


def surface(ran: Ran, noise: float, normal: Array, seed: int = 0, name: str = "surface", **more: Any) -> Path:
    """A part that was cut: the deviation of every cutting pose along `normal` (N,3), the frame of the work object."""
    at = np.flatnonzero(ran.table.cut)
    nominal = ran.table.nominal[:, :3, 3]
    moved = (ran.tcp - ran.bench.in_base(ran.table.nominal)[:, :3, 3]) @ ran.bench.base_work[:3, :3]
    off = np.sum(moved * normal, axis=1)[at] / MM + np.random.default_rng(seed).normal(0, noise, len(at))
    columns = {
        "index": at,
        **dict(zip("xyz", (nominal[at] / MM).T, strict=True)),
        **dict(zip("ijk", normal[at].T, strict=True)),
        "deviation": off,
    }
    return write_trace(ran, "surface", columns, noise, name, **more)
