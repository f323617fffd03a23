"""Small rotations in symbols: rotation vector to matrix and back, and the generalised force of a moment."""

from __future__ import annotations

import casadi as ca


def rotation(vector: ca.SX) -> ca.SX:
    """Rotation matrix of a small rotation vector: exact to rounding below 0.05 rad, smooth at zero.

    Cayley form with the tangent of the half angle as a series, so that the result is orthogonal
    whatever the length of the vector.
    """
    t2 = ca.dot(vector, vector)
    g = vector * (0.5 + t2 * (1 / 24 + t2 * (1 / 240 + t2 * (17 / 40320))))
    s = ca.skew(g)
    return ca.SX.eye(3) + 2 / (1 + ca.dot(g, g)) * (s + ca.mtimes(s, s))


def vector_of(turn: ca.SX) -> ca.SX:
    """Rotation vector (3,) of a small rotation matrix, to first order."""
    return 0.5 * ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])


def generalised_moment(phi: ca.SX, moment: ca.SX) -> ca.SX:
    """The generalised force that a moment (3,) does to a rotation vector: J_l(phi)^T m, J_l the left Jacobian.

    Sola, Deray, Atchuthan, arXiv 1812.01537, appendix B; as a series, like ``rotation``.
    """
    t2 = ca.dot(phi, phi)
    once = ca.cross(phi, moment)
    first = 0.5 - t2 * (1 / 24 - t2 * (1 / 720 - t2 / 40320))
    second = 1 / 6 - t2 * (1 / 120 - t2 * (1 / 5040 - t2 / 362880))
    return moment - first * once + second * ca.cross(phi, once)
