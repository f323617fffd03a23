"""The whole circle on the plant: ill cell, sessions, diagnosis, compensated path, and where the tool really goes.

The code under test reads the session files of tests/plant/cells.py; the path is then run on the plant that wrote them.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.diagnose import refined_text
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.result import Diagnosis
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel, load_model, save_model
from stiffness.session.session import load_session
from tests.compensator.plant_bench import MM, STILL, Table, write_poses
from tests.plant import Memory, Walk, WornPlant
from tests.plant.cell_design import CELLS, design, form
from tests.plant.cells import SCENARIOS, SESSIONS, SETUPS, Case, write
from tests.plant.geometry import Array, placement
from tests.plant.lab import measure
from tests.plant.moment import Moment
from tests.plant.sizing import QUIET

POSES = 90
WARM = 27.0  # deg C, while cutting, where the cell feels it
FIRST = "start"  # the program of no compensation


@dataclass(frozen=True)
class Place:
    """Where an arm cuts: work object mm, start deg, half sizes of the contour mm, force N."""

    workobject: tuple[float, float, float]
    start: tuple[float, ...]
    size: tuple[float, float, float]
    force: float


PLACES = {
    "abb-irb6600-175-255": Place((1600.0, 150.0, 900.0), (5.0, 25.0, 10.0, 5.0, 55.0, 10.0), (220, 160, 60), 500.0),
    "kuka-kr210-r2700": Place((1600.0, 150.0, 900.0), (-5.0, -75.0, 90.0, 5.0, 65.0, 10.0), (220, 160, 60), 500.0),
    "ur10": Place((650.0, 100.0, 150.0), (24.0, -115.0, -83.0, 104.0, -82.0, 24.0), (110, 90, 30), 80.0),
}
PUSH = np.array([-0.62, 0.45, 0.64, 0.02, -0.015, 0.01])  # share of the force, and lever (m) of the moment; path axes


def contour(place: Place, poses: int = POSES) -> list[list[object]]:
    """A closed curve in space that turns back in every direction, the tool axis leaning; approach and retract."""
    t = np.linspace(0.0, 2 * np.pi, poses)
    a, b, c = place.size
    point = np.column_stack([a * np.sin(2 * t + 0.3), b * np.sin(3 * t), c * np.cos(5 * t)])
    lean = np.column_stack([0.2 * np.sin(t), 0.15 * np.cos(3 * t), np.ones(poses)])
    axis = lean / np.linalg.norm(lean, axis=1, keepdims=True)
    rows: list[list[object]] = [[*p, *d, 1200.0, "cut"] for p, d in zip(point, axis, strict=True)]
    far = [[*(point[k] + 60.0 * axis[k]), *axis[k], 1200.0, "rapid"] for k in (0, -1)]
    return [far[0], *rows, far[1]]


@dataclass(frozen=True)
class Errors:
    """Distances (m) of the tool from where the path wants it, at poses whose flanks nobody doubts."""

    mean: float
    p95: float
    max: float
    poses: int
    doubtful: Array  # (N,) the same at cutting poses that are left out above

    @classmethod
    def of(cls, walk: Walk, wanted: Array, cut: Array, doubtful: Array) -> Errors:
        """Of a walk; cut, doubtful: (N,) bool."""
        error, _ = walk.errors(wanted)
        sure = error[cut & ~doubtful]
        return cls(
            float(sure.mean()), float(np.percentile(sure, 95)), float(sure.max()), len(sure), error[cut & doubtful]
        )


@dataclass(frozen=True)
class Ill:
    """One ill cell with its sessions. Models and programs are made in `folder`.

    `at_once`: the model at hand is what the default identify makes of the ill session itself.
    """

    scenario: str
    arm: str
    folder: Path
    case: Case
    temperature: float | None = None
    poses: int = POSES
    seed: int = 1
    at_once: bool = False

    @classmethod
    def make(
        cls,
        scenario: str,
        arm: str,
        folder: Path,
        *,
        size: float = 5.0,
        seed: int = 1,
        poses: int = POSES,
        setups: int | None = None,
        at_once: bool = False,
    ) -> Ill:
        """Sessions of the healthy and the ill cell, written into `folder`; setups: the first of the ill cell's only."""
        case = write(SCENARIOS[scenario], folder, seed, arm, size=size, sessions=("A_healthy", "D"))
        if setups is not None:
            _first(case.paths["D"].with_name("samples.csv"), setups)
        warm = WARM if any(t.effect == "thermal-drift" for t in case.truth) else None
        return cls(scenario, arm, folder, case, warm, poses, seed, at_once)

    # ---- models

    @cached_property
    def at_hand(self) -> Path:
        """Joint stiffness, from the session of the healthy cell."""
        if self.at_once:
            ill = load_session(self.case.paths["D"])
            path = self.folder / "identified.toml"
            save_model(identify([ill]).model(ill.robot_name, {"kind": "static"}), path)
            return path
        healthy = load_session(self.case.paths["A_healthy"])
        path = self.folder / "joints.toml"
        save_model(identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {"kind": "static"}), path)
        return path

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """Of the ill cell, against the model at hand."""
        return diagnose([load_session(self.case.paths["D"])], load_model(self.at_hand))

    @cached_property
    def refined(self) -> Path:
        """What the diagnosis made of the model at hand, as a file."""
        path = self.folder / "refined.toml"
        session = load_session(self.case.paths["D"])
        path.write_text(refined_text(self.diagnosis, load_model(self.at_hand), [session], path))
        return path

    @cached_property
    def told(self) -> Path:
        """Fitted to the same readings by one who is told the effects."""
        return self._fitted("told", self.case.paths["D"])

    @cached_property
    def quiet(self) -> Path:
        """The same with instruments that have no noise: what is left then, the laws leave."""
        number = 10 * self.seed + SESSIONS.index("D")
        cell, folder = CELLS[self.arm], self.folder / "quiet"
        setups = design(cell, SETUPS["D"], number)
        notes = measure(self.case.plants["D"], setups, cell.targets, noise=QUIET, form=form(cell, setups, number))
        # the file still tells of the usual noise, so that the same weights hold
        table = {**notes.table, "instruments": tomllib.loads(self.case.paths["D"].read_text())["instruments"]}
        return self._fitted("quiet", replace(notes, table=table).write(folder, cell.name))

    def _fitted(self, name: str, path: Path) -> Path:
        session = load_session(path)
        names = ["joint-stiffness", *dict.fromkeys(t.effect for t in self.case.truth)]
        out = self.folder / f"{name}.toml"
        save_model(identify([session], names).model(session.robot_name, {"kind": "static"}), out)
        return out

    # ---- programs

    def cell(self, model: Path) -> Path:
        """A cell file with the tool of the session."""
        place, tool = PLACES[self.arm], CELLS[self.arm].arm.tool
        scale = place.force
        table: dict[str, Any] = {
            "schema": "cell/1",
            "robot": self.arm,
            "model": model.name,
            "gravity": "uncompensated",
            "tool": {"xyz": _mm(tool.xyz), "mass": tool.mass, "com": _mm(tool.com)},
            "workobject": {"xyz": list(place.workobject)},
            "start": {"joints": list(place.start)},
            "process": {"kind": "constant", "frame": "path", "wrench": (scale * PUSH).tolist()},
            "solve": {"max_correction": 50.0, "free_tool_axis": False},
            "sampling": {"spacing": 1000.0},
        }
        if self.temperature is not None:
            table["temperature"] = self.temperature
        path = self.folder / f"cell-{model.stem}.toml"
        path.write_text(tomli_w.dumps(table))
        return path

    def program(self, model: Path | None) -> Table:
        """The exported rows, read back; None: what goes out when nothing is compensated."""
        path = write_poses(self.folder / "path.csv", contour(PLACES[self.arm], self.poses))
        out = self.folder / f"{FIRST if model is None else model.stem}.csv"
        if model is None:
            preview_file(path, self.cell(self.at_hand), csv=out)
        else:
            compensate_file(path, self.cell(model), out)
        return Table.read(out)

    # ---- the plant

    @property
    def plant(self) -> WornPlant:
        """The ill arm; printed digits are no reversal to it."""
        plant = self.case.plants["D"]
        plant.joints = replace(plant.joints, still=STILL)
        return plant

    def walk(self, table: Table) -> Walk:
        """The commanded joint angles of the file, one after the other, with the process at the tool."""
        moment = Moment() if self.temperature is None else Moment(temperature=self.temperature)
        start = Memory.fresh(np.radians(PLACES[self.arm].start))
        return self.plant.walk(table.q, table.wrench, start=start, moments=[moment] * len(table.q))

    def errors(self, model: Path | None) -> Errors:
        """Of the program that was made with this model."""
        table = self.program(model)
        walk = self.walk(table)
        doubtful = self.doubtful(walk, None if model is None else load_model(model))
        return Errors.of(walk, self.wanted(table), table.cut, doubtful)

    def in_base(self, poses: Array) -> Array:
        """(N,4,4) of the work object -> base."""
        return np.array(placement(MM * np.array(PLACES[self.arm].workobject)) @ poses)

    def wanted(self, table: Table) -> Array:
        """(N,4,4) where the tool has to be, in the base."""
        return self.in_base(table.nominal)

    def doubtful(self, walk: Walk, model: ComplianceModel | None) -> Array:
        """(N,) poses where a torque is so near zero or breakaway that the flank is a matter of opinion.

        Near is 1 N*m, and where the model has a breakaway of its own, anything between that and the true one.
        """
        wear = self.plant.wear
        sizes = np.abs(walk.torque)
        gap = wear.gap > 0
        low, high = wear.breakaway - 1.0, wear.breakaway + 1.0
        if model is not None and "backlash" in model.values:
            own = model.values["backlash"]["breakaway_nm"]
            low, high = np.minimum(low, own - 1.0), np.maximum(high, own + 1.0)
        near = gap & (sizes > low) & (sizes < high)
        near |= (wear.ratio < 1) & (sizes < 1.0)
        move = np.abs(np.diff(walk.q_cmd, axis=0, prepend=walk.q_cmd[:1]))
        tiny = (gap | (wear.ratio < 1)) & (move > 0) & (move < 2e-6)
        out: Array = np.any(near | tiny, axis=1)
        return out


def _first(samples: Path, setups: int) -> None:
    head, *rows = samples.read_text().splitlines()
    samples.write_text("\n".join([head, *(r for r in rows if int(r.split(",")[0]) <= setups)]) + "\n")


def _mm(values: Any) -> list[float]:
    return (np.asarray(values, dtype=float) / MM).tolist()


def cancelled(before: Errors, after: Errors) -> float:
    """Share of the mean error that is gone."""
    return 1.0 - after.mean / before.mean


def acting() -> list[str]:
    """Single scenarios of effects in the catalogue that act on a path."""
    return [
        name
        for name, s in SCENARIOS.items()
        if len(s.ailments) == 1 and s.effects[0][0] not in ("unknown", "tracker-drift", "force-sensor-bias")
    ]
