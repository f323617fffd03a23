"""Regressors: what a residual may follow: loads, angles, the approach, the order of loads, time, temperature, columns.

Each is a simple function of one reading; families of them (the torque of a joint, its angle) are named as reports do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.session_fit import SessionFit
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]

HARMONICS = 4
PROCESS = "process"  # what a residual follows that goes with the programmed force
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


def regressors(fit: SessionFit) -> Regressors:
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
    out += [] if fit.session.path is None else along_the_path(fit.session.path)
    for name, column in columns(fit.session).items():
        out.append((column, name, name, -1))
        out += [(column * tau[:, j], f"{name} times torque of joint {j + 1}", name, j) for j in range(n)]
        if len(np.unique(column)) > 3:
            out.append((column**2, name, name, -1))
    keep = [(v / np.sqrt(np.mean(v**2)), *rest) for v, *rest in out if np.sqrt(np.mean(v**2)) > 1e-9]
    return Regressors(
        np.stack([v for v, *_ in keep], axis=1),
        tuple(str(f) for _, f, _, _ in keep),
        tuple(str(c) for *_, c, _ in keep),
        tuple(int(j) for *_, j in keep),
    )


def along_the_path(path: PathTrace) -> list[tuple[Floats, str, str, int]]:
    """What is of a commanded path: speeds of joints, their travel since they turned, and the programmed force."""
    out: list[tuple[Floats, str, str, int]] = []
    speed, since = path.joint_speed, path.since_turning
    for j in range(speed.shape[1]):
        out.append((speed[:, j] / max(float(np.abs(speed[:, j]).max()), 1e-9), f"speed of joint {j + 1}", "", j))
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


def without_columns(f: Regressors) -> Regressors:
    keep = [i for i, c in enumerate(f.column) if not c or c.startswith("approach") or c == "state"]
    family, column, joint = (tuple(t[i] for i in keep) for t in (f.family, f.column, f.joint))
    return Regressors(f.values[:, keep], family, column, joint)  # type: ignore[arg-type]
