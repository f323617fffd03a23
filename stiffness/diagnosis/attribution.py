"""Attribution: where a residual sits and what it follows, without the catalogue.

Every joint may turn, and every place may move, by any blend of simple features of a reading: constant, load, angles,
the way it was approached, the order of loads, time, temperature, further columns. How much of the residual of
set-ups left out a place explains that way is its share; how much one column explains, wherever it acts, is the
column's. Noise explains nothing that it has not seen, so a column of noise has no share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.diagnosis.linear_fit import Held, Ledger
from stiffness.diagnosis.search import ledger_of
from stiffness.diagnosis.selection import steady
from stiffness.diagnosis.sensitivities import Sensitivities
from stiffness.effects.effect import place_name
from stiffness.identification.fit import Fit
from stiffness.identification.session_fit import SessionFit
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

RIDGES = (1e-3, 1e-2, 1e-1)  # prior size of a feature's weight over the residual's own
HARMONICS = 4
SIX = 0.8  # a place moves in six ways, that of the joint beside it among them: its share counts for less
LEAST = 0.02  # a share below is not reported
SILENT = 0.02  # of the largest torque: below, a torque has no sign


@dataclass(frozen=True)
class Share:
    """``what``: a place or ``column:NAME``; ``share`` of the structure; ``follows``: features that carry it."""

    what: str
    share: float
    follows: str = ""


@dataclass(frozen=True, repr=False)
class Features:
    """Regressors of N readings: ``values`` (N, F), the ``family`` of each for the report, the ``column`` it is of.

    ``joint``: the joint that a feature is for, -1 for all.
    """

    values: Floats
    family: tuple[str, ...]
    column: tuple[str, ...]
    joint: tuple[int, ...]


def features(fit: SessionFit) -> Features:
    """All regressors of a session, each scaled to a root mean square of one."""
    s, n, seen = fit.samples, fit.session.robot.n, fit.predicted
    out: list[tuple[Floats, str, str, int]] = [(np.ones(len(s)), "always the same", "", -1)]
    most = np.maximum(np.abs(seen.torque).max(axis=0), 1e-9)
    tau = seen.torque / most
    sign = np.where(np.abs(tau) > SILENT, np.sign(tau), 0.0)
    for j in range(n):
        name = f"torque of joint {j + 1}"
        out.append((tau[:, j], name, "", -1))
        out.append((sign[:, j], f"sign of its torque, joint {j + 1}", "", j))
        out.append((tau[:, j] * np.abs(tau[:, j]), f"size of its torque, joint {j + 1}", "", j))
        out.append((tau[:, j] ** 3, f"size of its torque, joint {j + 1}", "", j))
        for h in range(1, HARMONICS + 1):
            only = -1 if h == 1 else j
            for wave in (np.cos, np.sin):
                out.append((wave(h * s.q[:, j]), f"angle of joint {j + 1}", "", only))
        for i in range(n):
            for wave in (np.cos, np.sin):
                out.append(
                    (tau[:, j] * wave(s.q[:, i]), f"torque of joint {j + 1} times angle of joint {i + 1}", "", j)
                )
        approach = s.approach[:, j].astype(float)
        out.append((approach, f"approach of joint {j + 1}", f"approach{j + 1}", j))
        out.append((approach * np.abs(tau[:, j]), f"approach of joint {j + 1} times its load", f"approach{j + 1}", j))
        out.append((_change(fit.session, tau[:, j]), f"last change of load of joint {j + 1}", "state", j))
    for name, column in columns(fit.session).items():
        out.append((column, name, name, -1))
        out += [(column * tau[:, j], f"{name} times torque of joint {j + 1}", name, j) for j in range(n)]
        if len(np.unique(column)) > 3:
            out.append((column**2, name, name, -1))
    keep = [(v / np.sqrt(np.mean(v**2)), *rest) for v, *rest in out if np.sqrt(np.mean(v**2)) > 1e-9]
    return Features(
        np.stack([v for v, *_ in keep], axis=1),
        tuple(str(f) for _, f, _, _ in keep),
        tuple(str(c) for *_, c, _ in keep),
        tuple(int(j) for *_, j in keep),
    )


def columns(session: Session) -> dict[str, Floats]:
    """Columns of the session that vary, centred and scaled: time, temperature, payload, and whatever else it has."""
    s = session.samples
    every = {"time": s.time, "temperature": s.temperature, "payload": s.payload, **s.extra}
    out = {}
    for name, raw in every.items():
        finite = np.isfinite(raw)
        if finite.any() and np.ptp(raw[finite]) > 0:
            filled = np.where(finite, raw, raw[finite].mean())
            out[name] = (filled - filled.mean()) / filled.std()
    return out


def _change(session: Session, tau: Floats) -> Floats:
    """(N,) sign of the last change of a torque, from the state before in the same set-up; 0 in the first."""
    states = session.states
    now = tau[states.first]
    before = np.where(states.before >= 0, now[states.before], now)
    change = now - before
    return np.asarray(np.where(np.abs(change) > SILENT, np.sign(change), 0.0)[states.of])


def attribution(fit: Fit, sensitivities: Sequence[Sensitivities]) -> list[Share]:
    """Shares of places and of columns, largest first."""
    layouts = [features(s) for s in fit.sessions]
    common = [f for f in range(len(layouts[0].family)) if all(layouts[0].family == o.family for o in layouts)]
    if not common:  # sessions with different columns: what they share is what can be looked at
        layouts = [_without_columns(f) for f in layouts]
    first, n = layouts[0], fit.unknowns.joints
    index, ledger = _ledger(fit, sensitivities, layouts)
    base = np.array([h.chi2 for h in ledger.held])
    noise = np.array([h.count for h in ledger.held], dtype=float)
    structure = max(float((base - noise).sum()), 1e-9)
    places = [f"joint-{j + 1}" for j in range(n)] + [place_name(k, n) for k in range(n + 1)]
    out = []
    for k, place in enumerate(places):
        share, follows = _carried(ledger, index[k], first, base, structure)
        share *= 1.0 if k < n else SIX
        if share > LEAST:
            out.append(Share(place, share, follows))
    for name in sorted({c for c in first.column if c}):
        mine = np.concatenate([_of_column(index[k], first, name) for k in range(n)])
        share = _share(ledger, mine, base, structure)
        if share > LEAST:
            out.append(Share(f"column:{name}", share))
    return sorted(out, key=lambda s: -s.share)


def _without_columns(f: Features) -> Features:
    keep = [i for i, c in enumerate(f.column) if not c or c[0] == "a" or c == "state"]
    family, column, joint = (tuple(t[i] for i in keep) for t in (f.family, f.column, f.joint))
    return Features(f.values[:, keep], family, column, joint)  # type: ignore[arg-type]


def _ledger(
    fit: Fit, sensitivities: Sequence[Sensitivities], layouts: Sequence[Features]
) -> tuple[list[Index], Ledger]:
    """Columns of every place times every feature, and per place the column of each feature (-1: none)."""
    n = fit.unknowns.joints
    joint = layouts[0].joint
    index: list[Index] = []
    wanted: list[tuple[int, int]] = []  # coordinate, feature
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
    more = (
        own.geometry(s)[:, :, coordinate] * layout.values[:, None, feature]
        for s, own, layout in zip(fit.sessions, sensitivities, layouts, strict=True)
    )
    weak = 1e-6 / np.maximum(np.diag(fit.solution.covariance), 1e-300)
    return index, ledger_of(fit, more, np.asarray(weak))[0]


def _of_column(index: Index, first: Features, name: str) -> Index:
    at = np.array(
        [i for i, c in zip(index, first.column * (len(index) // len(first.column)), strict=True) if c == name]
    )
    return at[at >= 0].astype(np.intp) if len(at) else np.empty(0, dtype=np.intp)


def _share(ledger: Ledger, columns: Index, base: Floats, structure: float) -> float:
    """How much of the structure of folds left out some columns explain; 0 where it is not steady."""
    if not len(columns):
        return 0.0
    best = 0.0
    for ridge in RIDGES:
        gain = base - np.array([_ridge(h, columns, ridge) for h in ledger.held])
        if steady(gain):
            best = max(best, float(gain.sum()) / structure)
    return min(best, 1.0)


def _ridge(held: Held, columns: Index, ridge: float) -> float:
    """Chi-square of a fold for weights that a prior keeps small: sizes as if all columns explained alike."""
    curvature = held.trained.curvature[np.ix_(columns, columns)]
    there = np.diag(curvature) > 0
    scale = there / np.sqrt(np.where(there, np.diag(curvature), 1.0))
    scaled = curvature * np.outer(scale, scale) + ridge * np.eye(len(columns))
    weight = scale * np.linalg.solve(scaled, scale * held.trained.slope[columns])
    return held.score(columns, weight)


def _carried(ledger: Ledger, index: Index, first: Features, base: Floats, structure: float) -> tuple[float, str]:
    """The share of a place, and what carries it: all features at once, one family, or the best two."""
    repeat = len(index) // len(first.family)
    families = {}
    for family in dict.fromkeys(first.family):
        mine = [i for i, f in zip(index, first.family * repeat, strict=True) if f == family and i >= 0]
        families[family] = np.array(mine, dtype=np.intp)
    alone = {f: _share(ledger, at, base, structure) for f, at in families.items()}
    best = max(alone, key=lambda f: alone[f])
    if alone[best] <= LEAST:
        return 0.0, ""
    pairs = {
        f: _share(ledger, np.concatenate([families[best], at]), base, structure)
        for f, at in families.items()
        if f != best
    }
    second = max(pairs, key=lambda f: pairs[f])
    whole = _share(ledger, index[index >= 0], base, structure)
    if pairs[second] > alone[best] + 0.1 * (1 - alone[best]):
        return max(pairs[second], whole), f"{best}; {second}"
    return max(alone[best], whole), best
