"""Joint friction: a torque that the drive train holds without moving, so that wind-up stays.

    dq = (f_1 + ... + f_4) / K    f_k' = min(max(f_k - b_k (d tau + K move), -T_k), T_k)    (on top of joint-stiffness)

Stop operators side by side (Prandtl-Ishlinskii: Visintin, Differential Models of Hysteresis, 1994; Al-Bender, Swevers,
generalized Maxwell-slip model, 2005; Kuhnen 2003 for fixed thresholds with free weights): f_k takes up the share b_k of
every change of load until it slips at T_k. Each is a spring with a slider beside that of the joint; b = 1 sticks
without yielding. Thresholds stand in fixed ratios to the first operator's, T / b:

    T_k = r_k T w_k / W    b_k = b w_k / W    r = 1, 1/2, 2, 1/4    w_1 = 1    W = 1 + w_2 + w_3 + w_4

so that b is the share of all together. Without the others (w = 0) it is one operator: loading and unloading differ by
up to 2 T/K at the same command. A commanded move drags the link along as a load would: the friction has turned over
after a travel of 2 T/(b K), and the link lags behind the motor by T/K from there on. ``lag`` 0: any move beyond
REVERSAL shakes it free of wind-up.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from stiffness.effects.effect import REVERSAL, Effect, Floats, JointInput, Numbers, Parameter, Values
from stiffness.effects.memory import Clamp, Memory, TargetClamp

RATIOS = (1.0, 0.5, 2.0, 0.25)  # of the operators' thresholds: 8 to 1 in octaves, the first one's in their middle
WEIGHTS = ("weight_half", "weight_double", "weight_quarter")  # of the operators after the first


def _law(given: JointInput, p: Values) -> ca.SX:
    n = given.compliance.shape[0]
    return sum((given.state[k * n : (k + 1) * n] for k in range(1, len(RATIOS))), given.state[:n]) * given.compliance


def _shares(p: Numbers) -> list[Floats]:
    """Of every operator in the load that is held: they add up to 1; numbers or symbols (n,)."""
    weights = [p[name] for name in WEIGHTS]
    whole = sum(weights, 1 + 0 * p["friction_nm"])
    return [1 / whole, *(w / whole for w in weights)]


def _bounds(p: Numbers) -> Floats:
    torques: list[Any] = [r * share * p["friction_nm"] for r, share in zip(RATIOS, _shares(p), strict=True)]
    return ca.vertcat(*torques) if isinstance(torques[0], ca.SX) else np.concatenate(torques)


def _rule(move: Floats, torque: Floats, p: Numbers, stiffness: Floats) -> Clamp:
    most = np.broadcast_to(_bounds(p), (*move.shape[:-1], len(RATIOS) * move.shape[-1]))
    # no drive turns a link over at once: where the base model is rigid, a reversal does
    travel = move * np.minimum(stiffness, 4 * p["friction_nm"] / p["held"] / REVERSAL)
    driven = p["held"] * (np.diff(torque, axis=0, prepend=torque[:1]) + travel)
    half = np.concatenate([1 - _shaken(move, p)] * len(RATIOS), axis=-1) * most
    shift = np.concatenate([-driven * share for share in _shares(p)], axis=-1)
    return Clamp(shift, -half, half)


def _deflection(state: Floats, stiffness: Floats) -> Floats:
    return np.asarray(state.reshape(*state.shape[:-1], len(RATIOS), -1).sum(axis=-2) / stiffness)


def _by_target(move: Floats, torque: Floats, p: Numbers, stiffness: Floats) -> TargetClamp:
    """Stop operators again, by the moves of the target: the inverse of a Prandtl-Ishlinskii operator is one
    (Krejci, Kuhnen 2001).

    Let v be what drives the operators (load, and K times the command), z_k = -f_k / b_k, and u what would drive them if
    the command were not corrected: u = v - sum b_k z_k. On a first loading, between the thresholds of the next smaller
    operator and of operator k, u grows by the share c_k = 1 - sum of b of all that still stick: so its threshold in u
    is rho_k = rho_(k-1) + (r_k - r_(k-1)) c_k, and v is u by stop operators with these. Hence z_k from theirs, y_j:

        z_k = y_k / c_k + sum over smaller j of (1 / c_j - 1 / c_(j + 1)) y_j
    """
    order, n = np.argsort(RATIOS), move.shape[-1]
    share = np.stack([s * p["held"] for s in _shares(p)])[order]
    r = np.array(RATIOS)[order][:, None]
    c = np.maximum(1 - np.cumsum(share[::-1], axis=0)[::-1], 1e-9)  # what sticks fully moves by nothing
    rho = np.cumsum(np.diff(r, axis=0, prepend=0) * c, axis=0)
    mix = np.zeros((n, len(r), len(r)))
    for k in range(len(r)):
        mix[:, order[k], order[k]] = rho[k] / c[k] / r[k]
        for j in range(k):
            mix[:, order[k], order[j]] = rho[j] * (1 / c[j] - 1 / c[j + 1]) / r[k]
    threshold = np.maximum(rho[np.argsort(order)] * p["friction_nm"] / p["held"], 1e-9)
    # as if the command were not corrected for friction: corrected for the load it is, so a link that stays takes none
    travel = move + np.diff(torque, axis=0, prepend=torque[:1]) / stiffness
    shift = [-travel * np.minimum(stiffness, 4 * t / REVERSAL) / t for t in threshold]
    free = np.concatenate([1 - _shaken(move, p)] * len(r), axis=-1)
    return TargetClamp(Clamp(np.concatenate(shift, axis=-1), -free, free), mix)


def _shaken(move: Floats, p: Numbers) -> Floats:
    """The share of the wind-up that a move shakes off."""
    return np.asarray((1 - p["lag"]) * np.minimum(np.abs(move) / (0.5 * REVERSAL), 1.0))


def _restarts(p: Numbers) -> tuple[dict[str, Floats], ...]:
    """All four operators at work, the first with most of it."""
    return ({**p, **{name: np.full_like(p["friction_nm"], 0.3) for name in WEIGHTS}},)


EFFECT = Effect(
    name="joint-friction",
    cause="dry friction in the drive train holds part of the load: wind-up stays, loading and unloading differ",
    scope="robot",
    site_kind="joint",
    parameters=(
        Parameter(
            name="friction_nm",
            unit="N*m",
            size="joint",
            start=10.0,
            low=0.0,
            high=1e5,
            scale=20.0,
            meaning="torque that friction holds",
            neutral=0.0,
            trials=(0.02, 0.08, 0.25),
            trials_of="torque",
        ),
        Parameter(
            name="held",
            unit="1",
            size="joint",
            start=0.8,
            low=0.05,
            high=1.0,
            scale=0.3,
            meaning="share of a change of load that sticking holds",
            default=1.0,
        ),
        Parameter(
            name="lag",
            unit="1",
            size="joint",
            start=1.0,
            low=0.0,
            high=1.0,
            scale=1.0,
            meaning="after a move the link lags behind: 1, is free of wind-up: 0",
            default=1.0,
            fit="given",
            trials=(1.0, 0.0),
        ),
        *(
            Parameter(
                name=name,
                unit="1",
                size="joint",
                start=0.0,
                low=0.0,
                high=100.0,
                scale=1.0,
                meaning=f"weight of an operator that slips at {ratio:g} times the load of the first; that has 1",
                default=0.0,
                neutral=0.0,
                extra=True,
            )
            for name, ratio in zip(WEIGHTS, RATIOS[1:], strict=True)
        ),
    ),
    joint=_law,
    memory=Memory(
        unit="N*m",
        rule=_rule,
        bounds=_bounds,
        states=len(RATIOS),
        deflection=_deflection,
        by_target=_by_target,
    ),
    restarts=_restarts,
    needs_torque_sign=True,
)
