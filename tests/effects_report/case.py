"""One scenario on one arm: sessions, a model identified from the healthy one, diagnosis, and what it was worth."""

from __future__ import annotations

import pickle
import time
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.regrouped import regrouped
from stiffness.diagnosis.result import Diagnosis
from stiffness.effects import BASE
from stiffness.effects.effect import Effect
from stiffness.identification.evaluate import evaluate
from stiffness.identification.registration import with_registration
from stiffness.identification.settled import settled
from stiffness.identification.unknowns import Unknown
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session, load_session
from tests.effects_report.reference import reference
from tests.effects_report.told import SPRINGS_KEPT, told
from tests.plant.ailment import Truth
from tests.plant.cell_design import CELLS, Cell
from tests.plant.cells import SCENARIOS, write

WIDE = 0.6  # of a stiffness, what a data sheet leaves open
KINDS = ("displacement", "absolute")
INVERSE = ("k_nm_per_rad", "ratio")
Key = tuple[str, str, int]  # effect, parameter, index
Flow = Literal["a", "b", "c"]
Rms = Mapping[str, float]  # kind of evidence -> m, RMS per axis on session B


@dataclass(frozen=True)
class Named:
    """An effect that the diagnosis named."""

    effect: str
    where: tuple[str, ...]
    confused_with: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """What came of a case. ``named``: effects of the model in the end; ``added``, ``at_hand``: by the diagnosis, in the
    model that it was given; ``distances``: what numbers are called -> standard deviations from the truth."""

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
    added: tuple[str, ...]
    at_hand: tuple[str, ...]
    moved: tuple[str, ...]
    points_at: tuple[tuple[str, float, str], ...]
    before: Rms
    after: Rms
    floor: Rms
    told: Rms | None
    distances: Mapping[str, float]
    notes: tuple[str, ...]
    seconds: float
    flow: Flow = "a"
    approach: bool = True


@dataclass(frozen=True)
class Task:
    """Which case to run; sessions stay in ``keep``.

    ``flow``: where the model at hand comes from: ``a`` a healthy session, ``b`` the default identify of the ill
    session itself, ``c`` a data sheet. ``approach``: whether sessions have the approach columns.
    """

    arm: str
    scenario: str
    seed: int
    size: float
    keep: Path
    flow: Flow = "a"
    approach: bool = True


def run(task: Task) -> Row:
    """Write, identify, diagnose, evaluate."""
    of, truths, floor, paths = _sessions(task)
    cell = CELLS[task.arm]
    healthy, ill, held = (load_session(paths[k]) for k in ("A_healthy", "D", "B"))
    model = _at_hand(task, healthy, ill, cell)
    begun = time.perf_counter()
    said = diagnose([ill], model)
    seconds = time.perf_counter() - begun
    before, after = _rms(held, model), _rms(held, said.model)
    best = None
    if all(t.effect != "unknown" for t in truths):
        fit = with_registration(reference(ill, model, truths, cell, said) if truths else said.base)
        best = _rms(held, fit.model(healthy.robot_name, {}))[0]
    named = _named(said, model)
    far = _distances(said, {n.effect for n in named}, truths, cell)
    return Row(
        task.arm, task.scenario, task.seed, task.size, of, tuple((t.effect, t.where) for t in truths),
        max((t.change for t in truths), default=0.0) / floor, max((t.left for t in truths), default=0.0) / floor,
        said.verdict, named, tuple(a.effect for a in said.added), tuple(e.name for e in model.effects),
        tuple(f"{c.effect} {c.parameter} {' '.join(c.where)}" for c in said.changed),
        tuple((p.what, p.fraction, p.follows) for p in said.residual_sources),
        before[0], after[0], after[1], best, far, said.notes, seconds, task.flow, task.approach,
    )  # fmt: skip


def _at_hand(task: Task, healthy: Session, ill: Session, cell: Cell) -> ComplianceModel:
    """The model that a user comes with."""
    if task.flow == "a":
        return identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    if task.flow == "b":
        return identify([ill]).model(ill.robot_name, {})
    model = identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    rng = np.random.default_rng(task.seed)
    guess = np.array(cell.stiffness) * np.exp(rng.normal(0.0, WIDE, len(cell.stiffness)))
    return replace(model, values={"joint-stiffness": {"k_nm_per_rad": guess}},
                   sd={"joint-stiffness": {"k_nm_per_rad": WIDE * guess}}, correlations=None)  # fmt: skip


def _named(said: Diagnosis, at_hand: ComplianceModel) -> tuple[Named, ...]:
    """What was added, and what the model at hand had and keeps, but for what every model has."""
    added = tuple(Named(a.effect, a.where, a.confused_with) for a in said.added)
    gone = {r.effect for r in said.removed} | {a.effect for a in said.added}
    own = [e for e in at_hand.effects if e.fitted_where not in ("load", "position") and e.name not in gone]
    return (*added, *(Named(e.name, _where(e, said.model), ()) for e in own))


def _where(effect: Effect, model: ComplianceModel) -> tuple[str, ...]:
    """Places where numbers of an effect are not neutral."""
    out = []
    for site in effect.sites(len(model.values["joint-stiffness"]["k_nm_per_rad"])):
        mine = (p for p in effect.parameters if p.neutral is not None and p.site == site.kind)
        if any(np.any(model.values[effect.name][p.name][p.of_site(site.index)] != p.neutral) for p in mine):
            out += list(site.where)
    return tuple(dict.fromkeys(out))


def _sessions(task: Task) -> tuple[str, tuple[Truth, ...], float, dict[str, Path]]:
    """Sessions of a task, sized by what joint springs leave of an effect; where that is out of reach, by all of it."""
    name = f"{task.arm} {task.scenario} {task.size:g} {task.seed}{'' if task.approach else ' blind'}"
    folder = task.keep / name.replace(" ", "_")
    kept = folder / "case.pickle"
    if not kept.exists():
        scenario, sessions = SCENARIOS[task.scenario], ("A_healthy", "D", "B")
        of = "left"
        for of in ("left", "change"):  # refused, or out of reach
            with suppress(ValueError):
                case = write(scenario, folder, task.seed, task.arm, size=task.size, of=of, sessions=sessions,
                             approach=task.approach)  # fmt: skip
                break
        kept.write_bytes(pickle.dumps((of, case.truth, case.floor, case.paths)))
    found: Any = pickle.loads(kept.read_bytes())  # own file
    return found  # type: ignore[no-any-return]


def _rms(session: Any, model: ComplianceModel) -> tuple[dict[str, float], dict[str, float]]:
    """RMS and noise floor per kind of evidence."""
    found = evaluate(session, model)
    scores = {k: getattr(found, k) for k in KINDS}
    return {k: s.rms for k, s in scores.items() if s}, {k: s.noise_floor for k, s in scores.items() if s}


def _distances(said: Diagnosis, named: AbstractSet[str], truths: tuple[Truth, ...], cell: Cell) -> dict[str, float]:
    """What numbers are called -> standard deviations from the truth, of those that are written alike on both sides.

    Of a number that the readings know together with another only, the sum is compared, where it stands in the model.
    """
    if named != {t.effect for t in truths}:
        return {}
    true = {(t.effect, *key): value for t in truths for key, value in told(t, cell).exact.items()}
    if all(t.effect in SPRINGS_KEPT for t in truths):
        true |= {(BASE.name, "k_nm_per_rad", k): value for k, value in enumerate(cell.stiffness)}
    seen = {key: _seen(key, value) for key, value in true.items()}
    for r in regrouped(settled(said.fit)[0], [t.effect for t in truths]):
        number = _key(r.number)
        if number not in seen:
            continue
        away = _seen(number, float(said.model.values[number[0]][number[1]][number[2]])) - seen.pop(number)
        for holder, share in zip(map(_key, r.holders), r.shares, strict=True):
            if holder in seen:
                seen[holder] += share * away
    return {k: v for key, value in seen.items() for k, v in _far(said.model, key, value).items()}


def _key(u: Unknown) -> Key:
    return u.effect, u.parameter.name, u.index


def _seen(key: Key, value: float) -> float:
    """A number as the solver sees it: intervals live there."""
    return 1 / value if key[1] in INVERSE else value


def _far(model: ComplianceModel, key: Key, true: float) -> dict[str, float]:
    effect, name, index = key
    value, sd = (float(x[effect][name][index]) for x in (model.values, model.sd))
    found = _seen(key, value)
    if not sd > 0 or np.isclose(found, true, rtol=1e-9, atol=0):
        return {}
    spread = sd / value**2 if name in INVERSE else sd
    return {f"{effect} {name}[{index + 1}]": (found - true) / spread}
