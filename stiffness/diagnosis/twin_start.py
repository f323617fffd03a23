"""Twin start: an effect that no reading at rest tells from another begins where it turns the joint as that one does."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import casadi as ca
import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from stiffness.diagnosis.added_effects import Addition
from stiffness.effects.effect import Effect, part_of
from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/diagnosis/test_balancing_struts.py
ENOUGH = 200  # angles that show a law
MOST = 4  # numbers that are told
ANOTHER = 0.05  # of the standard deviation of a motion: what differs by more somewhere is another one


def like_its_twin(fit: Fit, a: Addition, twin: Effect) -> list[Addition]:
    """The twin of an addition in a joint where both may be, with numbers that turn it alike at the angles of the
    readings, but for an offset, which is the joint's zero; the most alike first; empty where one of the two is no law
    of an angle.

    Args:
        fit: that has the addition. What its law does not reach, other numbers have taken: the most alike need not be
            the best.
    """
    n, values = fit.unknowns.joints, fit.values()
    site = next((s for s in twin.sites(n) if any(s.where == own.where for own in a.sites)), None)
    spring = next((e for e in fit.unknowns.effects if e.is_base), None)
    if site is None or spring is None:
        return []
    joint = part_of(site.where[0], n) - 1
    k = float(values[spring.name][spring.parameters[0].name][joint])
    free = [p for p in twin.parameters if not p.extra]
    counts = [len(range(p.count(n))[p.of_site(site.index)]) for p in free]
    at, x = ca.SX.sym("q", n), ca.SX.sym("x", sum(counts))
    named = {name: ca.SX(v) for name, v in twin.neutral(n).items()}
    for p, part in zip(free, ca.vertsplit(x, [0, *np.cumsum(counts).tolist()]), strict=True):
        named[p.name][p.of_site(site.index)] = part
    own = _rotation(a.effect, at, {name: ca.SX(v) for name, v in values[a.effect.name].items()}, joint=joint, k=k)
    other = _rotation(twin, at, named, joint=joint, k=k)
    if own is None or other is None:
        return []
    q = _angles(fit).T
    wanted = np.asarray(ca.Function("own", [at], [own])(q)).ravel()
    size = max(float(np.std(wanted)), 1e-12)
    turned, slope = (ca.Function("twin", [at, x], [f]) for f in (other, ca.jacobian(other, x)))

    def apart(numbers: Floats) -> Floats:
        off = np.asarray(turned(q, numbers)).ravel() - wanted
        return np.asarray((off - off.mean()) / size)

    def slopes(numbers: Floats) -> Floats:
        each = np.asarray(ca.DM(slope(q, numbers))).reshape(-1, len(numbers))
        return np.asarray((each - each.mean(axis=0)) / size)

    def at_site(numbers: Floats) -> dict[str, Floats]:
        out = twin.neutral(n)
        for p, part in zip(free, np.split(numbers, np.cumsum(counts)[:-1]), strict=True):
            out[p.name][p.of_site(site.index)] = part
        return out

    low, high, scale = (np.repeat([getattr(p, of) for p in free], counts) for of in ("low", "high", "scale"))
    shapes = [dict.fromkeys((p.start, *(p.trials if p.neutral is None else ()))) for p in free]
    starts = [np.repeat(chosen, counts) for chosen in product(*shapes)]
    found = [least_squares(apart, begun, slopes, bounds=(low, high), x_scale=scale) for begun in starts]
    found.sort(key=lambda r: r.cost)
    distinct = [r for k, r in enumerate(found) if all(np.abs(r.fun - f.fun).max() > ANOTHER for f in found[:k])]
    return [Addition(twin, (site,), frozenset(), at_site(r.x)) for r in distinct[:MOST]]


def _rotation(effect: Effect, q: ca.SX, numbers: Mapping[str, ca.SX], *, joint: int, k: float) -> ca.SX | None:
    """rad that an effect turns a joint of stiffness ``k``; None where it is no law of an angle."""
    law, share = (effect.angle, 1.0) if effect.angle is not None else (effect.torque, k)
    return None if law is None else law(q, numbers)[joint] / share


def _angles(fit: Fit) -> Floats:
    """(N, n) rad, of readings that take part, evenly thinned."""
    q = np.concatenate([s.session.samples.q[s.used] for s in fit.sessions])
    return np.asarray(q[np.unique(np.linspace(0, len(q) - 1, ENOUGH).astype(int))])
