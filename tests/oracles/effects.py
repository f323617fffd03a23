"""What every effect does, in plain numpy, written from the physics page and not from the package."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Numbers = Mapping[str, Floats]


@dataclass(frozen=True)
class Joints:
    """What the joints of an arm are in: (n,) each, ``temperature`` K above the reference."""

    torque: Floats
    stiffness: Floats
    angle: Floats
    state: Floats
    temperature: float


@dataclass(frozen=True)
class Oracle:
    """One effect.

    Attributes:
        joint: deflection (n,) that the effect adds.
        twist: place, wrench (6,), temperature, values -> (6,).
        torque: angles (n,) -> (n,); mass: joints -> [(link, kg, com)].
        step: state, move, torque of one joint and its values -> the next state.
        nothing: values for which there is no effect; None where there are none.
        without_load: there is an effect without load.
        sample: random values, where bounds and start values do not lead to sensible ones.
    """

    joint: Callable[[Joints, Numbers], Floats] | None = None
    twist: Callable[[int, Floats, float, Numbers], Floats] | None = None
    torque: Callable[[Floats, Numbers], Floats] | None = None
    mass: Callable[[int, Numbers], list[tuple[int, float, Floats]]] | None = None
    step: Callable[[float, float, float, Mapping[str, float]], float] | None = None
    nothing: Mapping[str, float] | None = None
    without_load: bool = False
    sample: Callable[[np.random.Generator], dict[str, Floats]] | None = None


def _softer(given: Joints, p: Numbers) -> Floats:
    """Stiffness r K where the torque is against the last rotation; a rotation not known counts half."""
    out = np.zeros(len(given.torque))
    for j, (tau, k, d) in enumerate(zip(given.torque, given.stiffness, given.state, strict=True)):
        more = tau / (p["ratio"][j] * k) - tau / k
        share_against = (1 - np.sign(tau) * d) / 2
        out[j] = share_against * more
    return out


def _turned(state: float, move: float, torque: float, p: Mapping[str, float]) -> float:
    return min(1.0, max(-1.0, state + move / 0.5e-6))


def _crossed(link: float, move: float, torque: float, p: Mapping[str, float]) -> float:
    half = p["gap_rad"] / 2
    if abs(torque) > max(p["breakaway_nm"], 0.01):
        return half if torque > 0 else -half
    return min(half, max(-half, link + p["side"] * move))


def compliance(p: Numbers) -> Floats:
    """(6, 6): diagonal, then row by row below it."""
    c = np.zeros((6, 6))
    entries = iter(p["coupling"])
    for row in range(6):
        for column in range(row):
            c[row, column] = c[column, row] = next(entries)
    for i in range(3):
        c[i, i], c[3 + i, 3 + i] = p["linear_m_per_n"][i], p["angular_rad_per_nm"][i]
    return c


def _bracket(rng: np.random.Generator) -> dict[str, Floats]:
    a = rng.normal(size=(6, 6))
    s = np.diag(np.sqrt([1e-7, 2e-7, 3e-8, 1e-6, 2e-6, 5e-7]))
    c = s @ a @ a.T @ s
    below = np.array([c[i, j] for i in range(6) for j in range(i)])
    return {"linear_m_per_n": np.diag(c)[:3].copy(), "angular_rad_per_nm": np.diag(c)[3:].copy(), "coupling": below}


def _displaced(place: int, wrench: Floats, temperature: float, p: Numbers) -> Floats:
    k = place - 1
    return np.array([p[a][k] for a in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")])


ORACLES: dict[str, Oracle] = {
    "joint-stiffness": Oracle(joint=lambda given, p: given.torque / p["k_nm_per_rad"]),
    "preload-softening": Oracle(joint=_softer, step=_turned, nothing={"ratio": 1.0}),
    "backlash": Oracle(joint=lambda given, p: given.state, step=_crossed, nothing={"gap_rad": 0.0}),
    "joint-hardening": Oracle(
        # a tanh(t/T) = a (1 - 2 / (1 + exp(2 t/T)))
        joint=lambda given, p: p["windup_rad"] * (1 - 2 / (1 + np.exp(2 * given.torque / p["knee_nm"]))),
        nothing={"windup_rad": 0.0},
    ),
    "posture-stiffness": Oracle(
        # sin^2 of half the angle from where the joint is stiffest
        joint=lambda given, p: given.torque
        / given.stiffness
        * p["softer"]
        * np.sin((given.angle - p["stiffest_rad"]) / 2) ** 2,
        nothing={"softer": 0.0},
    ),
    "tool-compliance": Oracle(
        twist=lambda place, wrench, temperature, p: compliance(p) @ wrench,
        nothing={"linear_m_per_n": 0.0, "angular_rad_per_nm": 0.0, "coupling": 0.0},
        sample=_bracket,
    ),
    "kinematic-offset": Oracle(
        joint=lambda given, p: p["zero_rad"],
        twist=_displaced,
        nothing=dict.fromkeys(("zero_rad", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"), 0.0),
        without_load=True,
    ),
}
