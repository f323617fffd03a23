"""Rotation matrices (N, 3, 3) <-> every vendor's way of writing an orientation. Angles in rad.

A matrix R takes vectors of the turned frame (TCP) to the fixed frame (work object): v_fixed = R v_tcp.
All Euler conventions in use are one of two orders:

- fixed axes x, y, z, which is the same as moving axes z, y', x'':  R = Rz(c) Ry(b) Rx(a)
  roll pitch yaw (ours), Fanuc W P R, Motoman Rx Ry Rz; KUKA A B C are the same three angles backwards
- moving axes x, y', z'':  R = Rx(a) Ry(b) Rz(c)
  Staubli Rx Ry Rz

In gimbal lock (b at +-90 deg) only a+c or a-c is determined: the turn about x is set to 0.
Sources: KUKA System Software 8.3, Operating and Programming Instructions for System Integrators
(A about Z, B about Y', C about X''); Fanuc R-30iB Operator's Manual (W, P, R about fixed X, Y, Z);
Yaskawa DX200 Relative Job manual (Rx, Ry, Rz about fixed axes); Staubli VAL3 Reference Manual, type trsf
(rx, ry, rz about moving axes); Universal Robots Script Manual (rotation vector);
ABB 3HAC16581, data type orient (unit quaternion q1 = real part).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

#: Below this cosine of the middle angle the other two are no longer told apart; forcing that costs 1e-9 rad.
GIMBAL_COSINE = 1e-9
#: Below this sine of the angle between two unit vectors the way between them is straight.
SMALL_SINE = 1e-9


def quaternion_from_matrix(matrix: Floats) -> Floats:
    """(..., 4) unit quaternion w, x, y, z with w >= 0 of (..., 3, 3).

    Shepperd 1978: the largest of the four components is taken from the diagonal, the others from it, so no
    digits are lost near half turns. Where w is 0, the first non-zero component is positive.
    """
    m = np.asarray(matrix, dtype=np.float64)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    # row i of `table` is 4 q_i * (w, x, y, z)
    table = np.empty((*m.shape[:-2], 4, 4))
    for i, square in enumerate((1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz)):
        table[..., i, i] = square
    pairs = (
        (0, 1, m[..., 2, 1] - m[..., 1, 2]), (0, 2, m[..., 0, 2] - m[..., 2, 0]),
        (0, 3, m[..., 1, 0] - m[..., 0, 1]), (1, 2, m[..., 1, 0] + m[..., 0, 1]),
        (1, 3, m[..., 0, 2] + m[..., 2, 0]), (2, 3, m[..., 2, 1] + m[..., 1, 2]),
    )  # fmt: skip
    for i, k, value in pairs:
        table[..., i, k] = table[..., k, i] = value
    best = np.argmax(np.einsum("...ii->...i", table), axis=-1)
    q = np.take_along_axis(table, best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return positive_quaternion(q)


def positive_quaternion(quaternion: Floats) -> Floats:
    """The one of q and -q whose first non-zero component is positive."""
    q = np.asarray(quaternion, dtype=np.float64)
    first = np.argmax(q != 0.0, axis=-1)
    lead = np.take_along_axis(q, first[..., None], axis=-1)
    return np.where(lead < 0.0, -q, q) + 0.0  # + 0.0: no negative zeros in programs


def matrix_from_quaternion(quaternion: Floats) -> Floats:
    """(..., 3, 3) of quaternions w, x, y, z (..., 4); they are normalised first."""
    q = np.asarray(quaternion, dtype=np.float64)
    return matrix_from_unit_quaternion(q / np.linalg.norm(q, axis=-1, keepdims=True))


def matrix_from_unit_quaternion(quaternion: Floats) -> Floats:
    """(..., 3, 3) of quaternions w, x, y, z (..., 4) of length 1."""
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    out = np.empty((*w.shape, 3, 3))  # entry by entry: no two of them in memory beside it
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 0, 1] = 2 * (x * y - w * z)
    out[..., 0, 2] = 2 * (x * z + w * y)
    out[..., 1, 0] = 2 * (x * y + w * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 1, 2] = 2 * (y * z - w * x)
    out[..., 2, 0] = 2 * (x * z - w * y)
    out[..., 2, 1] = 2 * (y * z + w * x)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return out


def slerp_quaternion(a: Floats, b: Floats, share: Floats) -> Floats:
    """Unit quaternions (M, 4) at ``share`` (M,) of the shorter way from ``a`` to ``b``."""
    return slerp(a, np.where(np.sum(a * b, axis=1, keepdims=True) < 0.0, -b, b), share)


def slerp(a: Floats, b: Floats, share: Floats) -> Floats:
    """Unit vectors (M, n) at ``share`` (M,) of the great circle from ``a`` to ``b``; where both are equal, ``a``."""
    chord = np.linalg.norm(b - a, axis=1)
    angle = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0))
    small = np.sin(angle) < SMALL_SINE
    sine = np.where(small, 1.0, np.sin(angle))
    left = np.where(small, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    right = np.where(small, share, np.sin(share * angle) / sine)
    out = left[:, None] * a + right[:, None] * b
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    return np.where(chord[:, None] == 0.0, a, out)


def rpy_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll); |pitch| <= 90 deg; roll 0 in gimbal lock."""
    m = np.asarray(matrix, dtype=np.float64)
    cosine = np.hypot(m[..., 0, 0], m[..., 1, 0])
    pitch = np.arctan2(-m[..., 2, 0], cosine)
    roll = np.where(cosine < GIMBAL_COSINE, 0.0, np.arctan2(m[..., 2, 1], m[..., 2, 2]))
    # yaw from R Rx(-roll), so that what rounding does to roll near gimbal lock is made good again
    sr, cr = np.sin(roll), np.cos(roll)
    yaw = np.arctan2(sr * m[..., 0, 2] - cr * m[..., 0, 1], cr * m[..., 1, 1] - sr * m[..., 1, 2])
    return np.stack((roll, pitch, yaw), axis=-1) + 0.0


def matrix_from_rpy(rpy: Floats) -> Floats:
    """(..., 3, 3): Rz(yaw) Ry(pitch) Rx(roll) of (..., 3) roll, pitch, yaw."""
    (cr, cp, cy), (sr, sp, sy) = _cosines_and_sines(rpy)
    rows = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def kuka_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) A, B, C: R = Rz(A) Ry(B) Rx(C); C = 0 in gimbal lock."""
    return rpy_from_matrix(matrix)[..., ::-1]


def matrix_from_kuka(abc: Floats) -> Floats:
    """(..., 3, 3) of A, B, C."""
    return matrix_from_rpy(np.asarray(abc, dtype=np.float64)[..., ::-1])


def fanuc_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) W, P, R: R = Rz(R) Ry(P) Rx(W); W = 0 in gimbal lock."""
    return rpy_from_matrix(matrix)


def matrix_from_fanuc(wpr: Floats) -> Floats:
    """(..., 3, 3) of W, P, R."""
    return matrix_from_rpy(wpr)


def motoman_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) Rx, Ry, Rz about fixed axes: R = Rz Ry Rx; Rx = 0 in gimbal lock."""
    return rpy_from_matrix(matrix)


def matrix_from_motoman(angles: Floats) -> Floats:
    """(..., 3, 3) of Rx, Ry, Rz about fixed axes."""
    return matrix_from_rpy(angles)


def staubli_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) rx, ry, rz about moving axes: R = Rx(rx) Ry(ry) Rz(rz); rx = 0 in gimbal lock."""
    m = np.asarray(matrix, dtype=np.float64)
    cosine = np.hypot(m[..., 0, 0], m[..., 0, 1])
    ry = np.arctan2(m[..., 0, 2], cosine)
    rx = np.where(cosine < GIMBAL_COSINE, 0.0, np.arctan2(-m[..., 1, 2], m[..., 2, 2]))
    sx, cx = np.sin(rx), np.cos(rx)
    rz = np.arctan2(cx * m[..., 1, 0] + sx * m[..., 2, 0], cx * m[..., 1, 1] + sx * m[..., 2, 1])
    return np.stack((rx, ry, rz), axis=-1) + 0.0


def matrix_from_staubli(angles: Floats) -> Floats:
    """(..., 3, 3): Rx(rx) Ry(ry) Rz(rz)."""
    return np.swapaxes(matrix_from_rpy(-np.asarray(angles, dtype=np.float64)), -1, -2)


def ur_from_matrix(matrix: Floats) -> Floats:
    """(..., 3) rotation vector: axis times angle, angle in [0, pi]."""
    q = quaternion_from_matrix(matrix)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(sine > 0.0, angle / sine, 2.0)
    return q[..., 1:] * scale + 0.0


def matrix_from_ur(vector: Floats) -> Floats:
    """(..., 3, 3) of a rotation vector of any length."""
    v = np.asarray(vector, dtype=np.float64)
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    return matrix_from_quaternion(np.concatenate((np.cos(half), 0.5 * v * np.sinc(half / np.pi)), axis=-1))


def turn_between(matrix: Floats) -> Floats:
    """(N-1,) rad, the angle from each orientation of (N, 3, 3) to the next.

    Sine from the skew part, cosine from the trace: exact for small turns, too.
    """
    m = np.asarray(matrix, dtype=np.float64)
    step = np.einsum("nji,njk->nik", m[:-1], m[1:])
    skew = (step[:, 2, 1] - step[:, 1, 2], step[:, 0, 2] - step[:, 2, 0], step[:, 1, 0] - step[:, 0, 1])
    sine = 0.5 * np.linalg.norm(np.stack(skew, axis=-1), axis=-1)
    cosine = 0.5 * (np.einsum("nii->n", step) - 1.0)
    return np.asarray(np.arctan2(sine, cosine), dtype=np.float64)


def rotation_of_axis(axis: Floats) -> Floats:
    """(N, 3, 3) with z = -axis, of tool axes (N, 3), and x as near to the x axis (where that fails, y) as can be."""
    z = -np.asarray(axis)
    side = np.where(np.abs(z[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    x = side - np.einsum("ni,ni->n", side, z)[:, None] * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return np.stack((x, np.cross(z, x), z), axis=-1)


def aligned(rotation: Floats, axis: Floats) -> Floats:
    """(N, 3, 3) orientations turned by the least angle that gives them the tool axes (N, 3).

    That is what a controller does that keeps the turn about the tool; opposite vectors have no such turn.
    """
    z, to = rotation[:, :, 2], -np.asarray(axis)
    v, cosine = np.cross(z, to), np.einsum("ni,ni->n", z, to)
    skew = np.zeros_like(rotation)
    skew[:, [2, 0, 1], [1, 2, 0]], skew[:, [1, 2, 0], [2, 0, 1]] = v, -v
    turn = np.eye(3) + skew + skew @ skew / (1.0 + cosine)[:, None, None]
    return np.asarray(turn @ rotation)


def matrix_about(direction: Floats, angle: Floats) -> Floats:
    """(N, 3, 3) turns about an axis of length 1 by (N,) rad."""
    x, y, z = direction
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.asarray(np.eye(3) + s * cross + (1.0 - c) * (cross @ cross))


def _cosines_and_sines(angles: Floats) -> tuple[Floats, Floats]:
    a = np.moveaxis(np.asarray(angles, dtype=np.float64), -1, 0)
    return np.cos(a), np.sin(a)
