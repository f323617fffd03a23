"""Postures of a UR10 in closed form (K. P. Hawkins, Analytic IK for the UR-5/UR-10 arms, 2013)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

A2, A3, D1, D4, D5, D6 = -0.612, -0.5723, 0.1273, 0.163941, 0.1157, 0.0922


def row(theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]])


def closed_form(t: np.ndarray) -> Iterator[np.ndarray]:
    """Up to eight postures (6,) rad that take up a flange pose (4, 4)."""
    wrist = t @ [0, 0, -D6, 1]
    radius, heading = np.hypot(wrist[0], wrist[1]), np.arctan2(wrist[1], wrist[0])
    if radius < D4:
        return
    for q1 in (heading + s * np.arccos(D4 / radius) + np.pi / 2 for s in (1, -1)):
        c5 = (t[0, 3] * np.sin(q1) - t[1, 3] * np.cos(q1) - D4) / D6
        if abs(c5) > 1:
            continue
        for q5 in (np.arccos(c5), -np.arccos(c5)):
            side = np.array([np.sin(q1), -np.cos(q1), 0]) @ t[:3, :2] / np.sin(q5)
            q6 = np.arctan2(-side[1], side[0])
            inner = np.linalg.inv(row(q1, D1, 0, np.pi / 2)) @ t
            inner = inner @ np.linalg.inv(row(q5, D5, 0, -np.pi / 2) @ row(q6, D6, 0, 0))
            x, y = (inner @ [0, -D4, 0, 1])[:2]
            c3 = (x * x + y * y - A2 * A2 - A3 * A3) / (2 * A2 * A3)
            if abs(c3) > 1:
                continue
            for q3 in (np.arccos(c3), -np.arccos(c3)):
                q2 = np.arctan2(y, x) - np.arctan2(A3 * np.sin(q3), A2 + A3 * np.cos(q3))
                last = np.linalg.inv(row(q2, 0, A2, 0) @ row(q3, 0, A3, 0)) @ inner
                yield np.array([q1, q2, q3, np.arctan2(last[1, 0], last[0, 0]), q5, q6])
