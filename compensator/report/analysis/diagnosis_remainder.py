"""What is left when no effect explains it: the motion of the place that it points at, over what it follows."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from compensator.report.analysis.diagnosis import Floats, Looked
from compensator.report.analysis.diagnosis_pattern import Pattern
from compensator.report.analysis.state_motion import place_number, turn, twist
from stiffness.diagnosis.result import Diagnosis


def remainder(d: Diagnosis, looked: tuple[Looked, ...]) -> Pattern | None:
    """The pattern of the residual; None where nothing names a place or what it follows."""
    place = next((s for s in d.points_at if not s.what.startswith("column:")), None)
    column = next((s for s in d.points_at if s.what.startswith("column:")), None)
    if place is None:
        return None
    asked = [column.what.removeprefix("column:")] if column is not None and column.share > place.share else []
    for follows in [*asked, *place.follows.split("; ")]:
        x = [found for seen in looked if (found := _along(seen, follows)) is not None]
        if len(x) == len(looked):
            drawn = _drawn(looked, place.what, x[0][0], [values for _, values in x])
            return replace(drawn, titles=("model at hand", "refined" if d.added or d.changed else ""))
    return None


def _along(seen: Looked, follows: str) -> tuple[str, Floats] | None:
    """A regressor (S,) of a session's states and its words for an axis; a column of the file is not named there."""
    s, first = seen.session.samples, seen.session.states.first
    if found := re.fullmatch(r"(?:q|angle of joint )(\d+)", follows):
        return f"angle of joint {found[1]}, deg", np.degrees(s.q[first, int(found[1]) - 1])
    if found := re.fullmatch(r"approach(?: of joint )?(\d+).*", follows):
        return f"approach of joint {found[1]}", s.approach[first, int(found[1]) - 1].astype(float)
    if found := re.fullmatch(r"(?:torque of|size of its torque,|sign of its torque,) joint (\d+)", follows):
        return f"torque of joint {found[1]}, N·m", seen.seen.torque[first, int(found[1]) - 1]
    known = {"time": ("time, s", s.time), "temperature": ("temperature, deg C", s.temperature)}
    name, values = known.get(follows, ("the column that it follows", s.extra.get(follows, np.empty(0))))
    return (name, values[first]) if len(values) and np.isfinite(values[first]).all() else None


def _drawn(looked: tuple[Looked, ...], place: str, x_name: str, x: list[Floats]) -> Pattern:
    n = looked[0].session.robot.n
    rows = [np.flatnonzero(seen.sound) for seen in looked]
    if place.startswith("joint-"):
        j = int(place.removeprefix("joint-")) - 1
        columns = []
        for seen, some, across in zip(looked, rows, x, strict=True):
            before, told = turn(seen, some, j, seen.before[some])
            after, _ = turn(seen, some, j, seen.after[some])
            columns.append(np.stack([across[told], before[told] * 1e6, after[told] * 1e6]))
        across, before, after = np.concatenate(columns, axis=1)
        return Pattern("", x_name, f"rotation of joint {j + 1}, µrad", across, before, np.empty(0), after)
    number = place_number(place, n)
    moved = [[twist(s, r, number, v[r]) for v in (s.before, s.after)] for s, r in zip(looked, rows, strict=True)]
    before, after = (np.concatenate([m[k][0][m[k][2]] for m in moved]) for k in (0, 1))
    size = np.sqrt(np.mean(after**2, axis=0)) * np.repeat([1.0, moved[0][0][1]], 3)
    c = int(np.argmax(size))
    across = np.concatenate([values[m[0][2]] for values, m in zip(x, moved, strict=True)])
    what = f"{'rotation about' if c >= 3 else 'motion along'} {'xyz'[c % 3]} of the {place.replace('-', ' ')}"
    y_name = f"{what}, {'µrad' if c >= 3 else 'µm'}"
    return Pattern("", x_name, y_name, across, before[:, c] * 1e6, np.empty(0), after[:, c] * 1e6)
