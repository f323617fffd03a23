"""What can be wrong with joints: laws of this file alone, one constructor each; k counts from 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .ailment import Ailment, only, torque_scale
from .arm import Arm
from .geometry import Array
from .joints import Bearings, Friction
from .wear import Law, Situation, Tie, Wear

Done = tuple[Wear, Mapping[str, float]]


def with_law(wear: Wear, law: Law) -> Wear:
    """The cell with one more joint law."""
    return replace(wear, laws=(*wear.laws, law))


def hardening(k: int, knees: tuple[float, float] = (0.25, 0.6)) -> Ailment:
    """Soft at small torque, in three pieces; the last has the healthy tangent stiffness. knees: of a typical torque."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        stiff, scale = float(wear.stiffness[k - 1]), torque_scale(wear, k)
        first, second = knees[0] * scale, knees[1] * scale

        def law(at: Situation) -> Array:
            t = float(at.torque[k - 1])
            low, high = np.clip(t, -first, first), np.clip(t, -second, second)
            return only(arm.n, k, s / stiff * (low + 0.5 * (high - low)))

        values = {"K1": stiff / (1 + s), "K2": stiff / (1 + s / 2), "K3": stiff}
        named = {f"{name} joint-{k} N*m/rad": v for name, v in values.items()}
        return with_law(wear, law), named | {f"T1 joint-{k} N*m": first, f"T2 joint-{k} N*m": second}

    law = "tangent compliance (1+s)/K below T1, (1+s/2)/K up to T2, 1/K above; odd"
    return Ailment("joint-hardening", (f"joint-{k}",), law, apply, 0.3)


def hardening_smooth(k: int) -> Ailment:
    """Soft at small torque, and less and less so."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        stiff, knee = float(wear.stiffness[k - 1]), 0.35 * torque_scale(wear, k)

        def law(at: Situation) -> Array:
            t = float(at.torque[k - 1])
            return only(arm.n, k, np.sign(t) * s * knee / stiff * -np.expm1(-abs(t) / knee))

        return with_law(wear, law), {f"softness joint-{k} 1": s, f"knee joint-{k} N*m": knee}

    return Ailment("joint-hardening", (f"joint-{k}",), "tangent compliance (1 + s exp(-|torque|/knee))/K", apply, 0.3)


def softening(k: int) -> Ailment:
    """The flank against the last rotation is softer."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        ratio = wear.ratio.copy()
        ratio[k - 1] = 1 / (1 + s)
        return replace(wear, ratio=ratio), {f"ratio joint-{k}": float(ratio[k - 1])}

    law = "torque against the last rotation: stiffness K/(1+s)"
    return Ailment("preload-softening", (f"joint-{k}",), law, apply, 0.2)


def backlash(k: int, breakaway: float = 0.1) -> Ailment:
    """A gap; a torque beyond `breakaway` (of the typical torque) carries the link across."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        gap, slack = wear.gap.copy(), wear.breakaway.copy()
        gap[k - 1], slack[k - 1] = 1e-4 * s, breakaway * torque_scale(wear, k)
        values = {f"gap joint-{k} rad": float(gap[k - 1]), f"breakaway joint-{k} N*m": float(slack[k - 1])}
        return replace(wear, gap=gap, breakaway=slack), values

    law = "play of +-gap/2: side of the last rotation, or of the torque once it exceeds breakaway"
    return Ailment("backlash", (f"joint-{k}",), law, apply)


def friction(k: int, *, lag: bool = True, grip: float = 4.0) -> Ailment:
    """A dry bearing beside the drive."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        slip = 0.1 * s * torque_scale(wear, k)
        slips = only(arm.n, k, slip)
        if wear.friction is not None:
            alike = isinstance(wear.friction, Friction) and wear.friction.lag == lag
            if not alike or not np.all(wear.friction.grip == grip):
                raise ValueError("one cell has one kind of friction")
            slips = slips + wear.friction.slip
        worn = replace(wear, friction=Friction(slips, np.full(arm.n, grip), lag))
        return worn, {f"slip joint-{k} N*m": slip, f"grip joint-{k} 1": grip}

    law = "K d = torque - T, T = grip K (d - anchor) within +-slip; " + (
        "dragged along by the approach move" if lag else "loose after each approach move"
    )
    return Ailment("joint-friction", (f"joint-{k}",), law, apply, 0.5)


def hysteresis(levels: tuple[float, ...] = (0.05, 0.12, 0.3, 0.7), drag: float = 2.0) -> Ailment:
    """Several dry bearings beside the drive of every joint: a loop that is round, not a parallelogram.

    levels: torques at which they slip when the load alone moves the link, of the typical torque. drag: what they grip
    together over the stiffness of the drive, at factor 1; they share it alike.
    """

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        if wear.friction is not None:
            raise ValueError("one cell has one kind of friction")
        scale = np.array([torque_scale(wear, k + 1) for k in range(arm.n)])
        grip = np.full((len(levels), arm.n), s * drag / len(levels))
        # stuck together they take grip / (1 + sum of grips) of a load each
        slip = np.array(levels)[:, None] * scale * grip / (1 + grip.sum(axis=0))
        values = {f"slip {b + 1} joint-{k + 1} N*m": float(v) for (b, k), v in np.ndenumerate(slip)}
        return replace(wear, friction=Bearings(slip, grip)), values

    law = "K d = torque - sum T_b, T_b = grip_b K (d - anchor_b) within +-slip_b, all joints; dragged along by moves"
    return Ailment("joint-friction", tuple(f"joint-{k}" for k in range(1, 7)), law, apply, 0.5)


def coupling(i: int, k: int) -> Ailment:
    """Compliance off the diagonal, made by a tendon over both joints; the diagonal stays what it was."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        a, b = 1 / wear.stiffness[i - 1], 1 / wear.stiffness[k - 1]
        cross = 0.2 * s * np.sqrt(a * b)
        K = np.linalg.inv([[a, cross], [cross, b]])
        if s == 0:
            return wear, {f"compliance joint-{i} joint-{k} rad/(N*m)": 0.0}
        tie = Tie(only(arm.n, i, 1.0) + only(arm.n, k, float(np.sign(K[0, 1]))), abs(float(K[0, 1])))
        own = wear.stiffness.copy()
        own[i - 1], own[k - 1] = K[0, 0] - tie.stiffness, K[1, 1] - tie.stiffness
        if not min(own[i - 1], own[k - 1]) > 0:
            raise ValueError(f"coupling of joints {i} and {k} by {s}: a spring would be negative")
        values = {f"compliance joint-{i} joint-{k} rad/(N*m)": float(cross)}
        return replace(wear, ties=(*wear.ties, tie), stiffness=own), values

    law = f"deflection of joint {i} gains c x torque of joint {k} and the other way round (tendon spring)"
    return Ailment("joint-coupling", (f"joint-{i}", f"joint-{k}"), law, apply, 0.5)


def waves(joints: tuple[int, ...] = (2, 3, 5), turns: int = 2, phase: float = 0.7) -> Ailment:
    """A compliance that waves with the own angle of several joints: so many waves in a turn, each joint's begins
    elsewhere."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        def law(at: Situation) -> Array:
            out = np.zeros(arm.n)
            for k in joints:
                share = s * (0.5 + 0.5 * np.sin(turns * float(at.angle[k - 1]) + phase * k))
                out[k - 1] = share * float(at.torque[k - 1]) / float(wear.stiffness[k - 1])
            return out

        return with_law(wear, law), {f"amplitude joint-{k} 1": s for k in joints}

    formula = f"compliance (1 + s (1 + sin({turns} q + {phase:g} k))/2)/K of joint k"
    return Ailment("posture-stiffness", tuple(f"joint-{k}" for k in joints), formula, apply, 0.3)


def posture(k: int, shape: str = "bump") -> Ailment:
    """A compliance that depends on the joint's own angle; on healthy joints alone."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        low, high = max(arm.lower[k - 1], -np.pi), min(arm.upper[k - 1], np.pi)
        centre, width, stiff = (low + high) / 2, (high - low) / 6, float(wear.stiffness[k - 1])

        def more(q: float) -> float:
            if shape == "bump":
                return float(np.exp(-0.5 * ((q - centre) / width) ** 2))
            return float(1 + np.cos(2 * (q - centre))) / 2

        def law(at: Situation) -> Array:
            return only(arm.n, k, s * more(float(at.angle[k - 1])) * float(at.torque[k - 1]) / stiff)

        values = {f"amplitude joint-{k} 1": s, f"centre joint-{k} rad": centre, f"width joint-{k} rad": width}
        return with_law(wear, law), values

    formula = "exp(-((q-c)/w)^2/2)" if shape == "bump" else "(1+cos(2(q-c)))/2"
    return Ailment("posture-stiffness", (f"joint-{k}",), f"compliance (1 + s {formula})/K", apply, 0.3)
