"""Beyond the catalogue: causes that no effect has, against effects that imitate them on one path.

A joint that its servo lets lag looks like play along a circle, and a fixture that gives way looks like a base that
does. A few numbers of the linearised model tell whether the cause itself would be the simpler explanation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffness.diagnosis.attribution import by_fixture, by_speed
from stiffness.diagnosis.linear_fit import NormalEquations
from stiffness.diagnosis.search import ODDS, Search, bic, like_noise
from stiffness.identification.fit import Fit
from stiffness.session.session import traces_alone

# studied in tests/traces_report
SLIGHT = 0.1  # of what was above the noise: so much a linear model may leave of it


@dataclass(frozen=True)
class Beyond:
    """A cause in no catalogue that explains what a fit left; ``words`` for the report, ``cost`` (BIC)."""

    words: str
    cost: float


def beyond_catalogue(search: Search, base: Fit, fit: Fit) -> Beyond | None:
    """The cheapest cause in no catalogue that explains what ``base`` leaves of traces, clearly with less than the
    effects of ``fit`` do; None where there is none.

    A fixture is one only where those leave more than noise: seen from the part, a base that gives way is the same.
    """
    if not traces_alone(s.session for s in base.sessions):
        return None
    found = []
    joints, speeds = by_speed(base, search.sensitivities) or ((), None)
    if (chosen := _fewest(speeds, base)) is not None:
        which = " and ".join(f"joint {j + 1}" for j in sorted(joints[c] for c in chosen[0]))
        found.append(Beyond(f"a lag that grows with the speed of {which}", chosen[1]))
    fixture = None if like_noise(fit) else by_fixture(base, search.sensitivities)
    if (chosen := _fewest(fixture, base)) is not None:
        found.append(Beyond("a fixture that gives way to the programmed force", chosen[1]))
    best = min(found, key=lambda b: b.cost, default=None)
    return best if best is not None and best.cost + ODDS < bic(fit, 1.0) else None


def _fewest(equations: NormalEquations | None, base: Fit) -> tuple[list[int], float] | None:
    """Columns, one after the other as long as each lowers the BIC, that explain what was left; and that BIC."""
    if equations is None:
        return None
    price = float(np.log(max(base.solution.count, 8)))
    chosen: list[int] = []
    gain, best = 0.0, bic(base, 1.0)
    every = range(len(equations.reduced.slope))
    while rest := [c for c in every if c not in chosen]:
        gains = {c: equations.fit([*chosen, c], [False] * (len(chosen) + 1)).gain for c in rest}
        top = max(rest, key=lambda c: gains[c])
        cost = bic(base, 1.0) - gains[top] + (len(chosen) + 1) * price
        if cost >= best:
            break
        chosen, gain, best = [*chosen, top], gains[top], cost
    above = base.solution.chi2 - base.solution.freedom
    return (chosen, best) if chosen and gain > (1 - SLIGHT) * above else None
