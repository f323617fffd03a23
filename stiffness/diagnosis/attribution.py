"""Attribution: where a residual sits and what it follows, without the catalogue.

Every joint may turn, and every place may move, by any linear combination of the regressors of a reading. The fraction
of the structure (chi-square above the noise) that a place explains that way in cross-validation is attributed to it; so
is what one column explains, wherever it acts. In cross-validation a column of noise explains nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.linear_fit import HeldOutFold, NormalEquations, ReducedEquations
from stiffness.diagnosis.linearisation import Further, normal_equations
from stiffness.diagnosis.regressors import ALWAYS, PROCESS, SPEED, Regressors, regressors
from stiffness.diagnosis.selection import steady
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects.effect import place_name
from stiffness.identification.fit import Fit
from stiffness.identification.reading_slopes import Slopes
from stiffness.session.path_trace import PathTrace

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

_Trained = tuple[HeldOutFold, Index, ReducedEquations]  # a fold, columns, what the other folds tell of them

# studied in tests/stiffness/diagnosis/test_attribution.py
RIDGES = (1e-3, 1e-2, 1e-1)  # prior precision of a weight over that of the data, all columns scaled alike
SIX = 0.8  # factor on the fraction of a place: it has six coordinates, one of which moves as the joint beside it
FIXTURE = "fixture"
OF_PATH = (PROCESS, "arc-length")  # of every path, and no column of a file
LEAST = 0.02  # a smaller fraction is not reported
SECOND = 0.1  # of what the best family leaves: so much more a second family has to explain to be named


@dataclass(frozen=True)
class ResidualSource:
    """``what``: a place or ``column:NAME``; ``fraction`` of the structure that it explains; ``follows``: the regressors
    that carry it."""

    what: str
    fraction: float
    follows: str = ""

    @property
    def is_place(self) -> bool:
        """Whether it is a part of the arm; else a column, or what belongs to a path."""
        return self.what.startswith(("joint-", "link-")) or self.what in ("base", "tool")


def residual_sources(fit: Fit, sensitivities: Sequence[Sensitivities]) -> list[ResidualSource]:
    """Places where the residual of a fit sits and columns that it follows, the largest fraction first."""
    layouts = regressors(fit.sessions)
    first, n = layouts[0], fit.unknowns.joints
    index, equations = _equations(fit, sensitivities, layouts)
    structure = _Structure.of(equations)
    places = [f"joint-{j + 1}" for j in range(n)] + [place_name(k, n) for k in range(n + 1)]
    out = []
    for k, place in enumerate(places):
        fraction, follows = _carried(structure, index[k], first)
        fraction *= 1.0 if k < n else SIX
        if fraction > LEAST:
            out.append(ResidualSource(place, fraction, follows))
        if fraction > LEAST and k == n and _on_a_part(fit):
            # seen from the part, a base that moves and a fixture that moves are one
            out.append(ResidualSource(FIXTURE, min(fraction / SIX, 1.0), follows))
    always = _joined(index[:n], [f == ALWAYS for f in first.family])
    for name in sorted({c for c in first.column if c}):
        own = _joined(index[:n], [c == name for c in first.column])
        # where the zero of a column is says nothing: of a brake that is on or off, one of the two is no change
        fraction = structure.explained(own, always)
        if fraction > LEAST:
            out.append(ResidualSource(name if name in OF_PATH else f"column:{name}", fraction))
    return sorted(out, key=lambda s: -s.fraction)


def by_speed(fit: Fit, sensitivities: Sequence[Sensitivities]) -> tuple[Index, NormalEquations] | None:
    """Joints (C,) that move along the paths, and equations of one column for each, which turns by its own speed; None
    where none moves."""
    layouts = regressors(fit.sessions)
    first = layouts[0]
    feature = np.array([f for f, name in enumerate(first.family) if name.startswith(SPEED)], dtype=np.intp)
    if not len(feature):
        return None
    joints = np.array(first.joint, dtype=np.intp)[feature]
    more = [
        _always(_Products(o.geometry(s), joints, layout.values, feature))
        for s, o, layout in zip(fit.sessions, sensitivities, layouts, strict=True)
    ]
    return joints, normal_equations(fit, more, len(joints), _weak(fit))[0]


def by_fixture(fit: Fit, sensitivities: Sequence[Sensitivities]) -> NormalEquations | None:
    """Equations of 36 columns: the part is shifted and turns about its centre by the programmed force and its moment
    there; None where no part was cut."""
    if not _on_a_part(fit):
        return None
    n = fit.unknowns.joints
    more = [
        _always(_Products(_about(p.point.mean(axis=0), o.geometry(s)[:, :, n : n + 6]), *_of_wrench(p)))
        for s, o in zip(fit.sessions, sensitivities, strict=True)
        if (p := s.session.path) is not None
    ]
    return normal_equations(fit, more, 36, _weak(fit))[0]


def _about(centre: Floats, geometry: Floats) -> Floats:
    """(N, 3, 6) derivatives by a shift of the base and a turn of it about a point, from those about its origin."""
    arm = np.cross(np.eye(3), centre)  # rows: axis x centre
    return np.concatenate([geometry[:, :, :3], geometry[:, :, 3:] - geometry[:, :, :3] @ arm.T], axis=2)


def _of_wrench(path: PathTrace) -> tuple[Index, Floats, Index]:
    """Coordinates (36,), force and moment (N, 6) about the centre of the part, their columns (36,)."""
    at = path.rows.at(path.rows.position, path.index)
    moment = np.cross(at - path.point.mean(axis=0), path.force)
    wrench = np.concatenate([path.force, moment], axis=1)
    size = np.sqrt(np.mean(wrench**2, axis=0))
    coordinate, feature = np.divmod(np.arange(36), 6)
    return coordinate, wrench / np.where(size > 0, size, 1.0), feature


def _on_a_part(fit: Fit) -> bool:
    return all(s.session.path is not None and s.session.path.kind == "surface" for s in fit.sessions)


@dataclass(frozen=True, repr=False, eq=False)
class _Structure:
    """Normal equations of all columns; per fold (folds,) the chi-square ``without`` them; the ``total`` above noise."""

    equations: NormalEquations
    without: Floats
    total: float

    @classmethod
    def of(cls, equations: NormalEquations) -> _Structure:
        chi2 = np.array([f.chi2 for f in equations.folds])
        noise = np.array([f.count for f in equations.folds], dtype=float)
        return cls(equations, chi2, max(float((chi2 - noise).sum()), 1e-9))

    def explained(self, columns: Index, beside: Index | None = None) -> float:
        """Fraction that some columns explain in held-out folds; 0 where it is not steady. ``beside``: columns that take
        part, and whose own fraction does not count."""
        if not len(columns):
            return 0.0
        best = 0.0
        every = self._trained(columns if beside is None else np.concatenate([beside, columns]))
        others = None if beside is None else self._trained(beside)
        for ridge in RIDGES:
            without = self.without if others is None else np.minimum(self.without, _left(others, ridge))
            gain = without - _left(every, ridge)
            if steady(gain):
                best = max(best, float(gain.sum()) / self.total)
        return min(best, 1.0)

    def _trained(self, columns: Index) -> list[_Trained]:
        return [(f, columns, f.training(columns)) for f in self.equations.folds]


def _left(trained: Sequence[_Trained], ridge: float) -> Floats:
    """(folds,) chi-square that some columns leave of held-out folds."""
    return np.array([fold.score(columns, _ridge(given, ridge)) for fold, columns, given in trained])


def _ridge(given: ReducedEquations, ridge: float) -> Floats:
    """(K,) weights by ridge regression, columns scaled to equal squares."""
    there = np.diag(given.curvature) > 0
    scale = there / np.sqrt(np.where(there, np.diag(given.curvature), 1.0))
    scaled = given.curvature * np.outer(scale, scale) + ridge * np.eye(len(scale))
    return np.asarray(scale * np.linalg.solve(scaled, scale * given.slope))


def _carried(structure: _Structure, index: Index, first: Regressors) -> tuple[float, str]:
    """The fraction that a place explains, and what carries it: all regressors at once, one family, or the best two."""
    repeat = len(index) // len(first.family)
    families = {}
    for family in dict.fromkeys(first.family):
        mine = [i for i, f in zip(index, first.family * repeat, strict=True) if f == family and i >= 0]
        families[family] = np.array(mine, dtype=np.intp)
    alone = {f: structure.explained(at) for f, at in families.items()}
    best = max(alone, key=lambda f: alone[f])
    if alone[best] <= LEAST:
        return 0.0, ""
    pairs = {
        f: structure.explained(np.concatenate([families[best], at])) for f, at in families.items() if f != best
    }
    second = max(pairs, key=lambda f: pairs[f])
    whole = structure.explained(index[index >= 0])
    if pairs[second] > alone[best] + SECOND * (1 - alone[best]):
        return max(pairs[second], whole), f"{best}; {second}"
    return max(alone[best], whole), best


def _joined(index: Sequence[Index], some: Sequence[bool]) -> Index:
    """Columns of some regressors, of all joints; those that are there."""
    at = np.concatenate([of_joint[np.array(some)] for of_joint in index])
    return np.asarray(at[at >= 0])


@dataclass(frozen=True, repr=False, eq=False)
class _Products:
    """Derivatives by places ``geometry`` (N, 3, c) times regressors ``values`` (N, f), worked out block by block: as
    ``ReadingSlopes`` of C columns, each with its ``coordinate`` and its ``feature`` (C,)."""

    geometry: Floats
    coordinate: Index
    values: Floats
    feature: Index

    @property
    def count(self) -> int:
        return len(self.coordinate)

    @property
    def tabled(self) -> bool:
        return False

    def block(self, rows: Index) -> tuple[Floats, Index]:
        products = self.geometry[rows][:, :, self.coordinate] * self.values[rows][:, None, self.feature]
        return products.reshape(3 * len(rows), -1), np.arange(self.count)


def _always(slopes: Slopes) -> Further:
    """These, whichever readings are asked for."""
    return lambda rows: [slopes]


def _equations(
    fit: Fit, sensitivities: Sequence[Sensitivities], layouts: Sequence[Regressors]
) -> tuple[list[Index], NormalEquations]:
    """Columns of every place times every regressor, and per place the column of each regressor (-1: none)."""
    n = fit.unknowns.joints
    joint = layouts[0].joint
    index: list[Index] = []
    wanted: list[tuple[int, int]] = []  # coordinate, regressor
    for j in range(n):
        at = np.full(len(joint), -1)
        for f, only in enumerate(joint):
            if only in (-1, j):
                at[f] = len(wanted)
                wanted.append((j, f))
        index.append(at)
    plain = [f for f, only in enumerate(joint) if only == -1]
    for k in range(n + 1):
        at = np.full(6 * len(joint), -1)
        for c in range(6):
            for f in plain:
                at[c * len(joint) + f] = len(wanted)
                wanted.append((n + 6 * k + c, f))
        index.append(at)
    coordinate, feature = np.array(wanted).T
    more = [
        _always(_Products(own.geometry(s), coordinate, layout.values, feature))
        for s, own, layout in zip(fit.sessions, sensitivities, layouts, strict=True)
    ]
    return index, normal_equations(fit, more, len(wanted), _weak(fit))[0]


def _weak(fit: Fit) -> Floats:
    """Prior weights of the fit's own numbers, a millionth of what the readings tell of them."""
    return np.asarray(1e-6 / np.maximum(np.diag(fit.solution.covariance), 1e-300))
