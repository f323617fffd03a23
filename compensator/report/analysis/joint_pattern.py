"""The pattern of an addition that turns joints: their rotation over a torque or an angle."""

from __future__ import annotations

import numpy as np

from compensator.report.analysis.added_share import AddedShare, share_of_joint
from compensator.report.analysis.pattern import Pattern
from compensator.report.analysis.session_residuals import Floats, SessionResiduals
from compensator.report.analysis.state_motion import joint_rotation
from stiffness.diagnosis.result import AddedEffect
from stiffness.effects.effect import Effect

OWN = 0.5  # of what an addition explains: so much has to be rotation of a joint before it is drawn as one
SLIGHT = 0.01  # of what an addition explains: a joint that turns less is not drawn
FAINT = 0.2  # of the largest torque: below, a compliance cannot be read off
VANISHED = 0.3  # of the RMS of a rotation: below, it counts as zero where there is no torque


def turned_joints(effect: Effect, added: AddedEffect, shares: list[AddedShare]) -> list[int]:
    """The joints that an addition turns, most motion first; none where it explains mostly other motion."""
    if effect.thermal or not (effect.joint or effect.torque or effect.angle):
        return []
    named = [int(w.removeprefix("joint-")) - 1 for w in added.where if w.startswith("joint-")]
    of_joint = {j: share_of_joint(shares, j) for j in named or range(shares[0].one.session.robot.n)}
    first, *others = sorted(of_joint, key=lambda j: (-round(of_joint[j], 9), j))
    if of_joint[first] < OWN / len(of_joint):
        return []
    return [first, *(j for j in others if named and effect.site_kind == "joint" and of_joint[j] > SLIGHT)]


def joint_pattern(effect: Effect, j: int, shares: list[AddedShare]) -> Pattern:
    """Rotation of one joint over what the law follows."""
    x_name, x = _followed(effect, j, shares)
    columns = []
    for s, values in zip(shares, x, strict=True):
        after, at = joint_rotation(s.one, s.rows, j, s.after)
        columns.append(np.stack([values[at], after[at], s.rotation[at, j], s.torque(j)[at]]))
    across, after, explained, torque = np.concatenate(columns, axis=1)
    y_name, scale = f"rotation of joint {j + 1}, µrad", np.full(len(across), 1e6)
    follows_angle = x_name.startswith("angle") and effect.torque is None and effect.angle is None
    if follows_angle and _vanishes_without(torque, explained):
        loaded = np.abs(torque) > FAINT * np.abs(torque).max()
        across, after, explained, scale = across[loaded], after[loaded], explained[loaded], 1e6 / torque[loaded]
        y_name = f"rotation of joint {j + 1} over its torque, µrad/(N·m)"
    return Pattern(
        x_name=x_name,
        y_name=y_name,
        x=across,
        before=(after + explained) * scale,
        after=after * scale,
        explained=explained * scale,
    )


def _vanishes_without(torque: Floats, explained: Floats) -> bool:
    """Whether a rotation has a torque for a factor."""
    if not len(torque) or np.abs(torque).max() == 0:
        return False
    faint = np.abs(torque) < 0.5 * FAINT * np.abs(torque).max()
    whole = float(np.sqrt(np.mean(explained**2)))
    return bool(not faint.any() or np.sqrt(np.mean(explained[faint] ** 2)) < VANISHED * whole)


def _followed(effect: Effect, j: int, shares: list[AddedShare]) -> tuple[str, list[Floats]]:
    """What the rotation of a joint is drawn over: a torque or an angle, per load state."""
    if effect.site_kind == "pair":
        other = _partner(effect, j, shares[0].one)
        return f"torque of joint {other + 1}, N·m", [s.torque(other) for s in shares]
    if effect.memory is not None or effect.needs_torque_sign:
        return f"torque of joint {j + 1}, N·m", [s.torque(j) for s in shares]
    sessions = [s.one.session for s in shares]
    return f"angle of joint {j + 1}, deg", [np.degrees(s.samples.q[s.states.first, j]) for s in sessions]


def _partner(effect: Effect, j: int, one: SessionResiduals) -> int:
    """The joint that is coupled most with joint ``j``."""
    n, mine = one.session.robot.n, f"joint-{j + 1}"
    numbers = [one.fit.values()[effect.name][p.name] for p in effect.parameters if p.size == "pair"]
    strength = {
        next(w for w in site.where if w != mine): max((abs(float(v[site.index])) for v in numbers), default=0.0)
        for site in effect.sites(n)
        if site.index is not None and mine in site.where
    }
    return int(max(strength, key=lambda w: strength[w]).removeprefix("joint-")) - 1
