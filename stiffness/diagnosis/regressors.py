"""Regressors: what a residual may follow: loads, angles, the approach, the order of loads, time, temperature, columns.

Each is a simple function of one reading; families of them (the torque of a joint, its angle) are named as reports do.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Feature = tuple[Floats, str, str, int]  # values (N,), family, column, joint

# studied in tests/stiffness/diagnosis/test_attribution.py
HARMONICS = 4
ALWAYS = "always the same"
PROCESS = "process"  # what a residual follows that goes with the programmed force
SPEED = "speed of joint"
TRAVELS = (1e-3, 1e-2)  # rad since a joint turned: of play, and of friction
SILENT = 0.02  # of the largest torque: below, a torque has no sign


@dataclass(frozen=True, repr=False)
class Regressors:
    """Regressors of N readings: ``values`` (N, F), the ``family`` of each for the report, the ``column`` it is of.

    ``joint``: the joint that a feature is for, -1 for all.
    """

    values: Floats
    family: tuple[str, ...]
    column: tuple[str, ...]
    joint: tuple[int, ...]


def regressors(fits: Sequence[SessionFit]) -> list[Regressors]:
    """All regressors of every session, the same for all, each scaled to a root mean square of one over them together.
    What a session does not have (a column, a commanded path) is zero in it."""
    n = fits[0].session.robot.n
    most = np.maximum(np.max([np.abs(f.predicted.torque).max(axis=0) for f in fits], axis=0), 1e-9)
    own = [_keyed(_of_session(f, f.predicted.torque / most, n)) for f in fits]
    keys = list(dict.fromkeys(key for features in own for key in features))
    none = [np.zeros(len(f.samples)) for f in fits]
    values = [np.stack([mine.get(k, zero) for k in keys], axis=1) for mine, zero in zip(own, none, strict=True)]
    size = np.sqrt(np.mean(np.vstack(values) ** 2, axis=0))
    keep = np.flatnonzero(size > 1e-9)
    family, column, joint, _ = zip(*(keys[k] for k in keep), strict=True)
    return [Regressors(v[:, keep] / size[keep], family, column, joint) for v in values]


def _keyed(features: Sequence[Feature]) -> dict[tuple[str, str, int, int], Floats]:
    """Features by family, column and joint, counted where these are alike."""
    out: dict[tuple[str, str, int, int], Floats] = {}
    count: Counter[tuple[str, str, int]] = Counter()
    for values, family, column, joint in features:
        key = (family, column, joint)
        out[*key, count[key]] = values
        count[key] += 1
    return out


def _of_session(fit: SessionFit, tau: Floats, n: int) -> list[Feature]:
    s = fit.samples
    out: list[Feature] = [(np.ones(len(s)), ALWAYS, "", -1)]
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
    out += [] if fit.session.path is None else along_the_path(fit.session.path)
    for name, column in columns(fit.session).items():
        out.append((column, name, name, -1))
        out += [(column * tau[:, j], f"{name} times torque of joint {j + 1}", name, j) for j in range(n)]
        if len(np.unique(column)) > 3:
            out.append((column**2, name, name, -1))
    return out


def along_the_path(path: PathTrace) -> list[Feature]:
    """What is of a commanded path: speeds of joints, their travel since they turned, and the programmed force."""
    out: list[Feature] = []
    speed, since = path.joint_speed, path.since_turning
    for j in range(speed.shape[1]):
        out.append((speed[:, j] / max(float(np.abs(speed[:, j]).max()), 1e-9), f"{SPEED} {j + 1}", "", j))
        way = np.sign(speed[:, j])
        for travel in TRAVELS:
            name = f"distance from the last reversal of joint {j + 1}"
            out.append((way * np.exp(-since[:, j] / travel), name, "", j))
    force = np.einsum("nij,ni->nj", path.axes_at_readings.reshape(-1, 3, 3).swapaxes(1, 2), path.force)
    for k, way_of in enumerate(("along the feed", "across the feed", "along the tool")):
        size = float(np.abs(force[:, k]).max())
        if size > 0:
            out.append((force[:, k] / size, f"programmed force {way_of}", PROCESS, -1))
    return out


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
