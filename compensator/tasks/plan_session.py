"""`plan --program`: a program that drives to the set-ups of a plan, and the session that is filled in there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from compensator.errors import CompensatorError
from compensator.tasks.outputs import UNNAMED, Outputs
from compensator.tasks.run_files import STDOUT
from compensator.trials.session_template import postures_of, samples_text, session_text, stop_words
from stiffness.model.model import ComplianceModel
from stiffness.planning.plan import Plan
from stiffness.robot.load import builtin_robots
from stiffness.statics.tool import Tool
from toolpaths.files import language_of
from toolpaths.finding import NOTE, Finding
from toolpaths.languages.table import Language
from toolpaths.stop_programs import write_stops
from toolpaths.writing.stops import Stops

SESSION, SAMPLES = "session.toml", "samples.csv"
SPEED = 10  # % of the largest joint speeds
OVERSHOOT = np.radians(3.0)  # of every joint, on the side that the posture is approached from


def session_language(program: Path | None, name: str | None) -> Language | None:
    """The language of the program; None: there is none.

    Raises:
        CompensatorError: standard output takes no three files; a session stands there. WriteError: no language has
            this suffix.
    """
    if program == STDOUT:
        raise CompensatorError("-: --program is written with a session beside it; standard output takes one file")
    if program is None:
        return None
    refuse_filled_in(program, SESSION, SAMPLES)
    return language_of(program, name)


def refuse_filled_in(program: Path, *names: str) -> None:
    """Files to fill in are never written anew: they may hold a day of readings.

    Raises:
        CompensatorError: one of ``names`` stands beside the program.
    """
    for place in (program.parent / name for name in names):
        if place.exists():
            raise CompensatorError(f"{place}: stands there and may hold readings; give the plan a folder of its own")


def add_session(
    outputs: Outputs, program: Path, language: Language, *, plan: Plan, tool: Tool, model: ComplianceModel
) -> tuple[Path, ...]:
    """Stage the program, and beside it session.toml and samples.csv.

    Raises:
        CompensatorError: a file cannot be written there. WriteError: the language has no such programs.
    """
    with outputs.writing(program) as staged:
        write_stops(_stops(plan, model), staged, language, program.stem or UNNAMED)
        texts = {
            SESSION: session_text(plan, tool, model, robot=_robot(model, program), samples=SAMPLES),
            SAMPLES: samples_text(plan),
        }
        for name, text in texts.items():
            staged.with_name(name).write_bytes(text.encode())
    return outputs.add(staged, program, [staged.with_name(name) for name in texts])


def session_findings() -> Iterator[Finding]:
    """What has to be known before such a program runs."""
    what = "the program drives from posture to posture in joint moves; fixtures, walls and cables are not known to it"
    yield Finding(NOTE, "program", what, "Run it in single steps first; reorder or strike out set-ups", kind="plan")
    what = "session.toml has the planned loads and where reflectors are assumed to be"
    yield Finding(NOTE, SAMPLES, what, "Overwrite them with what was measured, then: compensator identify", kind="plan")


def _stops(plan: Plan, model: ComplianceModel) -> Stops:
    """Every posture, come to from the side that it is planned from."""
    q = postures_of(plan)
    side = plan.postures.approach[plan.candidates.posture[plan.chosen]]
    joints = np.stack([q - side * OVERSHOOT, q], axis=1).reshape(-1, q.shape[1])
    words = tuple(word for shown in stop_words(plan) for word in ("", shown))
    count = f"{len(q)} set-ups; {SAMPLES} has a row for every reading"
    remarks = (count, "not checked for collisions: in single steps first")
    return Stops(model.robot, remarks, joints, words=words, speed=SPEED)


def _robot(model: ComplianceModel, program: Path) -> str:
    """The robot as a file beside the program has to name it."""
    beside = Path(model.source).resolve().parent / model.robot
    if model.robot in builtin_robots() or not beside.exists():
        return model.robot
    return Path(os.path.relpath(beside, program.resolve().parent)).as_posix()
