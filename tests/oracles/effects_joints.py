"""Effects inside the joints, in plain numpy: springs, flanks, friction, linkages, the spring beside the arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tests.oracles.oracle import Joints, Numbers, Oracle, Step

Floats = npt.NDArray[np.float64]


def _softer(given: Joints, p: Numbers) -> Floats:
    """Stiffness r K where the torque is against the last rotation; a rotation not known counts half."""
    out = np.zeros(len(given.torque))
    for j, (tau, k, d) in enumerate(zip(given.torque, given.stiffness, given.state, strict=True)):
        more = tau / (p["ratio"][j] * k) - tau / k
        share_against = (1 - np.sign(tau) * d) / 2
        out[j] = share_against * more
    return out


def _turned(state: float, now: Step, p: Mapping[str, float]) -> float:
    return min(1.0, max(-1.0, state + now.move / 0.5e-6))


def _crossed(link: float, now: Step, p: Mapping[str, float]) -> float:
    half = p["gap_rad"] / 2
    if abs(now.torque) > max(p["breakaway_nm"], 0.01):
        return half if now.torque > 0 else -half
    return min(half, max(-half, link + p["side"] * now.move))


def _hardening(given: Joints, p: Numbers) -> Floats:
    """Two knees; a tanh(t/T) = a (1 - 2 / (1 + exp(2 t/T))), blended with the integral of its sharp form."""

    def used_up(windup: Floats, knee: Floats) -> Floats:
        smooth = 1 - 2 / (1 + np.exp(np.minimum(2 * given.torque / knee, 700)))
        sharp = np.array([cut_off(float(t)) for t in given.torque / knee])
        return np.asarray(windup * ((1 - p["sharpness"]) * smooth + p["sharpness"] * sharp))

    second = p["knee_ratio"] * p["knee_nm"]
    return used_up(p["windup_rad"], p["knee_nm"]) + used_up(p["further_rad"], second)


def cut_off(x: float) -> float:
    """The branch of a hyperbola in each corner (asymptotes: the piece before and the one after), 0.02 off there."""
    corner = 0.02**2
    above = 0.5 * (x + 1 - np.sqrt((x - 1) ** 2 + 4 * corner))  # of min(x, 1)
    below = 0.5 * (x - 1 + np.sqrt((x + 1) ** 2 + 4 * corner))  # of max(x, -1)
    return float(above + below - x)


def _posture(given: Joints, p: Numbers) -> Floats:
    """sin^2 of half the angle from where the joint is stiffest; the others by products of sin q and cos q."""
    s, c = np.sin(given.angle), np.cos(given.angle)
    share = p["softer"] * np.sin((given.angle - p["stiffest_rad"]) / 2) ** 2
    share = share + p["cos2"] * (c + s) * (c - s) + p["sin2"] * 2 * s * c
    share = share + p["cos3"] * c * (4 * c**2 - 3) + p["sin3"] * s * (3 - 4 * s**2)
    return np.asarray(given.torque / given.stiffness * share)


def _waving(rng: np.random.Generator) -> dict[str, Floats]:
    """Harmonics that leave every angle some compliance."""
    between = {"softer": (0, 1), "stiffest_rad": (-3, 3)} | dict.fromkeys(("cos2", "sin2", "cos3", "sin3"), (-0.3, 0.3))
    values = {name: rng.uniform(*ends, 6) for name, ends in between.items()}
    values["softer"] += 0.3
    return {k: v * 0.8 if k[:3] in ("cos", "sin") else v for k, v in values.items()}


def slid(held: float, now: Step, friction: float, share: float = 1.0) -> float:
    """Friction torque of a slider beside a spring of rate 1, itself on a spring that takes ``share`` while it sticks.

    The link is where spring and slider carry the load together; beyond ``friction`` the slider gives way.
    """
    link = now.before + held  # the spring of rate 1 carries load and friction
    slider = -held
    stuck = link
    if share < 1:
        beside = share / (1 - share)  # rate of the slider's spring
        stuck = (now.torque - slider + beside * link) / (1 + beside)
    carried = now.torque - stuck
    return -min(max(carried, -friction), friction)


def _stuck(held: float, now: Step, p: Mapping[str, float]) -> float:
    """One of four sliders; a motor that moves drags the link along as a load of K times the move does."""
    weight = [1.0, p["weight_half"], p["weight_double"], p["weight_quarter"]]
    share = weight[now.number] / sum(weight)
    most = p["friction_nm"] * share * (1.0, 0.5, 2.0, 0.25)[now.number]
    fastest = 4 * p["friction_nm"] / p["held"] / 1e-6  # turned over within half a micro-radian
    dragged = now.move * min(now.stiffness, fastest)
    after = slid(held, replace(now, torque=now.torque + dragged), most, p["held"] * share)
    free = 1 - (1 - p["lag"]) * min(abs(now.move) / 0.5e-6, 1.0)
    return min(max(after, -free * most), free * most)


def coupled_stiffness(stiffness: Floats, coupling: Floats) -> Floats:
    """(n, n) N*m/rad: the inverse of a compliance with the diagonal 1/K and correlations as given, row by row."""
    n = len(stiffness)
    correlation = np.eye(n)
    for at, value in zip([(i, j) for i in range(n) for j in range(i)], coupling, strict=True):
        correlation[at] = correlation[at[::-1]] = value
    root = np.diag(np.sqrt(stiffness))
    return np.asarray(root @ np.linalg.inv(correlation) @ root)


def _coupled(given: Joints, p: Numbers) -> Floats:
    both = np.linalg.solve(coupled_stiffness(given.stiffness, p["coupling"]), given.torque)
    return np.asarray(both - given.torque / given.stiffness)


def _correlated(rng: np.random.Generator) -> dict[str, Floats]:
    a = rng.normal(size=(6, 9))
    c = a @ a.T
    return {"coupling": np.array([c[i, j] / np.sqrt(c[i, i] * c[j, j]) for i in range(6) for j in range(i)])}


def two_pins(phi: float, a: float, b: float, rate: float, relaxed: float) -> float:
    """Torque of a spring between a pin at (a, 0) and one at b (cos phi, sin phi), on the second, about the origin."""
    fixed, moving = np.array([a, 0.0]), b * np.array([np.cos(phi), np.sin(phi)])
    towards = fixed - moving
    length = np.linalg.norm(towards)
    force = rate * (length - relaxed) * towards / length
    return float(moving[0] * force[1] - moving[1] * force[0])


def _compensated(angle: Floats, p: Numbers) -> Floats:
    """The pins that belong to the parameters, the fixed one at 1 m."""
    e = p["eccentricity"][0]
    b = (1 - np.sqrt(1 - e**2)) / e
    rate, relaxed = p["moment_nm"][0] / b, p["free_length"][0] * np.hypot(1, b)
    out = np.zeros(len(angle))
    out[1] = two_pins(angle[1] - p["angle_rad"][0], 1.0, b, rate, relaxed)
    return out


def _pinned(rng: np.random.Generator) -> dict[str, Floats]:
    ends = {"moment_nm": (500, 8e4), "angle_rad": (-3.1, 3.1), "free_length": (0, 1.5), "eccentricity": (0.1, 0.95)}
    return {name: rng.uniform(*between, 1) for name, between in ends.items()}


def _wrong_angle(angle: Floats, p: Numbers) -> Floats:
    """Waves of one and two a turn, and straight lines between knots every 3 deg from -180 deg on, the same again every
    turn; joint by joint."""
    tables = p["error_rad"].reshape(len(angle), -1)
    knots = np.radians(-180.0 + 3.0 * np.arange(tables.shape[1]))
    lines = np.array([np.interp(a, knots, t, period=2 * np.pi) for a, t in zip(angle, tables, strict=True)])
    once, twice = (p[f"cos{k}_rad"] - 1j * p[f"sin{k}_rad"] for k in (1, 2))
    return np.asarray(lines + np.real(once * np.exp(1j * angle) + twice * np.exp(2j * angle)))


JOINTS: dict[str, Oracle] = {
    "joint-stiffness": Oracle(joint=lambda given, p: given.torque / p["k_nm_per_rad"]),
    "preload-softening": Oracle(joint=_softer, step=_turned, nothing={"ratio": 1.0}),
    "backlash": Oracle(joint=lambda given, p: given.state, step=_crossed, nothing={"gap_rad": 0.0}),
    "joint-hardening": Oracle(joint=_hardening, nothing={"windup_rad": 0.0, "further_rad": 0.0}),
    "joint-friction": Oracle(
        joint=lambda given, p: given.state.reshape(4, -1).sum(axis=0) / given.stiffness,
        step=_stuck,
        states=4,
        nothing={"friction_nm": 0.0, "weight_half": 0.0, "weight_double": 0.0, "weight_quarter": 0.0},
        on_base=True,
    ),
    "joint-coupling": Oracle(joint=_coupled, nothing={"coupling": 0.0}, on_base=True, sample=_correlated),
    "posture-stiffness": Oracle(
        joint=_posture,
        nothing=dict.fromkeys(("softer", "cos2", "sin2", "cos3", "sin3"), 0.0),
        on_base=True,
        sample=_waving,
    ),
    "joint-angle-error": Oracle(
        angle=_wrong_angle,
        nothing=dict.fromkeys(("error_rad", "cos1_rad", "sin1_rad", "cos2_rad", "sin2_rad"), 0.0),
        without_load=True,
    ),
    "gravity-compensator": Oracle(torque=_compensated, nothing={"moment_nm": 0.0}, sample=_pinned),
}
