"""What is wrong with a cell, in the catalogue's own numbers: to begin a fit that is told the truth, and to judge.

``exact`` are numbers that plant and catalogue both have; ``starts`` are guesses where the two write a law differently.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Effect, Site, place_name
from tests.plant.ailment import Truth
from tests.plant.ailments_body import tool
from tests.plant.cell_design import Cell

Floats = npt.NDArray[np.float64]
Numbers = dict[tuple[str, int], float]  # (parameter, index) -> value

SINGLY = ("joint-hardening", "posture-stiffness", "kinematic-offset")  # told in one joint only
NEVER = 1e9  # N*m: a breakaway that no torque reaches


@dataclass(frozen=True)
class Told:
    """One effect of the truth. ``exact``: can be compared; ``starts``: further numbers, one set per trial."""

    exact: Numbers = field(default_factory=dict)
    starts: tuple[Numbers, ...] = ({},)


def sites(effect: Effect, where: tuple[str, ...], joints: int) -> tuple[Site, ...]:
    """Sites of an effect that the plant's words mean; the last link is the tool's place where it has one."""
    every = effect.sites(joints)
    words = set(where)
    if any(s.kind == "place" or (s.index == joints and not s.kind) for s in every):
        words = {place_name(joints, joints) if w == f"link-{joints}" else w for w in words}
    return tuple(s for s in every if set(s.where) <= words)


def told(truth: Truth, cell: Cell) -> Told:
    """The truth in the words of the catalogue."""
    if len(truth.where) > 1 and truth.effect in SINGLY:
        return Told()
    return _LAWS[truth.effect](truth, cell) if truth.effect in _LAWS else Told()


def _value(truth: Truth, begin: str) -> float:
    return next(v for k, v in truth.values.items() if k.startswith(begin))


def _joint(truth: Truth) -> int:
    return int(truth.where[0].removeprefix("joint-")) - 1


def _turn(angle: float) -> float:
    """The same angle between -pi and pi."""
    return float(np.mod(angle + np.pi, 2 * np.pi) - np.pi)


def _hardening(truth: Truth, cell: Cell) -> Told:
    k = _joint(truth)
    if "exp" in truth.law:
        knee = _value(truth, "knee")
        windup = truth.factor * knee / cell.stiffness[k]
        return Told(starts=tuple({("windup_rad", k): windup, ("knee_nm", k): c * knee} for c in (0.35, 0.8, 2.0)))
    first, second = _value(truth, "T1"), _value(truth, "T2")
    each = 0.5 * truth.factor / cell.stiffness[k]
    parts = {("windup_rad", k): each * first, ("knee_nm", k): first, ("further_rad", k): each * second}
    simple = tuple({("windup_rad", k): each * (first + second), ("knee_nm", k): c * second} for c in (0.35, 0.8))
    return Told(starts=({**parts, ("knee_ratio", k): second / first, ("sharpness", k): 1.0}, *simple))


def _softening(truth: Truth, cell: Cell) -> Told:
    return Told({("ratio", _joint(truth)): _value(truth, "ratio")})


def _backlash(truth: Truth, cell: Cell) -> Told:
    exact: Numbers = {}
    start: Numbers = {}
    for k in (int(w.removeprefix("joint-")) - 1 for w in truth.where):
        exact["gap_rad", k] = _value(truth, f"gap joint-{k + 1} ")
        breakaway = _value(truth, f"breakaway joint-{k + 1} ")
        (exact if breakaway < NEVER else start)["breakaway_nm", k] = min(breakaway, NEVER)
        start["side", k] = 1.0
    return Told(exact, (start,))


def _friction(truth: Truth, cell: Cell) -> Told:
    k, grip = _joint(truth), _value(truth, "grip")
    exact = {("friction_nm", k): _value(truth, "slip"), ("held", k): grip / (1 + grip)}
    return Told(exact, ({("lag", k): float("dragged" in truth.law)},))


def _coupling(truth: Truth, cell: Cell) -> Told:
    low, high = sorted(int(w.removeprefix("joint-")) - 1 for w in truth.where)
    cross = _value(truth, "compliance") * np.sqrt(cell.stiffness[low] * cell.stiffness[high])
    return Told({("coupling", high * (high - 1) // 2 + low): float(cross)})


def _posture(truth: Truth, cell: Cell) -> Told:
    """A bump is softest at its centre; a cosine of the double angle has a mean, which is the spring's."""
    k, centre, s = _joint(truth), _value(truth, "centre"), truth.factor
    if "cos(2" in truth.law:
        share = 0.5 * s / (1 + 0.5 * s)
        start = {("softer", k): 0.05, ("cos2", k): share * np.cos(2 * centre), ("sin2", k): share * np.sin(2 * centre)}
        return Told(starts=tuple({**start, ("stiffest_rad", k): a} for a in (-2.0, 0.0, 2.0)))
    away = centre + np.pi
    return Told(starts=tuple({("softer", k): s, ("stiffest_rad", k): _turn(away + d)} for d in (0.0, 0.5, -0.5)))


def _kinematic(truth: Truth, cell: Cell) -> Told:
    k = int(truth.where[0].rsplit("-", 1)[1]) - 1
    if truth.where[0].startswith("joint"):
        return Told({("zero_rad", k): _value(truth, "zero")})
    names = {"x": "x_m", "y": "y_m", "z": "z_m", "roll": "rx_rad", "pitch": "ry_rad", "yaw": "rz_rad"}
    return Told(starts=({(p, k): _value(truth, f"{word} ") for word, p in names.items()},))


def _strut(truth: Truth, cell: Cell) -> Told:
    """Both pins as seen along the axis of joint 2."""
    arm = cell.arm
    size = float(np.linalg.norm(arm.after[1][:3, 3]) or np.linalg.norm(arm.before[2][:3, 3]))
    inner = np.array([-0.35, 0.25, 0.0]) * size
    outer = (np.linalg.inv(arm.after[1]) @ np.array([0.15 * size, 0.1 * size, 0, 1]))[:3]
    a, b = float(np.hypot(*inner[:2])), float(np.hypot(*outer[:2]))
    square = a**2 + b**2 + float(outer[2] - inner[2]) ** 2
    angle = float(np.arctan2(inner[1], inner[0]) - np.arctan2(outer[1], outer[0]))
    start = {
        ("moment_nm", 0): _value(truth, "stiffness") * a * b,
        ("free_length", 0): _value(truth, "free length") / np.sqrt(square),
        ("eccentricity", 0): 2 * a * b / square,
    }
    return Told(starts=tuple({**start, ("angle_rad", 0): _turn(angle + d)} for d in (0.0, 1.5, 3.0, -1.5)))


def _payload(truth: Truth, cell: Cell) -> Told:
    exact = {("mass_kg", 0): _value(truth, "mass")}
    return Told(exact | {("com_m", i): c for i, c in enumerate((0.06, -0.03, 0.15))})


def _spring(C: Floats) -> Numbers:
    """Numbers of a six-dimensional spring (6,6)."""
    out = {("linear_m_per_n", i): float(C[i, i]) for i in range(3)}
    out |= {("angular_rad_per_nm", i): float(C[3 + i, 3 + i]) for i in range(3)}
    lower = [(row, column) for row in range(6) for column in range(row)]
    return out | {("coupling", i): float(C[at]) for i, at in enumerate(lower)}


def _base(truth: Truth, cell: Cell) -> Told:
    """Springs below the plate, seen from the origin of the base."""
    below = np.diag([_value(truth, f"compliance base {c} ") for c in ("x", "y", "z", "rx", "ry", "rz")])
    T, depth = np.eye(6), _value(truth, "depth")
    T[0, 4], T[1, 3] = depth, -depth  # d = d_below + phi x (0, 0, depth)
    return Told(_spring(T @ below @ T.T))


def _link(truth: Truth, cell: Cell) -> Told:
    k = int(truth.where[0].removeprefix("link-")) - 1
    R = cell.arm.after[k][:3, :3]
    C = R.T @ np.diag([_value(truth, f"compliance link-{k + 1} {c} ") for c in ("rx", "ry", "rz")]) @ R
    numbers = {(f"r{c}_rad_per_nm", k): float(C[i, i]) for i, c in enumerate("xyz")}
    square = np.abs(C - np.diag(np.diag(C))).max() < 1e-9 * np.abs(C).max()
    starts = tuple({("at", k): at} for at in (0.6, 0.4, 1.0))
    return Told(numbers, starts) if square else Told(starts=tuple({**numbers, **s} for s in starts))


def _tool(truth: Truth, cell: Cell) -> Told:
    worn, _ = tool().apply(cell.healthy, cell.arm, truth.factor)
    return Told(_spring(worn.flexures[-1].compliance))


def _thermal(truth: Truth, cell: Cell) -> Told:
    exact: Numbers = {}
    for key, value in truth.values.items():
        word, place, _ = key.split()
        k = int(place.rsplit("-", 1)[1])
        exact["expansion_per_k" if word == "growth" else "zero_rad_per_k", k if word == "growth" else k - 1] = value
    return Told(exact)


def _tracker(truth: Truth, cell: Cell) -> Told:
    v = np.array([_value(truth, f"v{c}") for c in "xyz"])
    w = np.array([_value(truth, f"w{c}") for c in "xyz"])
    v = v - np.cross(w, [3.0, -1.0, 0.2])
    exact = {("linear_m_per_s", i): float(v[i]) for i in range(3)}
    exact |= {("angular_rad_per_s", i): float(w[i]) for i in range(3)}
    return Told(exact, ({("settling_s", 0): 3000.0},) if "settling" in truth.law else ({},))


def _sensor(truth: Truth, cell: Cell) -> Told:
    names = ("fx", "fy", "fz", "mx", "my", "mz")
    own = {("in_tool_axes", 0): 0.0 if cell.frame == "tool" else 1.0}
    if "constants" in truth.law:
        zero = [_value(truth, f"zero {c} ") for c in names]
        exact = {("force_n", i): zero[i] for i in range(3)} | {("moment_nm", i): zero[3 + i] for i in range(3)}
        return Told(exact, (own,))
    e = {("scale", i): -_value(truth, f"scale {c} ") for i, c in enumerate(names)}
    tilt = {("misalignment_rad", i): -_value(truth, f"tilt {c} ") for i, c in enumerate("xyz")}
    return Told(starts=({**own, **e, **tilt},))


_LAWS: dict[str, Callable[[Truth, Cell], Told]] = {
    "joint-hardening": _hardening,
    "preload-softening": _softening,
    "backlash": _backlash,
    "joint-friction": _friction,
    "joint-coupling": _coupling,
    "posture-stiffness": _posture,
    "kinematic-offset": _kinematic,
    "gravity-compensator": _strut,
    "payload": _payload,
    "base-compliance": _base,
    "link-compliance": _link,
    "tool-compliance": _tool,
    "thermal-drift": _thermal,
    "tracker-drift": _tracker,
    "force-sensor-bias": _sensor,
}
# effects whose law is written alike on both sides, so that the joints' springs can be compared
SPRINGS_KEPT = frozenset(_LAWS.keys() - {"joint-hardening", "posture-stiffness"})
