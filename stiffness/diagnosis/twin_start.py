"""Twin start: an effect that no reading at rest tells from another begins where it turns the joint as that one does."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import casadi as ca
import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from stiffness.diagnosis.added_effects import Addition
from stiffness.effects.effect import Effect, Numbers, part_of
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
    own, other = (_rotation(e, joint, k, n) for e in (a.effect, twin))
    if own is None or other is None:
        return []
    q = _angles(fit)
    wanted = own(q, values[a.effect.name])
    size = max(float(np.std(wanted)), 1e-12)
    numbers = [p for p in twin.parameters if not p.extra]
    counts = [len(range(p.count(n))[p.of_site(site.index)]) for p in numbers]

    def at_site(x: Floats) -> dict[str, Floats]:
        out = twin.neutral(n)
        for p, part in zip(numbers, np.split(x, np.cumsum(counts)[:-1]), strict=True):
            out[p.name][p.of_site(site.index)] = part
        return out

    def apart(x: Floats) -> Floats:
        off = other(q, at_site(x)) - wanted
        return np.asarray((off - off.mean()) / size)

    low, high, scale = (np.repeat([getattr(p, of) for p in numbers], counts) for of in ("low", "high", "scale"))
    shapes = [dict.fromkeys((p.start, *(p.trials if p.neutral is None else ()))) for p in numbers]
    starts = [np.repeat(chosen, counts) for chosen in product(*shapes)]
    found = sorted((least_squares(apart, x, bounds=(low, high), x_scale=scale) for x in starts), key=lambda r: r.cost)
    distinct = [r for k, r in enumerate(found) if all(np.abs(r.fun - f.fun).max() > ANOTHER for f in found[:k])]
    return [Addition(twin, (site,), frozenset(), at_site(r.x)) for r in distinct[:MOST]]


def _rotation(effect: Effect, joint: int, k: float, joints: int) -> Callable[[Floats, Numbers], Floats] | None:
    """(angles (N, n) rad, numbers) -> (N,) rad that an effect turns a joint of stiffness ``k``."""
    law, share = (effect.angle, 1.0) if effect.angle is not None else (effect.torque, k)
    if law is None:
        return None
    q = ca.SX.sym("q", joints)
    names = {p.name: ca.SX.sym(p.name, p.count(joints)) for p in effect.parameters}
    turned = ca.Function("turned", [q, ca.vertcat(*names.values())], [law(q, names)[joint] / share])
    return lambda angles, p: np.asarray(turned(angles.T, np.concatenate([p[name] for name in names]))).ravel()


def _angles(fit: Fit) -> Floats:
    """(N, n) rad, of readings that take part, evenly thinned."""
    q = np.concatenate([s.session.samples.q[s.used] for s in fit.sessions])
    return np.asarray(q[np.unique(np.linspace(0, len(q) - 1, ENOUGH).astype(int))])
