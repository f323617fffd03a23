"""What `plan --ballbar` and `plan --probe` do: from a cell to a program to measure, and an empty trace to fill in."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.cell.cell_file import load_cell
from compensator.cell.job import Job
from compensator.devices.order import FREE, TraceOrder
from compensator.devices.readings import BALLBAR, SURFACE
from compensator.devices.samples import csv_text
from compensator.devices.trace_toml import trace_toml
from compensator.errors import CompensatorError
from compensator.program.maker import refuse_study_frame
from compensator.report.json.findings import findings_report
from compensator.report.json.text import as_json
from compensator.report.json.trial import ballbar_report, probe_report, with_torques
from compensator.tasks.outputs import Outputs
from compensator.tasks.plan_session import refuse_filled_in
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from compensator.trials.ballbar import FEEDS, ballbar_moves, ballbar_plan
from compensator.trials.probe import probe_moves, probe_plan
from compensator.trials.trial_program import TrialProgram, trial_job, trial_program
from stiffness.model.model import load_model, robot_of
from toolpaths.files import language_of, write_program
from toolpaths.finding import NOTE, WARNING, Finding, of_kind

Floats = npt.NDArray[np.float64]

TRACE, SAMPLES, PROGRAM = "trace.toml", "samples.csv", "run.csv"
RADIUS = 150.0  # mm, of the ball-bars that shops have
CALIBRATE = "noise = 0.001  # mm, standard deviation of a reading: put in that of your instrument"
MM = 1e3


@dataclass(frozen=True, repr=False)
class TrialMade:
    """A trial: its JSON report, one sentence for people, and the files that were written."""

    report: dict[str, Any]
    sentence: str
    files: tuple[Path, ...]


@dataclass(frozen=True)
class _Made:
    """The program of a trial, the text of its trace and samples, and what is to be told."""

    trial: TrialProgram
    trace: str
    samples: str
    report: dict[str, Any]
    sentence: str


@writes("output", "json")
def plan_trial_file(
    cell: Path,
    output: Path,
    *,
    ballbar: bool,
    model: Path | None = None,
    language: str | None = None,
    radius: float | None = None,
    center: tuple[float, float, float] | None = None,
    feeds: Sequence[float] = (),
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> TrialMade:
    """A cell in; a program, ``trace.toml``, ``samples.csv`` and ``run.csv`` beside each other out.

    Args:
        output: the program; a csv is the trace's own program, and there is no run.csv.
        ballbar: circles; else two-sided touches. model: of the robot; the cell names its own, and it takes no part.
        language: of the program, where its suffix does not tell it.
        radius: mm. center: mm, base. feeds: mm/min, of circles.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    _check(output, ballbar=ballbar, radius=radius, feeds=feeds)
    written_in = language_of(output, language)
    say("reading the cell")
    job = trial_job(load_cell(cell))
    refuse_study_frame(job)
    if model is not None and not robot_of(load_model(model)).same_kinematics(job.arm.robot):
        raise CompensatorError(f"{model}: is for another robot than {cell}; leave it out")
    at = None if center is None else job.placement.workobject.inward(np.array(center) / MM)
    names = (_beside(cell, output), output.name if written_in.table else PROGRAM)
    say("looking for circles" if ballbar else "looking for postures")
    if ballbar:
        made = _circles(job, radius or RADIUS, at, list(feeds or FEEDS), names=names)
    else:
        made = _touches(job, at, names)
    with Outputs() as outputs:
        say(f"writing {written_in.name}")
        with outputs.writing(output, written_in.writes) as staged:
            written = write_program(made.trial.program, staged, written_in.name)
            beside = list(written.files[1:])
            if not written_in.table:
                beside += write_program(made.trial.program, staged.with_name(PROGRAM), "csv").files
            for name, text in ((TRACE, made.trace), (SAMPLES, made.samples)):
                staged.with_name(name).write_bytes(text.encode())
                beside.append(staged.with_name(name))
        report = with_torques(made.report, made.trial.torque)
        found = [*of_kind("cell", job.findings), *of_kind("plan", _findings(job, report))]
        report["findings"] = findings_report([*found, *of_kind("program", written.findings)])
        refuse_warnings(report, strict)
        files = outputs.add(written.files[0], output, beside)
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    return TrialMade(report, made.sentence, (*files, *([json] if json else [])))


def _check(output: Path, *, ballbar: bool, radius: float | None, feeds: Sequence[float]) -> None:
    if output == STDOUT:
        raise CompensatorError(f"-: the plan is a program with {TRACE} and {SAMPLES} beside it; name a file")
    if radius is not None and not (ballbar and 20 <= radius <= 2000):
        raise CompensatorError(f"--radius {radius:g}: expected mm, 20 ... 2000, with --ballbar")
    bad = next((f for f in feeds if not (ballbar and 1 <= f <= 1e5)), None)
    if bad is not None:
        raise CompensatorError(f"--feed {bad:g}: expected mm/min, 1 ... 100000, with --ballbar")
    if output.name in (TRACE, SAMPLES):
        raise CompensatorError(f"{output}: is what the trace is called; give the program another name")
    refuse_filled_in(output, TRACE, SAMPLES)


def _beside(cell: Path, output: Path) -> str:
    """The cell as the trace names it."""
    return Path(os.path.relpath(cell.resolve(), output.resolve().parent)).as_posix()


def _circles(
    job: Job, radius: float, center: Floats | None, feeds: list[float], *, names: tuple[str, str]
) -> _Made:
    plan = ballbar_plan(job, radius / MM, center)
    trial = trial_program(job, ballbar_moves(plan, feeds), "BALLBAR", plan.circles[0].q[0])
    report = {"plan": "ballbar", **ballbar_report(plan, job.arm.robot.n, job.placement.workobject)}
    report |= {"feeds_mm_min": feeds, "n_readings": len(trial.rows)}
    columns = {"index": trial.rows.astype(float), "radius": np.full(len(trial.rows), np.nan), **trial.columns}
    x, y, z = report["center_mm"]
    order = TraceOrder(center=(x, y, z), radius=radius, dry=True)
    about = [f"circle {k}: {c.shape.words}, centre and radius below" for k, c in enumerate(plan.circles, 1)]
    trace = _trace(BALLBAR, order, names, ["Fill in the column radius of the samples, mm.", *about])
    circles = "one circle" if len(plan.circles) == 1 else f"{len(plan.circles)} circles"
    sentence = f"{circles} about {x:.0f}, {y:.0f}, {z:.0f} mm: joints told: {_told(report, 'circle')}"
    return _Made(trial=trial, trace=trace, samples=csv_text(columns), report=report, sentence=sentence)


def _touches(job: Job, center: Floats | None, names: tuple[str, str]) -> _Made:
    plan = probe_plan(job, center)
    if not plan.touches:
        why = f"joint 1: {plan.why_not(0)}"
        raise CompensatorError(f"{job.placement.source}: no touch tells the lost motion of a joint ({why})")
    trial = trial_program(job, probe_moves(job, plan), "PROBE", plan.touches[0].posture)
    report = {"plan": "probe", **probe_report(plan, job.arm.robot.n), "n_readings": len(trial.rows)}
    place = dict(zip("xyz", trial.position.T * MM, strict=True))
    normal = {name: trial.columns[name] for name in "ijk"}
    told = {name: v for name, v in trial.columns.items() if name not in "ijk"}
    empty = {"deviation": np.full(len(trial.rows), np.nan)}
    columns = {"index": trial.rows.astype(float), **place, **normal, **empty, **told}
    about = "Fill in the column deviation, mm: the gauge, positive along i, j, k; set to zero only where it is moved."
    trace = _trace(SURFACE, TraceOrder(frame=FREE), names, [about])
    sentence = f"{len(plan.touches)} two-sided touches tell joints {_told(report, 'touch')}"
    return _Made(trial=trial, trace=trace, samples=csv_text(columns), report=report, sentence=sentence)


def _trace(kind: str, order: TraceOrder, names: tuple[str, str], about: list[str]) -> str:
    cell, program = names
    return trace_toml(
        kind=kind,
        order=order,
        cell=cell,
        program=program,
        samples=SAMPLES,
        lead=["made by `compensator plan`; nothing is measured yet.", *about],
        noise_line=CALIBRATE,
    )


def _told(report: dict[str, Any], key: str) -> str:
    return ", ".join(str(j["joint"]) for j in report["joints"] if j[key] is not None) or "none"


def _span(torque: list[float]) -> str:
    return f"{torque[0]:.3g} to {torque[1]:.3g}"


def _findings(job: Job, report: dict[str, Any]) -> Iterator[Finding]:
    for j in report["joints"]:
        if j["why_not"]:
            yield Finding(WARNING, f"joint {j['joint']}", f"its lost motion is not told: {j['why_not']}")
    held = [j for j in report["joints"] if not j["why_not"] and j["weight_keeps_its_side"]]
    if held:
        listed = ", ".join(f"{j['joint']} ({_span(j['torque_nm'])} N*m)" for j in held)
        what = f"the weight keeps its sign on joints {listed}: a gap that it holds closed looks like a joint zero there"
        remedy = "Friction and a softer flank still show; a gap does where friction is above the torque"
        yield Finding(NOTE, "", what, remedy)
    if job.placement.start is None:
        what = "[start] is missing: the side that every joint comes from at first is not known"
        yield Finding(NOTE, job.placement.source, what, "Give [start] joints, and begin the program from there")
