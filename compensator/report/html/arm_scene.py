"""The arm with its residuals at the head of the pages of ``identify`` and ``diagnose``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator.report.analysis.predicted import PredictedSession
from compensator.report.analysis.session_residuals import SessionResiduals, in_base
from compensator.report.analysis.undeflected import undeflected
from compensator.report.figures.drawing import Warn
from compensator.report.scene.residual_scene import ArmReadings, mean_residuals, residual_scene
from compensator.report.words.numbers import deflection_mm
from stiffness.robot.robot import Robot
from stiffness.session.session import Session

MM = 1e3


def of_diagnosis(residuals: Sequence[SessionResiduals]) -> list[ArmReadings]:
    """The readings of a diagnosis: with the model at hand, and with the refined one."""
    return [
        ArmReadings(
            q=r.session.samples.q, links=r.arm.links, setup=_setups(r.session), reflector=r.session.samples.reflector,
            link=r.link, at=r.reflector, before=r.before, after=r.after, sound=r.sound,
        )
        for r in residuals
    ]  # fmt: skip


def of_fit(sessions: Sequence[PredictedSession]) -> list[ArmReadings]:
    """The readings of a fit: with a rigid arm, and with the fit."""
    out = []
    for one in sessions:
        session, s = one.fit.session, one.fit.samples
        arm = undeflected(session.robot, s.q)
        link = np.array([r.link for r in session.reflectors])[s.reflector]
        out.append(
            ArmReadings(
                q=s.q, links=arm.links, setup=_setups(session), reflector=s.reflector, link=link,
                at=arm.link_of_each(link).at(one.fit.reflectors[s.reflector]),
                before=in_base(s.position - one.rigid.position, one.rigid),
                after=in_base(s.position - one.fit.predicted.position, one.fit.predicted), sound=one.fit.used,
            )
        )  # fmt: skip
    return out


def _setups(session: Session) -> Any:
    """Numbers of set-ups; along a path every reading has a posture of its own."""
    return session.samples.setup if session.path is None else np.arange(len(session.samples))


def drawn_scene(
    readings: Sequence[ArmReadings], robot: Robot, warn: Warn, *, refined: bool = True
) -> dict[str, Any] | None:
    """The scene; None where it cannot be made, which costs no number of the page."""
    try:
        return residual_scene(robot, readings, refined=refined)
    except Exception as error:
        warn(f"the arm of the report could not be drawn ({type(error).__name__}: {error}); everything else is complete")
        return None


def meaning(readings: Sequence[ArmReadings], *, refined: bool, models: tuple[str, str]) -> str:
    """What the residuals are worth for a part that is cut like this: one sentence.

    Args:
        models: what ``before`` and ``after`` were predicted with.
    """
    before, after = (deflection_mm(v * MM) for v in mean_residuals(readings))
    then = f", {after} mm with {models[1]}" if refined else ""
    return (
        f"In these postures and under these loads a part comes out {before} mm off on average with {models[0]}{then} "
        "(the noise of the measurement included)."
    )
