"""Drawing scale: how far a robot is from its drawing, where the readings tell that it is nearer than a prior takes it.

Offsets z of the geometry have prior deviations D (1 mm, 1 mrad). A robot that was built or calibrated better leaves
their noise in a model, and every path is compensated by it. With a common factor s on D, readings of information A
about z alone, all other numbers free, have the evidence (MacKay 1992)

    2 log p(s) = b' (A + (s D)^-2)^-1 b - log det(I + s^2 D A D)        b = A z of the readings alone

The s where it is largest holds the offsets about the drawing, the drawing itself where the readings leave that open.
All other numbers follow, first as the linear model has it, then fitted anew: a law with a shape bends on the way.
Standard deviations stay those of the prior: of directions that no reading tells, none tells how near the drawing is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import stats

from stiffness.identification.fit import CLEAR, Fit
from stiffness.identification.nearest import CONTRADICTED, HELD, yielding_alike
from stiffness.identification.problem import loose_sd
from stiffness.numerics.least_squares import bounded_minimum, inverse

Floats = npt.NDArray[np.float64]

# studied in tests/stiffness/identification/test_drawing_scale.py
SCALES = np.geomspace(1e-5, 1.0, 101)  # of 1 mm: below the first, nothing of the geometry is left
BETTER = 3.0  # log of the odds against the prior as it is, from which another factor is taken
OPEN = float(stats.chi2.ppf(0.95, 1))  # twice the log of the odds, down to which a factor is left open


def with_drawing_scale(fit: Fit) -> tuple[Fit, tuple[str, ...]]:
    """The fit with offsets of the geometry held as near to the drawing as its readings find them, and a note of it.

    Where the model lacks something, and where a prior model tells the offsets, it stays as it is.
    """
    at = _offsets(fit)
    if not len(at) or fit.solution.misfit > CLEAR:
        return fit, ()
    moving, information = _moving(fit)
    own = np.isin(moving, at)
    readings = _Readings.of(fit, at, inverse(information)[np.ix_(own, own)])
    twice = readings.evidence()
    best = int(np.argmax(twice))
    if twice[best] - twice[-1] < 2 * BETTER:
        return fit, ()
    left_open = np.flatnonzero(twice > twice[best] - OPEN)
    likely, most = float(SCALES[0 if left_open[0] == 0 else best]), float(SCALES[left_open[-1]])
    vector = fit.solution.vector.copy()
    step = readings.offsets(likely) - vector[at]
    vector[at] += step
    # all other numbers follow, as far as their effects allow
    others, bounds = moving[~own], fit.problem.bounds()
    low, high = (b[others] - vector[others] for b in bounds)
    pull = -information[np.ix_(~own, own)] @ step
    vector[others] += bounded_minimum(information[np.ix_(~own, ~own)], pull, low, high)
    begun = replace(fit, solution=replace(fit.solution, vector=vector))
    held = np.setdiff1d(np.arange(len(fit.unknowns)), others)
    moved = _followed(begun, held)
    if moved.solution.chi2 > CONTRADICTED * fit.solution.chi2:
        return fit, ()
    names = ", ".join(dict.fromkeys(fit.unknowns.free[k].effect for k in at))
    near = "at the drawing" if likely == SCALES[0] else f"within about {likely:.2g} mm and mrad of the drawing"
    note = f"{names}: held {near}, from which these readings find the robot less than {most:.2g} mm and mrad off"
    return moved, (note,)


def _followed(fit: Fit, held: npt.NDArray[np.intp]) -> Fit:
    """A fit with the parameters ``held`` where they are and all other numbers fitted anew; with its deviations."""
    values = fit.values()
    fixed = {name: {k: np.array(v, dtype=float) for k, v in own.items()} for name, own in fit.problem.fixed.items()}
    for u in (fit.unknowns.free[k] for k in held):
        fixed[u.effect][u.parameter.name][u.index] = values[u.effect][u.parameter.name][u.index]
    problem = replace(fit.problem, fixed=fixed)
    rows = np.zeros((len(held), len(fit.solution.vector)))
    rows[np.arange(len(held)), held] = 1 / (HELD * problem.sd[held])
    solution, states = problem.solved(fit.states, fit.solution.vector, widened=fit.solution.misfit, held=rows)
    kept = replace(fit.solution, vector=solution.vector, chi2=solution.chi2)
    return replace(fit, solution=kept, states=states)


def _moving(fit: Fit) -> tuple[npt.NDArray[np.intp], Floats]:
    """(M,) numbers of the vector that may move, all but springs that no reading tells, what was chosen to be stiff and
    what yields as a spring does, and their information (M, M)."""
    stays = np.zeros(len(fit.solution.vector), dtype=bool)
    stiff = fit.gauge.chosen & [u.parameter.yields for u in fit.unknowns.free]
    stiff |= yielding_alike(fit, fit.unknowns.springs)
    stays[: len(fit.unknowns)] = (fit.unknowns.springs & ~fit.determined()) | stiff
    moving = np.flatnonzero(~stays)
    prior = np.diag((fit.solution.misfit / fit.problem.sd[moving]) ** 2)
    return moving, fit.solution.information[np.ix_(moving, moving)] + prior


def _offsets(fit: Fit) -> npt.NDArray[np.intp]:
    """Numbers of the geometry that no prior model tells, by their places in the vector."""
    geometry = {e.name for e in fit.unknowns.effects if e.fitted_where == "position"}
    loose = fit.problem.parameter_sd >= loose_sd(fit.unknowns, fit.fixed)
    free = zip(fit.unknowns.free, loose, strict=True)
    return np.array([k for k, (u, ok) in enumerate(free) if ok and u.effect in geometry], dtype=np.intp)


@dataclass(frozen=True, repr=False, eq=False)
class _Readings:
    """What readings tell of K offsets alone, in directions (K, K) of offsets by their prior deviations.

    Attributes:
        unit: (K,) prior deviations. directions: columns. told: (K,) information. pull: (K,) b.
    """

    unit: Floats
    directions: Floats
    told: Floats
    pull: Floats

    @classmethod
    def of(cls, fit: Fit, at: npt.NDArray[np.intp], covariance: Floats) -> _Readings:
        """Of the numbers ``at`` (K,) in the vector of a fit, and their covariance."""
        unit = fit.problem.sd[at]
        whole = inverse(covariance) / fit.solution.misfit**2
        values, directions = np.linalg.eigh(np.outer(unit, unit) * whole - np.eye(len(at)))
        pull = unit * (whole @ fit.solution.vector[at]) - fit.problem.start[at] / unit
        return cls(unit, directions, np.maximum(values, 0.0), directions.T @ pull)

    def evidence(self) -> Floats:
        """Twice its log, of every one of SCALES."""
        square = SCALES[:, None] ** 2
        grown = 1 + square * self.told
        return np.asarray(np.sum(self.pull**2 * square / grown - np.log(grown), axis=1))

    def offsets(self, s: float) -> Floats:
        """(K,) as they are with a prior of ``s`` times the deviations about the drawing."""
        return np.asarray(self.unit * (self.directions @ (self.pull * s**2 / (1 + s**2 * self.told))))
