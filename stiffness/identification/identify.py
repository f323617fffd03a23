"""Global identification: all readings of all sessions at once, on the statics that prediction uses.

The robot's parameters are shared, tracker poses and roughly known reflectors are each session's own. Wrong rows are
found and left out; what the data do not determine is said and not invented.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.effects import BY_NAME, CATALOGUE
from stiffness.effects.effect import Effect, Numbers
from stiffness.errors import StiffnessError
from stiffness.identification.fit import Fit, columns_of, loose_sd
from stiffness.identification.plausibility import doubts
from stiffness.identification.session_fit import Evidence
from stiffness.identification.unknowns import Unknowns, start_values, unknowns
from stiffness.model.model import ComplianceModel
from stiffness.numerics.least_squares import Whitened, solve
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

FALSE_ALARM = 1e-4  # chance that a clean session loses a row
CHANCE = 1e-3  # chance that an effect is taken up which is not there
OUTLIER_ROUNDS = 8
MOST_RECONSIDERED = 60  # rows left out that are looked at again one by one
OFFSET = 0.02  # m; kinematics that are not fitted are not better known than this


def identify(
    sessions: Sequence[Session], effects: Sequence[str] | None = None, prior: ComplianceModel | None = None
) -> Fit:
    """Fit a model to sessions of one robot.

    Args:
        effects: names that fix the set; None: joint stiffness, kinematic offsets where positions say
            something of them, and backlash or preload softening where the data ask for it.
        prior: values to start from; its standard deviations are prior knowledge.

    Raises:
        StiffnessError: the sessions are not of one robot, or nothing in them can be fitted.
    """
    one_robot(sessions)
    if effects is not None:
        return _robust(sessions, _named(effects), prior, ())
    base = ["joint-stiffness"] if any(s.has_displacement for s in sessions) or _sag(sessions) else []
    absolute = any(s.has_absolute for s in sessions)
    names = base + (["kinematic-offset"] if absolute else [])
    if prior is not None:  # what is known of the robot stays in its model
        names += [e.name for e in prior.effects if e.name not in names and e.scope != "instruments"]
    if not names:
        raise StiffnessError(
            f"{sessions[0].source}: nothing to identify: no loaded state beside an unloaded one, and the positions "
            "only place the tracker and its reflectors"
        )
    fit = _robust(sessions, _named(names), prior, ())
    return _with_memory(sessions, names, fit, prior)


def _sag(sessions: Sequence[Session]) -> bool:
    return any(s.gravity == "uncompensated" and s.has_absolute for s in sessions)


def _named(names: Sequence[str]) -> tuple[Effect, ...]:
    unknown = [n for n in names if n not in BY_NAME]
    if unknown:
        raise StiffnessError(f"unknown effect {', '.join(unknown)}; known are {', '.join(BY_NAME)}")
    wanted = {*names, "joint-stiffness"}
    return tuple(e for e in CATALOGUE if e.name in wanted)


def one_robot(sessions: Sequence[Session]) -> None:
    """Refuse sessions of different robots."""
    first = sessions[0]
    for s in sessions[1:]:
        if not s.robot.same_kinematics(first.robot) or s.gravity != first.gravity:
            raise StiffnessError(
                f"{s.source}: robot {s.robot.name} with gravity {s.gravity!r} is not that of {first.source} "
                f"({first.robot.name}, {first.gravity!r}); identify takes several sessions of one robot"
            )


def _with_memory(sessions: Sequence[Session], names: list[str], fit: Fit, prior: ComplianceModel | None) -> Fit:
    """Add backlash or preload softening where approach and two load levels are there and the data ask for it."""
    if not any(np.any(s.samples.approach != 0) for s in sessions):
        return fit
    if not any(_load_levels(s) > 1 for s in sessions):
        note = "one load level: a gap between flanks and a softer flank cannot be told apart; neither is fitted"
        return replace(fit, notes=(*fit.notes, note))
    best, gain = fit, 0.0
    for name in ("backlash", "preload-softening"):
        trial = _robust(sessions, _named([*names, name]), prior, (), [e.used for e in fit.evidence])
        free = sum(u.effect == name for u in trial.unknowns.free)
        scale = max(fit.solution.misfit, 1.0) ** 2
        drop = (fit.solution.chi2 - trial.solution.chi2) / scale
        if stats.chi2.sf(max(drop, 0.0), free) < CHANCE / 2 and drop > gain:
            note = f"{name}: chi-square falls by {drop:.0f} for {free} numbers"
            best, gain = replace(trial, notes=(*trial.notes, note)), drop
    return best if best is fit else reconsidered(best, prior)


def _load_levels(session: Session) -> int:
    """How many sizes of wrench a session has, apart by a third at least."""
    size = np.linalg.norm(session.samples.load.wrench[:, :3], axis=1)
    loaded = np.sort(size[size > 0.1 * size.max()]) if size.any() else np.empty(0)
    return 0 if not len(loaded) else 1 + int(loaded[-1] > 1.3 * loaded[0])


def _robust(
    sessions: Sequence[Session],
    effects: tuple[Effect, ...],
    prior: ComplianceModel | None,
    notes: tuple[str, ...],
    used: Sequence[npt.NDArray[np.bool_]] | None = None,
) -> Fit:
    """Fit, look for rows that the others contradict, leave them out, fit again."""
    joints = sessions[0].robot.n
    fixed = start_values(effects, joints)
    if prior is not None:
        for name, numbers in prior.values.items():
            if name in fixed:
                fixed[name].update({k: np.array(v) for k, v in numbers.items()})
    layout = unknowns(effects, joints, extras=True)
    evidence = tuple(Evidence(s, layout, fixed) for s in sessions)
    for e, mask in zip(evidence, used or (), strict=False):
        e.used = mask.copy()
    absolute = any(e.unloaded for e in effects)
    offset = 0.0 if absolute else OFFSET
    fit = fitted(layout, fixed, evidence, offset, prior, notes)
    fit = cleaned(fit, prior)
    return replace(fit, notes=(*notes, *doubts(fit)))


def cleaned(fit: Fit, prior: ComplianceModel | None) -> Fit:
    """Without the rows that the others contradict."""
    for _ in range(OUTLIER_ROUNDS):
        if not _leave_out(fit):
            break
        fit = _again(fit, prior)
    return _again(fit, prior) if _take_back(fit) else fit


def _take_back(fit: Fit) -> bool:
    """Rows that were dropped while a wrong one still disturbed the fit, one by one; True when there were any."""
    found = False
    for k, e in enumerate(fit.evidence):
        out = np.flatnonzero(~e.used & e.allowed)
        at = columns_of(fit.evidence, len(fit.unknowns))[k]
        limit = stats.chi2.isf(FALSE_ALARM / max(int(e.used.sum()), 1), 3)
        for row in out if len(out) <= MOST_RECONSIDERED and not e.session.group.max() >= 0 else ():
            e.used[row] = True
            mine = [np.inf]
            for block in e.blocks(fit.parameters, fit.station(k), fit.offset, at, at.stop):
                if row in block.rows:
                    rows, score, _ = e.deletion(block)
                    mine = [s for r, s in zip(rows, score, strict=True) if row in r]
            e.used[row] = bool(mine[0] <= limit * fit.solution.misfit**2)
            found |= bool(e.used[row])
    return found


def _again(fit: Fit, prior: ComplianceModel | None) -> Fit:
    return fitted(fit.unknowns, fit.fixed, fit.evidence, fit.offset, prior, fit.notes, fit.solution.vector)


def reconsidered(fit: Fit, prior: ComplianceModel | None) -> Fit:
    """All rows again: what a poorer model took for wrong may be right."""
    if all(np.array_equal(e.used, e.allowed) for e in fit.evidence):
        return fit
    for e in fit.evidence:
        e.used[:] = e.allowed
    return cleaned(_again(fit, prior), prior)


def fitted(
    layout: Unknowns,
    fixed: Mapping[str, Numbers],
    evidence: tuple[Evidence, ...],
    offset: float,
    prior: ComplianceModel | None,
    notes: tuple[str, ...],
    start: Floats | None = None,
    *,
    once: bool = False,
) -> Fit:
    """Least squares of one layout on evidence that is ready; ``once``: priors are too loose to be weighed anew."""
    shared, columns = len(layout), columns_of(evidence, len(layout))
    width = columns[-1].stop
    first = layout.start(fixed)
    mean = np.concatenate([first, np.zeros(width - shared)])
    sd = np.concatenate([loose_sd(layout), *(e.station.prior_sd() for e in evidence)])
    if prior is not None:
        sd[:shared] = _known(layout, prior, first, sd[:shared])
    low, high = layout.bounds()
    free = np.full(width - shared, np.inf)

    def blocks(vector: Floats) -> list[Whitened]:
        out: list[Whitened] = []
        for e, at in zip(evidence, columns, strict=True):
            out += e.blocks(vector[:shared], vector[at], offset, at, width)
        return out

    begin = mean.copy() if start is None else start
    bounds = np.concatenate([low, -free]), np.concatenate([high, free])
    spent = 0
    if offset > 0:
        pairs = (np.column_stack([e.samples.setup, e.samples.reflector])[e.used] for e in evidence)
        spent = 3 * sum(len(np.unique(p, axis=0)) for p in pairs)
    solution = solve(blocks, begin, mean, sd, *bounds, spent)
    if solution.misfit > 1 and not once:
        # what the model does not explain is noise to its parameters: the prior weighs more against it
        solution = solve(blocks, solution.vector, mean, sd / solution.misfit, *bounds, spent)
    return Fit(layout, fixed, solution, evidence, offset, notes)


def _known(layout: Unknowns, prior: ComplianceModel, first: Floats, sd: Floats) -> Floats:
    """Standard deviations of a prior model where it has them."""
    out = sd.copy()
    for k, u in enumerate(layout.free):
        given = prior.sd.get(u.effect, {}).get(u.parameter.name)
        if given is not None and given[u.index] > 0:
            out[k] = given[u.index] * first[k] ** 2 if u.inverse else given[u.index]
    return out


def _leave_out(fit: Fit) -> bool:
    """Take out the rows that all others contradict; True when there were any."""
    total = sum(int(e.used.sum()) for e in fit.evidence)
    found = False
    for k, e in enumerate(fit.evidence):
        at = columns_of(fit.evidence, len(fit.unknowns))[k]
        blocks = e.blocks(fit.parameters, fit.station(k), fit.offset, at, at.stop)
        scores = [e.deletion(b) for b in blocks]
        every = np.concatenate([s for _, s, _ in scores])
        # what the model does not explain widens everything: judge against the bulk of the readings
        bulk = max(1.0, float(np.median(every)) / 2.366)
        for rows, score, freedom in scores:
            limit = stats.chi2.isf(FALSE_ALARM / max(total, 1), freedom) * bulk
            if len(score) and np.any(score > limit):
                worst = score >= max(float(limit[0]), 0.5 * score.max())
                for r in np.flatnonzero(worst):
                    e.used[rows[r]] = False
                found = True
    return found
