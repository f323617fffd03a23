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

from toolpaths.programs.program import Floats, Ints

#: What the controller counts as 180 deg, deg: measured between 0.0004 and 0.0007.
TURN_TOLERANCE = 5e-4


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
