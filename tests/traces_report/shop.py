"""A shop's cell as the plant runs it: what cuts and clamps beside the arm, three programs, and what each kind shows."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from compensator.tasks.compensate import preview_file
from tests.compensator.plant_bench import STILL, Bench, Table, write_poses
from tests.plant import Arm
from tests.plant.cell_design import Cell
from tests.plant.geometry import Array
from tests.plant.moment import Moment
from tests.plant.sizing import rms
from tests.plant.wear import Wear
from tests.plant.worn_plant import WornPlant
from tests.trace_bench import Ran, both_ways

Kind = Literal["positions", "ballbar", "surface"]
KINDS: tuple[Kind, ...] = ("positions", "ballbar", "surface")
ROBOT = "abb-irb6600-175-255"
K = (3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4)  # N*m/rad
CENTRE = np.array([1.5, 0.0, 0.9])  # m, base
ASIDE = np.array([4e-4, -3e-4, 2e-4])  # m, by which the ball of the ball-bar is not where it is told
START = (0.0, 10.0, 20.0, 0.0, 60.0, 0.0)  # deg
START_RAD = np.radians(START)
NOISE = 5e-6  # m
FEEDS = (1000.0, 3000.0)  # mm/min, of the circles of either plane
WARM = (20.0, 28.0)  # deg C, from the first row to the last
RADIUS = 100.0  # mm, of the circles
EACH = 40  # points on a wall
READINGS = 150  # of a trace, about


@dataclass(frozen=True)
class Shop(Wear):
    """What else can be wrong where a part is cut.

    Attributes:
        force: factor on the programmed force. left: m, by which the cutter is too small.
        edge: (3,) rad/(N*m), by which the fixture tips about its corner. slip: rad, that it has turned at the last row.
        rock: rad, by which it rocks to the side that the force pushes it to.
    """

    force: float = 1.0
    left: float = 0.0
    edge: Array = field(default_factory=lambda: np.zeros(3))
    slip: float = 0.0
    rock: float = 0.0

    def tilt(self, moment: Array) -> Array:
        """(N, 3) rad of the fixture in base axes, from the moment (N, 3) of the cut about its corner."""
        along = np.linspace(0.0, 1.0, len(moment))[:, None]
        return moment * self.edge + (self.slip * along + self.rock * np.sign(moment[:, :1])) * [1.0, 0.0, 0.0]


CORNER = CENTRE - np.array([0.2, 0.15, 0.15])  # m, base: what the fixture tips about


@dataclass(frozen=True)
class ShopCell(Cell):
    """The cell of the shop, as the scenarios of the plant take one."""

    held: Arm | None = None

    @property
    def arm(self) -> Arm:
        """With the tool of the shop."""
        assert self.held is not None
        return self.held

    @property
    def healthy(self) -> Shop:
        """Joint springs and nothing else."""
        return Shop.healthy(np.array(self.stiffness))  # type: ignore[return-value]


def rows(kind: Kind, size: float) -> tuple[list[list[object]], Array, Array]:
    """Rows of a csv toolpath, the normal (N, 3) of what is measured there, and the force (N, 3) N on the tool there.

    Two circles in two planes each, or walls with an uneven allowance; both ways round, at two feeds.
    """
    if kind == "surface":
        corner = size * np.array([[-150, -100], [150, -100], [150, 100], [-150, 100], [-150, -100]], dtype=float)
        out = np.array([[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], dtype=float)
        wall, share = np.repeat(np.arange(4), EACH), np.tile(np.arange(EACH) / EACH, 4)[:, None]
        place = np.pad(corner[wall] + share * (corner[wall + 1] - corner[wall]), ((0, 0), (0, 1)))[:, :3]
        place, normal = np.vstack([place, place[::-1]]), np.vstack([out[wall], out[wall][::-1]])
        path = [[*p.round(6), 0, 0, 1, FEEDS[0], "cut" if k else "rapid"] for k, p in enumerate(place)]
        floor = np.arange(len(place)) // 2 % 2 == 1
        sense = np.repeat([1.0, -1.0], 4 * EACH)[:, None]
        travel = sense * np.cross([0.0, 0.0, 1.0], normal)
    else:
        path = both_ways(RADIUS * size, 60, ("xy", "xz"))
        place = np.array([row[:3] for row in path], dtype=float)
        path = [[*row[:6], FEEDS[k * 2 // len(path)], row[7]] for k, row in enumerate(path)]
        normal = place / np.linalg.norm(place, axis=1, keepdims=True)
        travel = np.gradient(place, axis=0)
        travel /= np.linalg.norm(travel, axis=1, keepdims=True)
    load = 150 * (1 + 0.6 * np.sin(2 * np.pi * np.arange(len(place)) / 37))[:, None]
    force = -load * normal - 0.5 * load * travel - [0, 0, 60]
    if kind == "surface":  # what is measured is the wall and the floor beside it
        normal = np.where(floor[:, None], [0.0, 0.0, 1.0], normal)
    return path, normal, force


@dataclass(frozen=True)
class Program:
    """A program of one kind in its folder; ``size``: of the circles or walls, 1 or what is held out."""

    folder: Path
    kind: Kind
    size: float = 1.0

    @cached_property
    def bench(self) -> Bench:
        """The cell; its process is a table of forces."""
        process: dict[str, Any] = {"kind": "table", "frame": "base", "file": f"{self.name}-w.csv", "material": "alu"}
        place = {"xyz": (CENTRE * 1e3).tolist(), "rpy": [0.0, 0.0, 0.0]}
        effects = {"joint-stiffness": {"k_nm_per_rad": list(K)}}
        return Bench(self.folder, ROBOT, effects, place, process, start=list(START))

    @property
    def name(self) -> str:
        return f"{self.kind}-{self.size:g}"

    @property
    def dry(self) -> bool:
        return self.kind == "ballbar"

    @cached_property
    def cell(self) -> ShopCell:
        """As the scenarios of the plant take one."""
        return ShopCell(ROBOT, K, 200.0, 0.0, 2, "base", self.bench.plant().arm)

    @cached_property
    def planned(self) -> tuple[Table, Array]:
        """Rows of the program, planned by the product once, and the normals of their walls."""
        path, normal, force = rows(self.kind, self.size)
        program = self.folder / f"{self.name}.csv"
        with (self.folder / f"{self.name}-w.csv").open("w", newline="") as stream:
            table = csv.writer(stream)
            table.writerow(["index", "fx", "fy", "fz", "mx", "my", "mz"])
            table.writerows([k, *row, 0, 0, 0] for k, row in enumerate(force))
        preview_file(write_poses(self.folder / f"{self.name}-path.csv", path), self.bench.cell(), csv=program)
        return Table.read(program), normal

    @cached_property
    def moments(self) -> list[Moment]:
        """Clock, climate, and the speed of every joint by the programmed feed."""
        table = self.planned[0]
        with (self.folder / f"{self.name}.csv").open(newline="") as stream:
            feed = [float(row["feed_mm_min"] or FEEDS[0]) / 6e4 for row in csv.DictReader(stream)]
        step = np.linalg.norm(np.diff(table.command[:, :3, 3], axis=0), axis=1)
        seconds = np.maximum(step, 1e-9) / np.array(feed[1:])
        time = np.concatenate([[0.0], np.cumsum(seconds)])
        speed = np.vstack([np.zeros(6), np.diff(table.q, axis=0) / seconds[:, None]])
        warm = np.linspace(*WARM, len(time))
        return [
            Moment(float(t), float(T), {f"speed{k + 1}": float(v) for k, v in enumerate(row)})
            for t, T, row in zip(time, warm, speed, strict=True)
        ]

    def ran(self, wear: Wear) -> Ran:
        """What the plant does."""
        table = self.planned[0]
        force = 0.0 if self.dry else getattr(wear, "force", 1.0)
        plant = WornPlant(self.cell.arm, wear, still=STILL)
        # it rests where it starts from: friction there has an anchor, which the long move drags along
        q, wrench = np.vstack([START_RAD, table.q]), np.vstack([np.zeros(6), force * table.wrench])
        walk = plant.walk(q, wrench, start=START_RAD, moments=[self.moments[0], *self.moments])
        rows = {f.name: getattr(walk, f.name)[1:] for f in fields(walk) if f.name != "memory"}
        return Ran(self.bench, self.folder / f"{self.name}.csv", table, replace(walk, **rows))

    def shown(self, wear: Wear) -> Array:
        """(N,) or (N, 3) m, what the instrument reads without noise."""
        ran = self.ran(wear)
        if self.kind == "positions":
            return ran.tcp
        if self.kind == "ballbar":
            return np.asarray(np.linalg.norm(ran.tcp - CENTRE - ASIDE, axis=1))
        return _deviation(ran, self.planned[1], wear)

    def change(self, wear: Wear) -> float:
        """m, RMS, against the healthy cell."""
        return rms(self.shown(wear) - self.shown(self.cell.healthy))

    @cached_property
    def _free(self) -> Array:
        """What a fit is free to take, orthonormal: joint springs, and of a ball-bar centre and length."""
        healthy, columns = self.shown(self.cell.healthy), []
        for k, stiff in enumerate(K):
            softer = self.cell.healthy.stiffness.copy()
            softer[k] = stiff / 1.01
            columns.append((self.shown(replace(self.cell.healthy, stiffness=softer)) - healthy).ravel())
        if self.kind == "ballbar":
            away = self.ran(self.cell.healthy).tcp - CENTRE - ASIDE
            columns += [*(away / healthy[:, None]).T, np.ones(len(healthy))]
        U, size, _ = np.linalg.svd(np.array(columns).T, full_matrices=False)
        return np.asarray(U[:, size > 1e-9 * size[0]])

    def left(self, change: Array) -> float:
        """m, RMS of what springs, centre and length cannot take."""
        flat = change.ravel()
        return rms(flat - self._free @ (self._free.T @ flat))


def _deviation(ran: Ran, normal: Array, wear: Wear) -> Array:
    """(N,) m of the part as it is measured off the fixture."""
    shop = wear if isinstance(wear, Shop) else Shop.healthy(wear.stiffness)
    nominal = ran.bench.in_base(ran.table.nominal)[:, :3, 3]
    lever = nominal - CORNER
    part = np.cross(shop.tilt(np.cross(lever, -ran.walk.wrench[:, :3])), lever)
    return np.asarray(np.sum((ran.tcp - nominal - part) * normal, axis=1) + shop.left)


def samples(program: Program, wear: Wear, seed: int) -> dict[str, Sequence[float]]:
    """Columns of samples.csv."""
    read = program.shown(wear)
    read = (read + np.random.default_rng(seed).normal(0.0, NOISE, read.shape)) * 1e3
    at = np.flatnonzero(program.planned[0].cut)
    at = at[:: max(len(at) // READINGS, 1)]
    columns: dict[str, Any] = {"index": at}
    if program.kind != "surface":  # a part is measured when all is over
        columns["temperature"] = [program.moments[k].temperature for k in at]
    if program.kind == "positions":
        columns["time"] = [program.moments[k].time for k in at]
        return columns | dict(zip("xyz", read[at].T, strict=True))
    if program.kind == "ballbar":
        return columns | {"radius": read[at]}
    place = program.planned[0].nominal[at, :3, 3] * 1e3
    named = dict(zip("xyzijk", [*place.T, *program.planned[1][at].T], strict=True))
    return columns | named | {"deviation": read[at]}
