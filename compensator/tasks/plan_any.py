"""Which plan is asked for: set-ups for a tracker, circles for a ball-bar, touches for a dial gauge."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.tasks.plan import COUNT, Planned, plan_file
from compensator.tasks.plan_trial import TrialMade, plan_trial_file
from compensator.tasks.say import Say, quiet


def plan_any(
    model: Path | None,
    output: Path,
    *,
    ballbar: bool = False,
    probe: bool = False,
    cell: Path | None = None,
    language: str | None = None,
    radius: float | None = None,
    center: tuple[float, float, float] | None = None,
    feeds: Sequence[float] = (),
    sessions: Sequence[Path] = (),
    count: int | None = None,
    force: float | None = None,
    toolpath: Path | None = None,
    seed: int | None = None,
    json: Path | None = None,
    program: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Planned | TrialMade:
    """The plan that the options ask for; those of another one are refused.

    Raises:
        ToolpathError, StiffnessError, CompensatorError: refused; no output is left behind.
    """
    of_setups = {"--session": sessions, "--count": count, "--force": force, "--toolpath": toolpath, "--seed": seed}
    of_setups["--program"] = program
    of_trials = {"--format": language, "--radius": radius, "--center": center, "--feed": feeds}
    if not (ballbar or probe):
        if program is not None:
            del of_trials["--format"]
        _refuse_given(of_trials, "to --ballbar or --probe")
        if model is None:
            raise CompensatorError("MODEL is missing: give the model to be known better, or --ballbar or --probe")
        return plan_file(
            model,
            output,
            sessions=sessions,
            count=COUNT if count is None else count,
            force=force,
            toolpath=toolpath,
            cell=cell,
            seed=seed or 0,
            json=json,
            program=program,
            language=language,
            strict=strict,
            say=say,
        )
    if ballbar and probe:
        raise CompensatorError("--ballbar and --probe: a program for each; give one of them")
    _refuse_given(of_setups, "to a plan of set-ups")
    if cell is None:
        which = "--ballbar" if ballbar else "--probe"
        raise CompensatorError(f"{which}: give --cell CELL.toml: the robot, its tool, and where it works")
    return plan_trial_file(
        cell,
        output,
        model=model,
        ballbar=ballbar,
        language=language,
        radius=radius,
        center=center,
        feeds=feeds,
        json=json,
        strict=strict,
        say=say,
    )


def _refuse_given(options: dict[str, Any], belongs: str) -> None:
    given = [name for name, value in options.items() if value not in (None, ())]
    if given:
        raise CompensatorError(f"{', '.join(given)}: belongs {belongs}; leave it out")
