"""One scenario on one arm: sessions, a model identified from the healthy one, diagnosis, and what it was worth."""

from __future__ import annotations

import pickle
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.result import Diagnosis
from stiffness.identification.evaluate import evaluate
from stiffness.identification.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import load_session
from tests.effects_report.reference import reference
from tests.effects_report.told import SPRINGS_KEPT, told
from tests.plant.ailment import Truth
from tests.plant.cell_design import CELLS, Cell
from tests.plant.cells import SCENARIOS, write

KINDS = ("displacement", "absolute")
Rms = Mapping[str, float]  # kind of evidence -> m, RMS per axis on session B


@dataclass(frozen=True)
class Named:
    """An effect that the diagnosis named."""

    effect: str
    where: tuple[str, ...]
    confused_with: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """What came of a case. ``distance``: what the worst of ``compared`` numbers is called -> sd from the truth."""

    arm: str
    scenario: str
    seed: int
    size: float  # asked for
    of: str  # what was asked to be of that size
    truth: tuple[tuple[str, tuple[str, ...]], ...]
    change: float  # largest of the effects, in noise floors
    left: float
    verdict: str
    named: tuple[Named, ...]
    moved: tuple[str, ...]
    points_at: tuple[tuple[str, float, str], ...]
    before: Rms
    after: Rms
    floor: Rms
    told: Rms | None
    distance: tuple[str, float] | None
    compared: int
    notes: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class Task:
    """Which case to run; sessions stay in ``keep``."""

    arm: str
    scenario: str
    seed: int
    size: float
    keep: Path


def run(task: Task) -> Row:
    """Write, identify, diagnose, evaluate."""
    of, truths, floor, paths = _sessions(task)
    cell = CELLS[task.arm]
    healthy, ill, held = (load_session(paths[k]) for k in ("A_healthy", "D", "B"))
    model = identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    begun = time.perf_counter()
    said = diagnose([ill], model)
    seconds = time.perf_counter() - begun
    before, after = _rms(held, model), _rms(held, said.model)
    best = None
    if all(t.effect != "unknown" for t in truths):
        fit = reference(ill, model, truths, cell, said) if truths else said.base
        best = _rms(held, fit.model(healthy.robot_name, {}))[0]
    worst, compared = _distance(said, truths, cell)
    return Row(
        task.arm, task.scenario, task.seed, task.size, of, tuple((t.effect, t.where) for t in truths),
        max((t.change for t in truths), default=0.0) / floor, max((t.left for t in truths), default=0.0) / floor,
        said.verdict, tuple(Named(a.effect, a.where, a.confused_with) for a in said.added),
        tuple(f"{c.effect} {c.parameter} {' '.join(c.where)}" for c in said.changed),
        tuple((p.what, p.fraction, p.follows) for p in said.residual_sources),
        before[0], after[0], after[1], best, worst, compared, said.notes, seconds,
    )  # fmt: skip


def _sessions(task: Task) -> tuple[str, tuple[Truth, ...], float, dict[str, Path]]:
    """Sessions of a task, sized by what joint springs leave of an effect; where that is out of reach, by all of it."""
    folder = task.keep / f"{task.arm} {task.scenario} {task.size:g} {task.seed}".replace(" ", "_")
    kept = folder / "case.pickle"
    if not kept.exists():
        scenario, sessions = SCENARIOS[task.scenario], ("A_healthy", "D", "B")
        of = "left"
        try:
            case = write(scenario, folder, task.seed, task.arm, size=task.size, of="left", sessions=sessions)
        except ValueError:  # refused, or out of reach
            of = "change"
            case = write(scenario, folder, task.seed, task.arm, size=task.size, of="change", sessions=sessions)
        kept.write_bytes(pickle.dumps((of, case.truth, case.floor, case.paths)))
    found: Any = pickle.loads(kept.read_bytes())  # own file
    return found  # type: ignore[no-any-return]


def _rms(session: Any, model: ComplianceModel) -> tuple[dict[str, float], dict[str, float]]:
    """RMS and noise floor per kind of evidence."""
    found = evaluate(session, model)
    scores = {k: getattr(found, k) for k in KINDS}
    return {k: s.rms for k, s in scores.items() if s}, {k: s.noise_floor for k, s in scores.items() if s}


def _distance(
    said: Diagnosis, truths: tuple[Truth, ...], cell: Cell
) -> tuple[tuple[str, float] | None, int]:
    """The number farthest from the truth in its standard deviations, of those that are written alike on both sides."""
    model, far = said.model, dict[str, float]()
    named = {a.effect for a in said.added}
    if named != {t.effect for t in truths}:
        return None, 0
    for t in truths:
        for (name, index), true in told(t, cell).exact.items():
            far |= _far(model, t.effect, name, index, true)
    if all(t.effect in SPRINGS_KEPT for t in truths):
        for k, true in enumerate(cell.stiffness):
            far |= _far(model, "joint-stiffness", "k_nm_per_rad", k, true)
    if not far:
        return None, 0
    worst = max(far, key=lambda k: abs(far[k]))
    return (worst, far[worst]), len(far)


def _far(model: ComplianceModel, effect: str, name: str, index: int, true: float) -> dict[str, float]:
    value, sd = (float(x[effect][name][index]) for x in (model.values, model.sd))
    if not sd > 0 or np.isclose(value, true, rtol=1e-9, atol=0):
        return {}
    key = f"{effect} {name}[{index + 1}]"
    if name in ("k_nm_per_rad", "ratio"):  # intervals live where the solver works: in the inverse
        return {key: (1 / value - 1 / true) / (sd / value**2)}
    return {key: (value - true) / sd}
