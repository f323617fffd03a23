"""The set-ups with the largest residuals, each with the arm as it stood: what the residual map draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compensator.report.analysis.session_residuals import Floats, Index, Ints, SessionResiduals


@dataclass(frozen=True, repr=False, eq=False)
class SetupResiduals:
    """One set-up; m, in the base.

    Attributes:
        session, setup: the number of the session, from 0, and that of the set-up in its file.
        skeleton: (K, 3) base, joints and flange in order.
        reflector: (M, 3) reflectors, and ``link``: (M, 3) the point of the skeleton that each is fixed to.
        read_at: (R, 3) where readings are; before, after: (R, 3) their residuals.
        number: (R,) of the reflector of each reading, from 1.
        size: RMS of ``before``, which set-ups are ordered by.
    """

    session: int
    setup: int
    skeleton: Floats
    reflector: Floats
    link: Floats
    read_at: Floats
    before: Floats
    after: Floats
    number: Ints
    size: float


def largest_setups(sessions: tuple[SessionResiduals, ...], limit: int) -> list[SetupResiduals]:
    """The set-ups with the largest residuals before, largest first."""
    out = []
    for k, one in enumerate(sessions):
        s = one.session.samples
        for setup in np.unique(s.setup):
            rows = np.flatnonzero((s.setup == setup) & one.sound)
            if len(rows):
                out.append(_setup(one, k, int(setup), rows))
    return sorted(out, key=lambda found: (-round(found.size, 9), found.session, found.setup))[:limit]


def _setup(one: SessionResiduals, session: int, setup: int, rows: Index) -> SetupResiduals:
    s = one.session.samples
    links, pivots = one.arm.links.origin[rows[0]], one.arm.pivot[rows[0]]
    skeleton = [links[0]]
    for k in range(len(pivots)):
        skeleton += [pivots[k], links[k + 1]]
    numbers = np.unique(s.reflector[rows])
    first = np.array([rows[s.reflector[rows] == r][0] for r in numbers])
    return SetupResiduals(
        session=session,
        setup=setup,
        skeleton=np.array(skeleton),
        reflector=one.reflector[first],
        link=links[[one.session.reflectors[int(r)].link for r in numbers]],
        read_at=one.reflector[rows],
        before=one.before[rows],
        after=one.after[rows],
        number=s.reflector[rows] + 1,
        size=float(np.sqrt(np.mean(one.before[rows] ** 2))),
    )
