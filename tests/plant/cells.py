"""Scenarios: cells that are ill in a known way, and the sessions that a lab brings home from them.

case = write(SCENARIOS["backlash joint-1"], folder, seed=1, arm="ur10", size=3.0)
case.paths["A_healthy"], case.paths["D"], case.paths["B"], case.paths["C"]   # session.toml files
case.truth, case.later, case.floor, case.plants["D"]                         # for the judge only
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from . import ailments_body as body
from . import ailments_instrument as instrument
from . import ailments_joint as joint
from .ailment import Ailment, Truth, several
from .ailments_unknown import UNKNOWN
from .cell_design import CELLS, NOISE, Cell, design, form
from .lab import measure
from .sizing import Bench, factor
from .wear import Wear
from .worn_plant import WornPlant

SESSIONS = ("A_healthy", "D", "B", "C")
JOINTS = range(1, 7)
SETUPS = {"A_healthy": 36, "D": 34, "B": 30, "C": 34}


@dataclass(frozen=True)
class Scenario:
    """What is wrong: nothing, one ailment or more. `effects`: (effect, places) of each, in words."""

    name: str
    ailments: tuple[Ailment, ...] = ()

    @property
    def effects(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """The truth in words."""
        return tuple((a.effect, a.where) for a in self.ailments)


@dataclass(frozen=True)
class Case:
    """Files of a scenario on one arm, and what only the judge may know."""

    paths: dict[str, Path]
    truth: tuple[Truth, ...]
    later: str  # what changed between B and C, in words: "joint-3 stiffness x 0.8", "base compliance x 1.8"
    floor: float  # m, RMS per axis: tracker, and what force noise makes of a prediction
    plants: dict[str, WornPlant]
    cell: Cell


def write(
    scenario: Scenario,
    folder: Path,
    seed: int,
    arm: str,
    *,
    size: float = 3.0,
    of: Literal["change", "left"] = "change",
    sessions: Sequence[str] = SESSIONS,
    approach: bool = True,
) -> Case:
    """Writes sessions to folder/NAME/session.toml: A_healthy before, D and B ill, C ill and moved on.

    size: what each ailment alone changes in the readings of D, RMS per axis over the noise floor.
    of: all of the change, or what is left of it when the best joint stiffnesses have been taken out.
    approach: whether the columns of the approach are written.
    """
    cell = CELLS[arm]
    bench = _bench(cell, "D", seed)
    floor = bench.floor()
    worn, truth = cell.healthy, list[Truth]()
    for ailment in sorted(scenario.ailments, key=lambda a: a.effect == "joint-coupling"):  # it retunes joint springs
        s, change, left = factor(bench, ailment, size * floor, of)
        worn, values = ailment.apply(worn, cell.arm, s)
        truth.append(Truth(ailment.effect, ailment.where, ailment.law, s, values, change, left))
    truth.sort(key=lambda t: scenario.effects.index((t.effect, t.where)))
    moved, later = _later(worn)
    wears = {"A_healthy": cell.healthy, "D": worn, "B": worn, "C": moved}
    plants = {name: WornPlant(cell.arm, wears[name]) for name in sessions}
    paths = {name: _session(cell, plants[name], folder / name, name, seed, approach) for name in sessions}
    return Case(paths, tuple(truth), later, floor, plants, cell)


def _number(name: str, seed: int) -> int:
    return 10 * seed + SESSIONS.index(name)


def _bench(cell: Cell, name: str, seed: int) -> Bench:
    number = _number(name, seed)
    setups = design(cell, SETUPS[name], number)
    return Bench(cell, setups, form(cell, setups, number))


def _session(cell: Cell, plant: WornPlant, folder: Path, name: str, seed: int, approach: bool) -> Path:
    bench, wear = _bench(cell, name, seed), plant.wear
    notes = measure(
        plant,
        bench.setups,
        cell.targets,
        noise=NOISE,
        form=replace(bench.form, approach=approach),
        seed=1000 + _number(name, seed),
        tracker=wear.tracker,
        sensor=wear.sensor,
    )
    return notes.write(folder, cell.name)


def _later(wear: Wear) -> tuple[Wear, str]:
    """A bolt of the base has come loose, where the base yields at all; else joint 3 has worn."""
    loose = tuple(replace(f, compliance=1.8 * f.compliance) if f.link == 0 else f for f in wear.flexures)
    if any(f.link == 0 for f in wear.flexures):
        return replace(wear, flexures=loose), "base compliance x 1.8"
    tied = any(tie.coef[2] for tie in wear.ties)  # such a joint has no stiffness of its own
    stiffness, k = wear.stiffness.copy(), 1 if tied else 3
    stiffness[k - 1] *= 0.8
    return replace(wear, stiffness=stiffness), f"joint-{k} stiffness x 0.8"


SINGLE: dict[str, Ailment] = {
    "joint-hardening joint-2": joint.hardening(2),
    "joint-hardening joint-3": joint.hardening(3),
    "joint-hardening joint-3 smooth": joint.hardening_smooth(3),
    "preload-softening joint-1": joint.softening(1),
    "preload-softening joint-3": joint.softening(3),
    "backlash joint-1": joint.backlash(1),
    "backlash joint-3": joint.backlash(3),
    "backlash joint-1 any torque carries": joint.backlash(1, breakaway=0.0),
    "backlash joint-5 no torque carries": joint.backlash(5, breakaway=np.inf),
    "joint-friction joint-2": joint.friction(2),
    "joint-friction joint-1": joint.friction(1),
    "joint-friction joint-2 loose": joint.friction(2, lag=False, grip=8.0),
    "joint-coupling joint-2 joint-3": joint.coupling(2, 3),
    "joint-coupling joint-5 joint-6": joint.coupling(5, 6),
    "posture-stiffness joint-2": joint.posture(2, "cosine"),
    "posture-stiffness joint-3": joint.posture(3),
    "kinematic-offset joint-3": body.zero(3),
    "kinematic-offset joint-5": body.zero(5),
    "kinematic-offset link-3": body.geometry(3),
    "gravity-compensator": body.strut(),
    "payload": body.payload(),
    "base-compliance": body.base(),
    "link-compliance link-2": body.link(2),
    "link-compliance link-4": body.link(4),
    "tool-compliance": body.tool(),
    "thermal-drift all": body.thermal((1, 2, 3, 4, 5, 6)),
    "thermal-drift link-2": body.thermal((2,)),
    "thermal-drift link-2 joint-2": body.thermal((2,), 2),
    "tracker-drift": instrument.tracker(),
    "tracker-drift settling": instrument.tracker(3000.0),
    "force-sensor-bias zero": instrument.sensor(),
    "force-sensor-bias scale": instrument.sensor("scale"),
    "backlash all joints": several(
        "play in every joint, with a breakaway of its own",
        [
            (joint.backlash(k, b), g)
            for k, b, g in zip(JOINTS, (0.05, 0.1, 0.02, 0.2, 0.1, 0.3), (0.4, 0.3, 0.5, 1.5, 1.0, 2.0), strict=True)
        ],
    ),
    "joint-hardening all joints": several(
        "three pieces in every joint",
        [(joint.hardening(k), g) for k, g in zip(JOINTS, (0.6, 0.4, 0.8, 1.0, 0.5, 1.2), strict=True)],
    ),
    "posture-stiffness joints 1 3 5": several(
        "compliance by the joint's own angle",
        [(joint.posture(1), 0.7), (joint.posture(3), 1.0), (joint.posture(5), 1.5)],
    ),
    "kinematic-offset all": several(
        "every zero and every frame",
        [(body.zero(k), g) for k, g in zip(JOINTS, (1.0, -0.6, 0.8, 2.0, -1.5, 2.5), strict=True)]
        + [(body.geometry(k), g) for k, g in zip(JOINTS[:5], (0.8, -1.0, 0.5, -0.7, 0.6), strict=True)],
    ),
} | {f"unknown {name}": make() for name, make in UNKNOWN.items()}

PAIRS = (
    ("backlash joint-1", "tool-compliance"),
    ("backlash joint-3", "base-compliance"),
    ("preload-softening joint-3", "payload"),
    ("joint-hardening joint-2", "kinematic-offset joint-5"),
    ("joint-friction joint-2", "thermal-drift all"),
    ("joint-coupling joint-2 joint-3", "tracker-drift"),
    ("posture-stiffness joint-3", "base-compliance"),
    ("link-compliance link-2", "payload"),
    ("gravity-compensator", "tool-compliance"),
    ("force-sensor-bias scale", "kinematic-offset link-3"),
    ("tool-compliance", "unknown ripple"),
    ("base-compliance", "unknown brake"),
)


def pair(first: str, second: str) -> Scenario:
    """Two ailments at once, each of the size asked for; any two of SINGLE go together."""
    return Scenario(f"{first} + {second}", (SINGLE[first], SINGLE[second]))


SCENARIOS: dict[str, Scenario] = {
    s.name: s
    for s in (
        Scenario("clean"),
        *(Scenario(name, (ailment,)) for name, ailment in SINGLE.items()),
        *(pair(*names) for names in PAIRS),
    )
}
