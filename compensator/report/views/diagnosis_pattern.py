"""The evidence of an addition: the pattern that it explains, beside what it follows.

The refined fit is predicted once more without the addition: what that leaves is ``before``, what the refined fit
leaves is ``after``, and the difference is what the addition itself says. All three are brought to one number per load
state: the rotation of a joint, the motion of a place, or, for what is neither, the way the addition moves a reflector.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.report.views.diagnosis import Floats, Looked, in_base
from compensator.report.views.place_wrench import place_wrench
from compensator.report.views.state_motion import lever_of, place_number, turn, twist
from stiffness.diagnosis.result import Added, Diagnosis
from stiffness.effects import BY_NAME
from stiffness.effects.effect import Effect
from stiffness.identification.prediction import PredictedReadings

Index = npt.NDArray[np.intp]
OWN = 0.5  # of what an addition says: so much has to be rotation of a joint before it is drawn as one
SLIGHT = 0.01  # of what an addition says: a joint that turns less is not drawn
FAINT = 0.2  # of the largest torque: below, a compliance cannot be read off


@dataclass(frozen=True, repr=False, eq=False)
class Pattern:
    """One number per load state (or per reading): ``x`` with its words, and ``before``, ``says``, ``after``; nothing in
    ``says`` where there is no addition to say it; ``titles`` of before and after, "" where that is the same."""

    effect: str
    x_name: str
    y_name: str
    x: Floats
    before: Floats
    says: Floats
    after: Floats
    titles: tuple[str, str] = ("without it", "with it")


@dataclass(frozen=True, repr=False, eq=False)
class _Part:
    """One session: sound readings only; residuals and what the addition says of them, (M, 3) m in the base; ``turns``
    (S, n) rad: what it says of every joint's rotation in every state."""

    seen: Looked
    rows: Index
    says: Floats
    after: Floats
    turns: Floats


def patterns(d: Diagnosis, looked: tuple[Looked, ...], added: Added) -> list[Pattern]:
    """What is drawn of one addition: of joints one each, the one that moves the reflectors most first."""
    effect = BY_NAME[added.effect]
    without = d.fit.predicted_without(effect)
    parts = [_part(seen, without[seen.number]) for seen in looked]
    turned = _joints(effect, added, parts) if effect.joint or effect.torque or effect.angle else []
    if turned:
        return [_joint(effect, j, parts) for j in turned]
    if effect.place and not effect.joint:  # what fills both is geometry: no load makes it
        return [_place(added, parts)]
    return [_own_way(effect, added, parts)]


def _part(seen: Looked, without: PredictedReadings) -> _Part:
    rows = np.flatnonzero(seen.sound)
    says = in_base(seen.seen.position - without.position, seen.seen)[rows]
    first, n = seen.session.states.first, seen.session.robot.n
    turns = seen.seen.x[first, :n] - without.x[first, :n]
    return _Part(seen, rows, says, seen.after[rows], turns)


# ---- rotation of a joint


def _joints(effect: Effect, added: Added, parts: list[_Part]) -> list[int]:
    """The joints that an addition turns, most motion first; none where what it says is no rotation of joints."""
    named = [int(w.removeprefix("joint-")) - 1 for w in added.where if w.startswith("joint-")]
    every = named or range(parts[0].seen.session.robot.n)
    if effect.thermal:
        return []
    shares = {j: _share(parts, j) for j in every}
    order = sorted(shares, key=lambda j: (-round(shares[j], 9), j))
    if shares[order[0]] < OWN / len(shares):
        return []
    return [order[0], *(j for j in order[1:] if named and effect.site_kind == "joint" and shares[j] > SLIGHT)]


def _joint(effect: Effect, j: int, parts: list[_Part]) -> Pattern:
    """Rotation of one joint over what the law follows."""
    x_name, x = _follows(effect, j, parts)
    columns = []
    for p, values in zip(parts, x, strict=True):
        after, at = turn(p.seen, p.rows, j, p.after)
        columns.append(np.stack([values[at], after[at], p.turns[at, j], _state_torque(p, j)[at]]))
    across, after, says, torque = np.concatenate(columns, axis=1)
    name = f"rotation of joint {j + 1}, µrad"
    scale = np.full(len(across), 1e6)
    if x_name.startswith("angle") and effect.torque is None and effect.angle is None and _by_torque(says, torque):
        loaded = np.abs(torque) > FAINT * np.abs(torque).max()
        across, after, says, scale = across[loaded], after[loaded], says[loaded], 1e6 / torque[loaded]
        name = f"rotation of joint {j + 1} over its torque, µrad/(N·m)"
    return Pattern(effect.name, x_name, name, across, (after + says) * scale, says * scale, after * scale)


def _share(parts: list[_Part], j: int) -> float:
    """How much of what an addition says, as motion of the reflectors, is rotation of one joint."""
    whole = own = 0.0
    for p in parts:
        angle = p.turns[p.seen.session.states.of[p.rows], j]
        own += float(((lever_of(p.seen, p.rows, j) * angle[:, None]) ** 2).sum())
        whole += float((p.says**2).sum())
    return own / whole if whole > 0 else 0.0


def _by_torque(says: Floats, torque: Floats) -> bool:
    """Whether what an effect says has a torque for a factor: it vanishes with it."""
    if not len(torque) or np.abs(torque).max() == 0:
        return False
    faint = np.abs(torque) < 0.5 * FAINT * np.abs(torque).max()
    whole = float(np.sqrt(np.mean(says**2)))
    return bool(not faint.any() or np.sqrt(np.mean(says[faint] ** 2)) < 0.3 * whole)


def _follows(effect: Effect, j: int, parts: list[_Part]) -> tuple[str, list[Floats]]:
    """What the rotation of a joint is drawn over: a torque or an angle, per state."""
    if effect.site_kind == "pair":
        other = _partner(effect, j, parts[0].seen)
        return f"torque of joint {other + 1}, N·m", [_state_torque(p, other) for p in parts]
    if effect.memory is not None or effect.needs_torque_sign:
        return f"torque of joint {j + 1}, N·m", [_state_torque(p, j) for p in parts]
    angles = [np.degrees(p.seen.session.samples.q[p.seen.session.states.first, j]) for p in parts]
    return f"angle of joint {j + 1}, deg", angles


def _partner(effect: Effect, j: int, seen: Looked) -> int:
    """The joint that is coupled most with joint ``j``."""
    n, mine = seen.session.robot.n, f"joint-{j + 1}"
    numbers = [v for p in effect.parameters if p.size == "pair" for v in [seen.fit.values()[effect.name][p.name]]]
    strength = {
        next(w for w in site.where if w != mine): max((abs(float(v[site.index])) for v in numbers), default=0.0)
        for site in effect.sites(n)
        if site.index is not None and mine in site.where
    }
    return int(max(strength, key=lambda w: strength[w]).removeprefix("joint-")) - 1


def _state_torque(p: _Part, j: int) -> Floats:
    return np.asarray(p.seen.seen.torque[p.seen.session.states.first, j])


# ---- motion of a place


def _place(added: Added, parts: list[_Part]) -> Pattern:
    """The motion that the addition makes most of, over the load along it."""
    n = parts[0].seen.session.robot.n
    number = max(place_number(added.where[0], n), 0)
    columns = []
    for p in parts:
        says, lever, at = twist(p.seen, p.rows, number, p.says)
        after, _, _ = twist(p.seen, p.rows, number, p.after)
        load = place_wrench(p.seen.session, p.seen.geometry, number)[p.seen.session.states.first]
        columns.append((says[at], after[at], load[at], lever))
    says, after, load = (np.concatenate([c[i] for c in columns]) for i in range(3))
    size = np.sqrt(np.mean(says**2, axis=0)) * np.repeat([1.0, columns[0][3]], 3)
    c = int(np.argmax(size))
    axis, turning = "xyz"[c % 3], c >= 3
    words = "base" if number == 0 else "tool" if number == n else f"link {number}"
    x_name = f"{'moment' if turning else 'force'} on the {words} about its {axis} axis, N·m"
    if not turning:
        x_name = f"force on the {words} along its {axis} axis, N"
    y_name = f"{'rotation' if turning else 'motion'} of the {words}, {'µrad' if turning else 'µm'}"
    return Pattern(
        added.effect, x_name, y_name, load[:, c], 1e6 * (after + says)[:, c], 1e6 * says[:, c], 1e6 * after[:, c]
    )


# ---- neither


def _own_way(effect: Effect, added: Added, parts: list[_Part]) -> Pattern:
    """Along the way that the addition moves each reading, over how far, or over time or temperature."""
    columns = []
    x_name = "what was added says, mm"
    for p in parts:
        length = np.linalg.norm(p.says, axis=1)
        told = length > 0.02 * np.max(length, initial=0.0)
        way = p.says[told] / length[told, None]
        x, sign = length[told] * 1e3, np.ones(int(told.sum()))
        samples = p.seen.session.samples
        if effect.position_reading and np.isfinite(samples.time).all():
            x_name, x = "time, s", samples.time[p.rows][told]
        elif effect.thermal and np.isfinite(samples.temperature).all():
            x_name, x = "temperature, deg C", samples.temperature[p.rows][told]
            reference = p.seen.session.reference_temperature
            sign = np.where(x < (20.0 if reference is None else reference), -1.0, 1.0)
        after = sign * (p.after[told] * way).sum(axis=1)
        columns.append(np.stack([x, 1e3 * after, 1e3 * sign * length[told]]))
    across, after, says = np.concatenate(columns, axis=1)
    y_name = "along the way that it moves a reflector, mm"
    return Pattern(added.effect, x_name, y_name, across, after + says, says, after)
