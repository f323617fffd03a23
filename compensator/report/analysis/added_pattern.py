"""The evidence of an addition: the pattern that it explains, over what it follows.

Residuals without it and with it are brought to one number per load state: the rotation of a joint, the displacement of
a place, or, for what is neither, the way that the addition moves a reflector.
"""

from __future__ import annotations

import numpy as np

from compensator.report.analysis.added_share import AddedShare, added_share
from compensator.report.analysis.joint_pattern import joint_pattern, turned_joints
from compensator.report.analysis.loads import place_wrench
from compensator.report.analysis.pattern import Pattern
from compensator.report.analysis.session_residuals import SessionResiduals
from compensator.report.analysis.state_motion import place_displacement
from stiffness.diagnosis.result import AddedEffect, Diagnosis
from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect, part_of

CLEAR = 0.02  # of the largest motion that an addition explains: below, it has no direction


def added_patterns(d: Diagnosis, sessions: tuple[SessionResiduals, ...], added: AddedEffect) -> list[Pattern]:
    """What is drawn of one addition: of joints one each, the one that moves the reflectors most first."""
    effect = BY_NAME[added.effect]
    without = d.fit.predicted_without(effect)
    shares = [added_share(one, without[one.number]) for one in sessions]
    turned = turned_joints(effect, added, shares)
    if turned:
        return [joint_pattern(effect, j, shares) for j in turned]
    if effect.place and not effect.joint:  # what fills both is geometry: no load makes it
        return [_place(added, shares)]
    return [_own_way(effect, shares)]


def _place(added: AddedEffect, shares: list[AddedShare]) -> Pattern:
    """The displacement that the addition makes most of, over the load along it."""
    n = shares[0].one.session.robot.n
    place = part_of(added.where[0], n)
    columns = []
    for s in shares:
        explained, lever, at = place_displacement(s.one, s.rows, place, s.explained)
        after, _, _ = place_displacement(s.one, s.rows, place, s.after)
        load = place_wrench(s.one.session, s.one.arm, place)[s.one.session.states.first]
        columns.append((explained[at], after[at], load[at], lever))
    explained, after, load = (np.concatenate([c[i] for c in columns]) for i in range(3))
    size = np.sqrt(np.mean(explained**2, axis=0)) * np.repeat([1.0, columns[0][3]], 3)
    c = int(np.argmax(size))
    axis, turning = "xyz"[c % 3], c >= 3
    words = "base" if place == 0 else "tool" if place == n else f"link {place}"
    x_name = f"force on the {words} along its {axis} axis, N"
    if turning:
        x_name = f"moment on the {words} about its {axis} axis, N·m"
    return Pattern(
        x_name=x_name,
        y_name=f"{'rotation' if turning else 'motion'} of the {words}, {'µrad' if turning else 'µm'}",
        x=load[:, c],
        before=1e6 * (after + explained)[:, c],
        after=1e6 * after[:, c],
        explained=1e6 * explained[:, c],
    )


def _own_way(effect: Effect, shares: list[AddedShare]) -> Pattern:
    """Along the way that the addition moves each reading, over how far, or over time or temperature."""
    columns = []
    x_name = "what was added says, mm"
    for s in shares:
        length = np.linalg.norm(s.explained, axis=1)
        clear = length > CLEAR * np.max(length, initial=0.0)
        way = s.explained[clear] / length[clear, None]
        x, sign = length[clear] * 1e3, np.ones(int(clear.sum()))
        samples = s.one.session.samples
        if effect.position_reading and np.isfinite(samples.time).all():
            x_name, x = "time, s", samples.time[s.rows][clear]
        elif effect.thermal and np.isfinite(samples.temperature).all():
            x_name, x = "temperature, deg C", samples.temperature[s.rows][clear]
            reference = s.one.session.reference_temperature
            sign = np.where(x < (20.0 if reference is None else reference), -1.0, 1.0)
        after = sign * (s.after[clear] * way).sum(axis=1)
        columns.append(np.stack([x, 1e3 * after, 1e3 * sign * length[clear]]))
    x, after, explained = np.concatenate(columns, axis=1)
    return Pattern(
        x_name=x_name,
        y_name="along the way that it moves a reflector, mm",
        x=x,
        before=after + explained,
        after=after,
        explained=explained,
    )
