"""Fanuc's CONFIG and joint angles of an arm whose model turns its joints as Fanuc does.

CONFIG 'F U T, t1, t4, t6': F where J5 > 0, else N; U where the elbow is up, else D; T where the wrist centre is in
front of axis 1, else B; turn numbers of J1, J4, J6: 0 strictly between -180 and 180 deg, 1 from 180 to below 540,
-1 from -180 down to above -540. Within 0.0005 deg of 180 the controller counts the next turn. Measured on ROBOGUIDE
(M-20iD/25), published as the probes of the project crossarm (fanuc_config, test_configuration); U and D follow the
wrist centre behind the lower arm there, as ABB's cfx does.
J3 counts from the horizontal: J3 = q3 - q2 with q3 between the links, as in the ROS URDFs of Fanuc arms, whose signs
and zeros are Fanuc's (ROS-Industrial's fanuc_driver calls it J23_factor = 1; ROBOGUIDE agrees).
"""

from __future__ import annotations

import numpy as np

from toolpaths.writing.program import Floats, Ints

#: What the controller counts as 180 deg, deg: measured between 0.0004 and 0.0007.
TURN_TOLERANCE = 5e-4
#: How far the model's joint angles may be off those of the controller's own kinematics, deg.
NOISE = 0.1


def turn_numbers(degrees: Floats) -> Ints:
    """Turn number of each angle, deg."""
    whole = np.floor((np.abs(degrees) + (180.0 + TURN_TOLERANCE)) / 360.0)
    return (np.sign(degrees) * whole).astype(np.int32)


def config_texts(joints: Floats, configuration: Ints | None) -> list[str]:
    """CONFIG of joint angles (N, 6) rad and configuration bits (N,) as in Program."""
    turns = turn_numbers(np.degrees(joints[:, [0, 3, 5]]))
    bits = np.zeros(len(joints), dtype=np.int32) if configuration is None else configuration
    rows = [(b, *t) for b, t in zip(bits.tolist(), turns.tolist(), strict=True)]
    made = {row: f"{letters(row[0])}, {row[1]}, {row[2]}, {row[3]}" for row in set(rows)}
    return [made[row] for row in rows]


def continued_turns(said: Floats, nominal: Floats, commanded: Floats) -> Ints:
    """Turn numbers (N, K) of joints that a correction moved, counted as the program counts them.

    Args:
        said: (N, K) turn numbers of the program for the nominal poses, in the order of the moves; NaN: not given.
        nominal: (N, K) deg, joint angles there by the model, perhaps in other whole turns than the controller's.
        commanded: (N, K) deg, behind the correction, in the model's turns.

    The model's turns are the controller's but for a whole number, which ``said`` gives at every pose. Within NOISE of
    180 deg it can be either of two there: then it is that of the pose before, since the joint turned continuously; and
    what the program has stays, unless the correction itself leads past 180 deg.
    """
    away = said - nominal / 360.0
    whole = np.rint(away)
    sure = np.abs(away - whole) <= 0.5 - NOISE / 360.0
    for k in np.flatnonzero(~sure.all(axis=0)).tolist():
        told = np.flatnonzero(sure[:, k] if sure[:, k].any() else np.isfinite(away[:, k]))
        last = whole[told[0], k] if len(told) else 0.0
        for i in np.flatnonzero(~sure[:, k]).tolist():
            if i > 0:
                last = whole[i - 1, k]
            if not abs(away[i, k] - last) >= 1.0:  # also where no number is given
                whole[i, k] = last
    out, before = turn_numbers(commanded + 360.0 * whole), turn_numbers(nominal + 360.0 * whole)
    close = [np.abs((q % 360.0) - 180.0) < NOISE for q in (nominal, commanded)]
    kept = close[0] & close[1] & np.isfinite(said)
    out[kept] += said[kept].astype(np.int32) - before[kept]
    return out


def letters(bits: int) -> str:
    """``N U T`` of configuration bits 4 = behind axis 1, 2 = behind the lower arm, 1 = joint 5 negative."""
    return f"{'N' if bits & 1 else 'F'} {'D' if bits & 2 else 'U'} {'B' if bits & 4 else 'T'}"


def bits_of(text: str) -> int:
    """Configuration bits of ``N U T``; ValueError where it is not that."""
    words = text.split()
    if len(words) != 3 or words[0] not in ("N", "F") or words[1] not in ("U", "D") or words[2] not in ("T", "B"):
        raise ValueError(text)
    return (words[2] == "B") * 4 + (words[1] == "D") * 2 + (words[0] == "N")


def controller_joints(q: Floats) -> Floats:
    """Angles as the controller counts them, of (..., 6) rad of the model."""
    out = np.array(q, dtype=np.float64)
    out[..., 2] -= out[..., 1]
    return out


def model_joints(j: Floats) -> Floats:
    """Angles of the model, of (..., 6) rad as the controller counts them."""
    out = np.array(j, dtype=np.float64)
    out[..., 2] += out[..., 1]
    return out
