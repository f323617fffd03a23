"""A laboratory on the plant: set-ups, loads, a tracker and a force sensor, written down as a measurement session.

What the instruments show is worked out from where the plant's links are, by formulas of this file alone.
"""

from __future__ import annotations

import csv
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import ArrayLike, NDArray

from .geometry import Array, placement, rigid_inverse, turn
from .instruments import Crooked, Wandering
from .lab_clock import moments
from .lab_request import Form, Noise, Setup, Step, Target
from .lab_sensor import Sensor
from .moment import Moment
from .plant import Plant
from .scene import Load
from .walk import Walk

Ints = NDArray[np.int64]

__all__ = ["Form", "Noise", "Notes", "Setup", "Step", "Target", "Truth", "measure"]


@dataclass(frozen=True)
class Truth:
    """What no lab knows, a row per reading: SI, base axes."""

    walk: Walk  # a row per move and state
    at: Ints  # (N,) row of the walk
    target: Ints  # (N,)
    position: Array  # (N,3) m
    wrench: Array  # (N,6) about `point`
    point: Array  # (N,3) m, where the TCP (or the pulled target) really is
    station: Mapping[int, Array]  # block -> (4,4) base -> tracker
    wrong_rows: tuple[int, ...]  # lines of samples.csv


@dataclass(frozen=True)
class Notes:
    """A session on paper: tables of session.toml (without robot) and rows of samples.csv."""

    table: dict[str, Any]
    rows: list[dict[str, object]]
    truth: Truth

    def write(self, folder: Path, robot: str | Path) -> Path:
        """Write session.toml and samples.csv. robot: a built-in name, or a file, which is copied beside them."""
        folder.mkdir(parents=True, exist_ok=True)
        if isinstance(robot, Path):
            shutil.copy(robot, folder / robot.name)
            robot = robot.name
        path = folder / "session.toml"
        path.write_text(tomli_w.dumps({"robot": robot, **self.table}), encoding="utf-8", newline="\n")
        with (folder / "samples.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(self.rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows)
        return path


def measure(
    plant: Plant,
    setups: Sequence[Setup],
    targets: Sequence[Target],
    *,
    noise: Noise | None = None,
    form: Form | None = None,
    seed: int = 0,
    tracker: Wandering | None = None,
    sensor: Crooked | None = None,
) -> Notes:
    """A day in the lab: every set-up approached by its last move, its states loaded in turn, all targets read."""
    day = _Day(plant, setups, targets, noise or Noise(), form or Form(), seed)
    day.tracker, day.crooked = tracker, sensor
    return day.notes()


class _Day:
    tracker: Wandering | None = None
    crooked: Crooked | None = None

    def __init__(
        self, plant: Plant, setups: Sequence[Setup], targets: Sequence[Target], noise: Noise, form: Form, seed: int
    ) -> None:
        self.plant, self.arm, self.setups, self.targets = plant, plant.arm, setups, targets
        self.noise, self.form = noise, form
        self.index = {t.name: k for k, t in enumerate(targets)}
        self.keys = [
            (i, k, r, t)
            for i, setup in enumerate(setups)
            for k in range(len(setup.steps))
            for r in range(form.readings(i, k))
            for t in range(len(targets))
        ]
        self.moments = moments(form, self.keys)
        # one stream per instrument: what one option draws does not shift the noise of another
        self.rng = dict(zip(("tracker", "sensor", "station", "wrong", "rough"), _streams(seed, 5), strict=True))
        self.metre = 1e3 if form.length == "mm" else 1.0
        self.radian = 180 / np.pi if form.angle == "deg" else 1.0

    # ---- the robot's day

    def walk(self) -> tuple[Walk, list[list[int]]]:
        """The plant through all moves and states; for each set-up the walk's rows of its states."""
        q: list[Array] = []
        wrench: list[Array] = []
        loads: list[list[Load]] = []
        where: list[list[int]] = []
        when: list[Moment] = []
        for i, setup in enumerate(self.setups):
            when += [self.moments[i, 0], *(self.moments[i, k] for k in range(len(setup.steps)))]
            angles = np.asarray(setup.q, dtype=float)
            q.append(angles - np.asarray(setup.move, dtype=float))
            wrench.append(np.zeros(6))
            loads.append([])
            where.append(list(range(len(q), len(q) + len(setup.steps))))
            for step in setup.steps:
                q.append(angles)
                on_tcp = step.pull is None
                wrench.append(np.concatenate([step.force, step.moment]) if on_tcp else np.zeros(6))
                loads.append(self._loads(step))
        return self.plant.walk(q, np.array(wrench), loads=loads, moments=when), where

    def _loads(self, step: Step) -> list[Load]:
        loads = []
        if step.pull is not None:
            target = self.targets[self.index[step.pull]]
            at, f, m = (np.array(v, dtype=float) for v in (target.at, step.force, step.moment))
            loads.append(Load(target.link, at, f, m))
        if step.payload:
            weight = step.payload * self.arm.gravity
            loads.append(Load(self.arm.n, np.array(self.arm.tool.com, dtype=float), weight, np.zeros(3)))
        return loads

    # ---- the lab's day

    def notes(self) -> Notes:
        """All readings."""
        walk, where = self.walk()
        keys = self.keys
        at = np.array([where[i][k] for i, k, _, _ in keys])
        target = np.array([t for *_, t in keys])
        points = np.array([walk.points(t.link, t.at) for t in self.targets])
        position = points[target, at]
        station = self._stations()
        shown = self._read(position, keys)
        wrong = self._spoil(shown, keys)
        rows, wrenches, pulled = [], [], []
        sensor = Sensor(
            self.arm, self.setups, self.targets, self.noise, self.form, walk, self.rng["sensor"], self.crooked
        )
        for number, key in enumerate(keys):
            wrench, point, columns = sensor.columns(key, int(at[number]))
            wrenches.append(wrench)
            pulled.append(point)
            rows.append(self._row(number, key, shown[number], station) | columns)
        rows = [row | self._extra(key[0]) for row, key in zip(rows, keys, strict=True)]
        truth = Truth(walk, at, target, position, np.array(wrenches), np.array(pulled), station, wrong)
        return Notes(self._table(), rows, truth)

    def _block(self, i: int) -> int:
        return i * self.form.blocks // len(self.setups)

    def _stations(self) -> dict[int, Array]:
        rng, found = self.rng["station"], {}
        for block in range(self.form.blocks):
            aside = rng.uniform([-3, -3, -0.5], [3, 3, 1.5])
            angles = rng.uniform([-0.05, -0.05, -np.pi], [0.05, 0.05, np.pi])  # a tracker stands about upright
            found[block] = np.eye(4) if self.form.registered else placement(aside, angles)
        return found

    def _read(self, position: Array, keys: Sequence[tuple[int, int, int, int]]) -> Array:
        """Positions with noise: per reading, or of a probe's pose as a whole."""
        rng, shown = self.rng["tracker"], position.copy()
        origin: dict[tuple[int, int, int, str], tuple[Array, Array, Array]] = {}
        for number, (i, k, r, t) in enumerate(keys):
            group = self.targets[t].group
            off = rng.normal(scale=self.noise.tracker, size=3)
            tilt = turn(rng.normal(scale=self.noise.tracker_angle, size=3))
            if self.tracker is not None:
                shown[number] = self.tracker.shown(position[number], number * (self.form.seconds or 0.0))
            if group is None:
                shown[number] += off
                continue
            first, off, tilt = origin.setdefault((i, k, r, group), (shown[number].copy(), off, tilt))
            shown[number] = first + off + tilt @ (shown[number] - first)
        return shown

    def _spoil(self, shown: Array, keys: Sequence[tuple[int, int, int, int]]) -> tuple[int, ...]:
        rng, wrong = self.rng["wrong"], set[int]()
        for number in rng.permutation(len(keys)):
            if len(wrong) >= self.form.wrong:
                break
            other = number + 1
            mixed = other < len(keys) and keys[other][:3] == keys[number][:3] and rng.random() < 0.5
            if number in wrong or (mixed and other in wrong):
                continue
            if mixed and len(wrong) + 2 <= self.form.wrong:
                shown[[number, other]] = shown[[other, number]]
                wrong |= {int(number), int(other)}
            else:
                direction = rng.normal(size=3)
                shown[number] += rng.uniform(1e-3, 1e-2) * direction / np.linalg.norm(direction)
                wrong.add(int(number))
        return tuple(sorted(number + 2 for number in wrong))

    def _row(
        self, number: int, key: tuple[int, int, int, int], shown: Array, station: Mapping[int, Array]
    ) -> dict[str, object]:
        (i, k, r, t), form = key, self.form
        setup, block = self.setups[i], self._block(i)
        row: dict[str, object] = {"setup": i + 1, "state": k, "reflector": self.targets[t].name}
        row |= _numbered("q", np.asarray(setup.q) * self.radian)
        seen = (rigid_inverse(station[block]) @ np.append(shown, 1.0))[:3]
        row |= dict(zip("xyz", (seen * self.metre).tolist(), strict=True))
        move = np.asarray(setup.move, dtype=float)
        if form.approach:
            row |= _numbered("approach", np.sign(move).astype(int))
        if form.step:
            row |= _numbered("step", move * self.radian)
        if form.sd:
            row |= dict.fromkeys(("sx", "sy", "sz"), self.noise.tracker * self.metre)
        if form.blocks > 1:
            row["block"] = block
        if form.repeats > 1 or form.again:
            row["repeat"] = r
        if form.seconds is not None:
            row["time"] = number * form.seconds
        if form.climate is not None:
            row["temperature"] = self.moments[i, k].temperature
        if any(step.payload for s in self.setups for step in s.steps):
            row["payload"] = setup.steps[k].payload
        return row

    def _extra(self, i: int) -> dict[str, object]:
        return {name: values[i] for name, values in self.form.extra.items()}

    def _table(self) -> dict[str, Any]:
        form, tool, noise = self.form, self.arm.tool, self.noise
        held: dict[str, Any] = {"xyz": self._in_units(tool.xyz), "rpy": (np.asarray(tool.rpy) * self.radian).tolist()}
        if tool.mass:
            held |= {"mass": tool.mass, "com": self._in_units(tool.com)}
        instruments = {"tracker": noise.tracker * self.metre, "force": noise.force, "torque": noise.torque}
        if noise.tracker_angle:
            instruments["tracker_angle"] = noise.tracker_angle
        table: dict[str, Any] = {
            "schema": "measurement-session/1",
            "samples": "samples.csv",
            "gravity": "calibrated-out" if self.plant.calibrated_out else "uncompensated",
            "registered": form.registered,
            "units": {"length": form.length, "angle": form.angle},
            "tool": held,
            "reflectors": self._reflectors(),
            "instruments": instruments,
        }
        if form.wrench:
            table["wrench"] = {"frame": form.frame, "about": form.about}
        if form.reference_temperature is not None:
            table["reference_temperature"] = form.reference_temperature
        if form.purposes:
            table["setups"] = {str(k): dict(v) for k, v in form.purposes.items()}
        return table

    def _reflectors(self) -> dict[str, Any]:
        rng, tables = self.rng["rough"], {}
        moved: dict[str, Array] = {}  # a probe's targets are off as one rigid body
        for t in self.targets:
            off = placement(rng.normal(scale=self.form.rough, size=3), rng.normal(scale=0.02, size=3))
            if t.group is None:
                off[:3, :3] = np.eye(3)
            elif not t.exact:
                off = moved.setdefault(t.group, off)
            at = np.asarray(t.at, dtype=float) if t.exact else (off @ np.append(t.at, 1.0))[:3]
            tables[t.name] = {"link": t.link, "position": self._in_units(at), "exact": t.exact}
            if t.group is not None:
                tables[t.name]["group"] = t.group
        return tables

    def _in_units(self, metres: ArrayLike) -> list[float]:
        return [float(v) for v in np.asarray(metres, dtype=float) * self.metre]


def _streams(seed: int, count: int) -> list[np.random.Generator]:
    return [np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(count)]


def _numbered(stem: str, values: Array | Ints) -> dict[str, object]:
    return {f"{stem}{k + 1}": v for k, v in enumerate(values.tolist())}
