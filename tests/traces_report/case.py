"""One case: the plant runs a program, a trace is written, diagnosed from files, and scored on another program."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import evaluated, identify_files
from compensator.tasks.measurements import in_terms_of, load_measurement
from stiffness.diagnosis.result import Diagnosis
from stiffness.errors import StiffnessError
from stiffness.model.model import ComplianceModel, load_model, model_text
from tests.effects_report.reference import reference
from tests.plant.ailment import Truth
from tests.plant.sizing import factor
from tests.plant.wear import Wear
from tests.trace_bench import write_trace
from tests.traces_report.causes import Scenario
from tests.traces_report.shop import CENTRE, NOISE, RADIUS, K, Program, samples

Flow = Literal["healthy", "sheet"]
FLOWS: tuple[Flow, ...] = ("healthy", "sheet")
WIDE = 0.6  # of a stiffness, what a data sheet leaves open
MOST = 10.0  # of a change over what is left of it: more would bend the arm by millimetres
HELD = 0.75  # size of the circles or walls that took part in nothing
MM = 1e-3


@dataclass(frozen=True)
class Named:
    """What the diagnosis named: an effect that was added, or one of the model whose numbers have moved."""

    effect: str
    where: tuple[str, ...]
    confused_with: tuple[str, ...]
    moved: bool = False


@dataclass(frozen=True)
class Row:
    """What came of a case. RMS on the program that took part in nothing, in m; ``told``: of a fit that is told the
    causes, None where there is none. ``left``: largest of the causes beyond joint springs, over the noise."""

    scenario: str
    kind: str
    flow: Flow
    truth: tuple[tuple[str, tuple[str, ...]], ...]
    change: float
    left: float
    verdict: str
    named: tuple[Named, ...]
    points_at: tuple[tuple[str, float, str], ...]
    next_traces: tuple[str, ...]
    before: float
    after: float
    told: float | None
    seconds: float


def run(scenario: Scenario, flow: Flow, keep: Path, size: float = 3.0, seed: int = 1) -> Row:
    """Write, diagnose, score."""
    folder = keep / scenario.kind
    folder.mkdir(parents=True, exist_ok=True)
    program, held = _programs(folder, scenario.kind)
    worn, truths = _worn(program, scenario, size)
    model = at_hand(keep, flow)
    trace = _trace(program, worn, seed)
    begun = time.perf_counter()
    found = diagnose_files([trace], model, folder / "refined.toml")
    seconds = time.perf_counter() - begun
    known = load_model(model)
    other = _trace(held, worn, seed + 1000)
    told = _told(trace, known, truths, program, found.diagnosis)
    said = found.diagnosis
    return Row(
        scenario=scenario.name, kind=scenario.kind, flow=flow,
        truth=tuple((t.effect, t.where) for t in truths),
        change=max((t.change for t in truths), default=0.0) / NOISE,
        left=max((t.left for t in truths), default=0.0) / NOISE,
        verdict=said.verdict, named=_named(found.report),
        points_at=tuple((p.what, p.fraction, p.follows) for p in said.residual_sources),
        next_traces=said.next_traces,
        before=_rms(other, known), after=_rms(other, load_model(folder / "refined.toml")),
        told=None if told is None else _rms(other, told), seconds=seconds,
    )  # fmt: skip


_made: dict[tuple[Path, str], tuple[Program, Program]] = {}  # planning takes longer than a walk


def _programs(folder: Path, kind: Any) -> tuple[Program, Program]:
    key = (folder, kind)
    if key not in _made:
        _made[key] = Program(folder, kind), Program(folder, kind, HELD)
    return _made[key]


def _worn(program: Program, scenario: Scenario, size: float) -> tuple[Wear, list[Truth]]:
    """The cell of a scenario, every cause of the size asked for: of what is left beyond springs; where little is, all
    of it, and a group with the springs is right."""
    key = (program, scenario.name, size)
    if key in _sized:
        return _sized[key]
    worn: Wear = program.cell.healthy
    truths = []
    for cause in scenario.causes:
        s, change, left = factor(program, cause, size * NOISE, "change")  # type: ignore[arg-type]
        if left > change / MOST:
            s, change, left = factor(program, cause, size * NOISE, "left")  # type: ignore[arg-type]
        worn, values = cause.apply(worn, program.cell.arm, s)
        truths.append(Truth(cause.effect, cause.where, cause.law, s, values, change, left))
    _sized[key] = worn, truths
    return worn, truths


_sized: dict[tuple[Program, str, float], tuple[Wear, list[Truth]]] = {}  # the same for every model at hand


def _trace(program: Program, worn: Wear, seed: int) -> Path:
    ran = program.ran(program.cell.healthy)
    columns = samples(program, worn, seed)
    more: dict[str, Any] = {"dry": program.dry}
    if program.kind == "ballbar":
        more["ballbar"] = {"center": list(CENTRE / MM), "radius": RADIUS * program.size, "calibrated": False}
    return write_trace(ran, program.kind, columns, NOISE / MM, f"trace-{program.size:g}", **more)


def at_hand(keep: Path, flow: Flow) -> Path:
    """The model that a user comes with: identified from a trace of the healthy cell under a cut, or of data sheets."""
    path = keep / f"{flow}.toml"
    if path.exists():
        return path
    if flow == "healthy":
        folder = keep / "positions"
        folder.mkdir(parents=True, exist_ok=True)
        program, _ = _programs(folder, "positions")
        trace = _trace(program, program.cell.healthy, 99)
        identify_files([trace], path, effects=["joint-stiffness"])
        return path
    known = load_model(at_hand(keep, "healthy"))
    guess = np.array(K) * np.exp(np.random.default_rng(5).normal(0.0, WIDE, len(K)))
    numbers = {"joint-stiffness": {"k_nm_per_rad": guess}}
    spread = {"joint-stiffness": {"k_nm_per_rad": WIDE * guess}}
    path.write_text(model_text(replace(known, values=numbers, sd=spread, correlations=None)))
    return path


def _named(report: Mapping[str, Any]) -> tuple[Named, ...]:
    added = [Named(a["effect"], tuple(a["where"]), tuple(a["confused_with"])) for a in report["added"]]
    moved = [Named(c["effect"], tuple(c["where"]), tuple(c["confused_with"]), True) for c in report["changed"]]
    return (*added, *moved)


def _rms(trace: Path, model: ComplianceModel) -> float:
    report = evaluated(load_measurement(trace), model)[1]
    return float(report["path"]["rms_mm"]) * MM


def _told(
    trace: Path, known: ComplianceModel, truths: list[Truth], program: Program, said: Diagnosis
) -> ComplianceModel | None:
    """A fit that is told the causes; None where the catalogue has them not, or no such fit comes to an end."""
    if any(t.effect == "unknown" for t in truths):
        return None
    session = in_terms_of(load_measurement(trace), known)
    try:
        fit = reference(session, known, truths, program.cell, said) if truths else said.base
    except (StiffnessError, ValueError):
        return None
    return fit.model(known.robot, {})
