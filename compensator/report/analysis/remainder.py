"""What is left when no effect explains it: the motion of the place that it points at, over what it follows."""

from __future__ import annotations

import re

import numpy as np

from compensator.report.analysis.pattern import Pattern
from compensator.report.analysis.session_residuals import Floats, SessionResiduals
from compensator.report.analysis.state_motion import joint_rotation, place_displacement
from stiffness.diagnosis.result import Diagnosis
from stiffness.effects.effect import part_of


def remainder(d: Diagnosis, sessions: tuple[SessionResiduals, ...]) -> Pattern | None:
    """The pattern of the residual; None where nothing names a place or what it follows."""
    place = next((s for s in d.residual_sources if s.is_place), None)
    column = next((s for s in d.residual_sources if not s.is_place), None)
    if place is None:
        return None
    leading = [column.what.removeprefix("column:")] if column is not None and column.fraction > place.fraction else []
    titles = ("model at hand", "refined" if d.added or d.changed else "")
    for follows in [*leading, *place.follows.split("; ")]:
        x = [found for one in sessions if (found := _regressor(one, follows)) is not None]
        if len(x) == len(sessions):
            y_name, (across, before, after) = _motion(sessions, place.what, [values for _, values in x])
            return Pattern(
                x_name=x[0][0],
                y_name=y_name,
                x=across,
                before=before * 1e6,
                after=after * 1e6,
                explained=np.empty(0),
                titles=titles,
            )
    return None


def _regressor(one: SessionResiduals, follows: str) -> tuple[str, Floats] | None:
    """A regressor (S,) of a session's states and its words for an axis; a column of the file is not named there."""
    s, first = one.session.samples, one.session.states.first
    if found := re.fullmatch(r"(?:q|angle of joint )(\d+)", follows):
        return f"angle of joint {found[1]}, deg", np.degrees(s.q[first, int(found[1]) - 1])
    if found := re.fullmatch(r"approach(?: of joint )?(\d+).*", follows):
        return f"approach of joint {found[1]}", s.approach[first, int(found[1]) - 1].astype(float)
    if found := re.fullmatch(r"(?:torque of|size of its torque,|sign of its torque,) joint (\d+)", follows):
        return f"torque of joint {found[1]}, N·m", one.predicted.torque[first, int(found[1]) - 1]
    known = {"time": ("time, s", s.time), "temperature": ("temperature, deg C", s.temperature)}
    name, values = known.get(follows, ("the column that it follows", s.extra.get(follows, np.empty(0))))
    return (name, values[first]) if len(values) and np.isfinite(values[first]).all() else None


def _motion(sessions: tuple[SessionResiduals, ...], place: str, x: list[Floats]) -> tuple[str, Floats]:
    """Words for an axis, and (3, K): the regressor, and the motion of the place before and after, m or rad."""
    if place.startswith("joint-"):
        return _rotation(sessions, int(place.removeprefix("joint-")) - 1, x)
    return _displacement(sessions, place, x)


def _rotation(sessions: tuple[SessionResiduals, ...], j: int, x: list[Floats]) -> tuple[str, Floats]:
    columns = []
    for one, across in zip(sessions, x, strict=True):
        rows = np.flatnonzero(one.sound)
        before, told = joint_rotation(one, rows, j, one.before[rows])
        after, _ = joint_rotation(one, rows, j, one.after[rows])
        columns.append(np.stack([across[told], before[told], after[told]]))
    return f"rotation of joint {j + 1}, µrad", np.concatenate(columns, axis=1)


def _displacement(sessions: tuple[SessionResiduals, ...], place: str, x: list[Floats]) -> tuple[str, Floats]:
    """Of the six coordinates the one that is left most."""
    part = part_of(place, sessions[0].session.robot.n)
    columns, lever = [], 1.0
    for k, (one, across) in enumerate(zip(sessions, x, strict=True)):
        rows = np.flatnonzero(one.sound)
        before, reach, told = place_displacement(one, rows, part, one.before[rows])
        after, _, _ = place_displacement(one, rows, part, one.after[rows])
        lever = reach if k == 0 else lever
        columns.append(np.hstack([across[told, None], before[told], after[told]]))
    found = np.concatenate(columns)
    size = np.sqrt(np.mean(found[:, 7:] ** 2, axis=0)) * np.repeat([1.0, lever], 3)
    c = int(np.argmax(size))
    way = f"{'rotation about' if c >= 3 else 'motion along'} {'xyz'[c % 3]} of the {place.replace('-', ' ')}"
    return f"{way}, {'µrad' if c >= 3 else 'µm'}", found[:, [0, 1 + c, 7 + c]].T
