"""Inverse kinematics in closed form for arms with a spherical wrist.

Pieper's case (D. L. Pieper, Stanford AIM-72, 1968), written on the screw axes of the arm at q = 0, so that it
does not depend on how a file describes the arm. Needed: axes 4, 5, 6 meet in a point, 5 is normal to 4 and to
6, axis 2 is parallel to 3 and normal to 1. Any offset along axis 2 is allowed.

Arm axes F: z along axis 1 (upwards in the base), x from axis 1 towards axis 2, y = z cross x along axis 2. In
the plane of the arm a point is the complex number z + i x, and a turn about y multiplies it by exp(i angle).
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.robot.robot import Robot, constant

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_PARALLEL = 1e-9  # rad: files write pi/2 with 10 to 16 digits
_MEET = 1e-9  # m


@dataclass(frozen=True, eq=False)
class SphericalArm:
    """Geometry of an arm with a spherical wrist.

    Attributes:
        arm: (3, 3) columns x, y, z of F in the base, at q1 = 0.
        origin: (3,) m, point of axis 1 that F stands in.
        shoulder: (x, z) m of axis 2 in F.
        lateral: m, wrist centre along y.
        upper, fore: complex m, axis 2 to axis 3 and axis 3 to the wrist centre, at q = 0.
        wrist: (3, 3) columns of W in the base at q = 0: z along axis 4, y along axis 5.
        bend: rad, turn about y from axis 4 to axis 6 at q5 = 0, within a quarter turn.
        signs: (6,) +1 or -1: sense of each joint against y and z of F and W.
        flange: (3, 3) rotation of the flange at q = 0.
        centre: (3,) m, wrist centre in the flange frame.
    """

    arm: Floats
    origin: Floats
    shoulder: tuple[float, float]
    lateral: float
    upper: complex
    fore: complex
    wrist: Floats
    bend: float
    signs: Floats
    flange: Floats
    centre: Floats


def spherical_arm(robot: Robot) -> SphericalArm | None:
    """The geometry, or None when the arm has no spherical wrist (or another arm than this solves)."""
    axes, points, flange = _screws(robot)
    centre = _meeting_point(axes[3:], points[3:])
    if centre is None or not _solvable(axes):
        return None
    z = axes[0] * (1.0 if axes[0][2] >= -_PARALLEL else -1.0)
    towards = points[1] - points[0]
    towards = towards - z * (z @ towards) - axes[1] * (axes[1] @ towards)
    if np.linalg.norm(towards) < 1e-6:  # axis 2 crosses axis 1: the front is where base x points
        towards = np.cross(axes[1], z)
        towards = towards if towards[0] >= 0 else -towards
    x = towards / np.linalg.norm(towards)
    arm = np.column_stack([x, np.cross(z, x), z])
    at = [arm.T @ (p - points[0]) for p in (points[1], points[2], centre)]
    bend, sense = _bend(axes)
    y = arm[:, 1]
    signs = [np.sign(axes[0] @ z), np.sign(axes[1] @ y), np.sign(axes[2] @ y), 1.0, 1.0, sense]
    return SphericalArm(
        arm=arm,
        origin=points[0],
        shoulder=(float(at[0][0]), float(at[0][2])),
        lateral=float(at[2][1]),
        upper=complex(at[1][2] - at[0][2], at[1][0] - at[0][0]),
        fore=complex(at[2][2] - at[1][2], at[2][0] - at[1][0]),
        wrist=np.column_stack([np.cross(axes[4], axes[3]), axes[4], axes[3]]),
        bend=bend,
        signs=np.array(signs),
        flange=flange[:3, :3],
        centre=flange[:3, :3].T @ (centre - flange[:3, 3]),
    )


def _screws(robot: Robot) -> tuple[list[Floats], list[Floats], Floats]:
    """Axes and points of all joints, and the flange, in the base at q = 0."""
    axes, points, pose = [], [], np.eye(4)
    for k in range(robot.n):
        pose = pose @ robot.before[k]
        axes.append(pose[:3, :3] @ robot.axis[k])
        points.append(pose[:3, 3].copy())
        pose = pose @ robot.after[k]
    return axes, points, pose


def _meeting_point(axes: list[Floats], points: list[Floats]) -> Floats | None:
    across = [np.eye(3) - np.outer(w, w) for w in axes]
    matrix, vector = np.vstack(across), np.concatenate([a @ p for a, p in zip(across, points, strict=True)])
    centre, _, rank, _ = np.linalg.lstsq(matrix, vector, rcond=1e-9)
    off = max(float(np.linalg.norm(a @ (centre - p))) for a, p in zip(across, points, strict=True))
    return centre if rank == 3 and off < _MEET else None


def _solvable(axes: list[Floats]) -> bool:
    normal = (axes[0] @ axes[1], axes[3] @ axes[4], axes[4] @ axes[5])
    return float(max(abs(c) for c in normal)) < _PARALLEL and bool(
        np.linalg.norm(np.cross(axes[1], axes[2])) < _PARALLEL
    )


def _bend(axes: list[Floats]) -> tuple[float, float]:
    """Turn about axis 5 from axis 4 to axis 6, and whether axis 6 was reversed to keep it within 90 deg."""
    sense = -1.0 if axes[3] @ axes[5] < -_PARALLEL else 1.0
    x = np.cross(axes[4], axes[3])
    return float(np.arctan2(sense * (axes[5] @ x), sense * (axes[5] @ axes[3]))), sense


def closed_form(arm: SphericalArm) -> ca.Function:
    """The inverse as one SX function: (R (9) row-major, p (3) m, signs (3)) -> (q (6), margins (3), wrist).

    signs: +1 or -1 for: wrist centre before axis 1, before the lower arm, axis 5 bent to its positive side.
    margins, m: wrist centre from axis 1 beyond its lateral offset; to the stretched arm; to the folded arm: a
    negative one is out of reach. wrist: |sin| of the bend of the wrist, zero where axes 4 and 6 are in line.
    """
    flat, p, branch = ca.SX.sym("R", 9), ca.SX.sym("p", 3), ca.SX.sym("branch", 3)
    rotation = ca.reshape(flat, 3, 3).T
    at = ca.mtimes(constant(arm.arm.T), p + ca.mtimes(rotation, constant(arm.centre)) - constant(arm.origin))
    q1, phi2, phi3, margins = _position(arm, at, branch)
    turn = ca.mtimes(_turn_y(-phi2 - phi3), _turn_z(-q1))
    inner = ca.mtimes(
        [constant(arm.arm.T), rotation, constant(arm.flange.T @ arm.wrist @ _np_turn_y(arm.bend))]
    )
    m = ca.mtimes([constant(arm.wrist.T @ arm.arm), turn, inner])  # = Rz(q4) Ry(q5 + bend) Rz(q6)
    wrist = ca.sqrt(m[0, 2] * m[0, 2] + m[1, 2] * m[1, 2])
    q4 = ca.atan2(branch[2] * m[1, 2], branch[2] * m[0, 2])
    q5 = ca.atan2(branch[2] * wrist, m[2, 2]) - arm.bend
    c, s = ca.cos(q4), ca.sin(q4)
    q6 = ca.atan2(c * m[1, 0] - s * m[0, 0], c * m[1, 1] - s * m[0, 1])
    q = ca.vertcat(q1, phi2, phi3, q4, q5, q6) * ca.DM(arm.signs)
    outputs = [ca.densify(e) for e in (q, margins, wrist)]
    return ca.Function("inverse", [flat, p, branch], outputs, ["R", "p", "branch"], ["q", "margins", "wrist"])


def _position(arm: SphericalArm, at: ca.SX, branch: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """Turns about z, y, y that bring the wrist centre to ``at`` (3,) in F, and the margins."""
    b, long, short = arm.lateral, abs(arm.upper), abs(arm.fore)
    around = at[0] * at[0] + at[1] * at[1]
    ahead = branch[0] * ca.sqrt(ca.fmax(around - b * b, 0))
    q1 = ca.atan2(at[1] * ahead - at[0] * b, at[0] * ahead + at[1] * b)
    u, v = at[2] - arm.shoulder[1], ahead - arm.shoulder[0]
    square = u * u + v * v
    product = ca.fmax(((long + short) ** 2 - square) * (square - (long - short) ** 2), 0)
    cosine = square - (long**2 + short**2)  # times 2 long short, like the sine
    elbow = ca.atan2(branch[1] * ca.sqrt(product), cosine)
    reach_u, reach_v = long + short * ca.cos(elbow), short * ca.sin(elbow)
    phi2 = ca.atan2(v * reach_u - u * reach_v, u * reach_u + v * reach_v) - float(np.angle(arm.upper))
    phi3 = elbow + float(np.angle(arm.upper)) - float(np.angle(arm.fore))
    distance = ca.sqrt(square)
    margins = ca.vertcat(ca.sqrt(around) - abs(b), long + short - distance, distance - abs(long - short))
    return q1, phi2, phi3, margins


@dataclass(frozen=True, eq=False)
class BranchMeasures:
    """Signed measures of postures q (N, 6): positive on branch 0.

    Attributes:
        ahead: (N,) m, wrist centre before axis 1.
        elbow: (N,) sin of the angle from lower arm to wrist centre.
        wrist: (N,) sin of the bend of the wrist.
    """

    ahead: Floats
    elbow: Floats
    wrist: Floats

    def branch(self) -> Ints:
        """(N,) branch bits: 4 behind axis 1, 2 behind the lower arm, 1 axis 5 bent to its negative side."""
        return np.asarray(4 * (self.ahead < 0) + 2 * (self.elbow < 0) + 1 * (self.wrist < 0))


def branch_measures(arm: SphericalArm, q: Floats) -> BranchMeasures:
    """Where postures q (N, 6) rad stand among the branches."""
    phi2, phi3 = arm.signs[1] * q[:, 1], arm.signs[2] * q[:, 2]
    ahead = arm.shoulder[0] + (arm.upper * np.exp(1j * phi2) + arm.fore * np.exp(1j * (phi2 + phi3))).imag
    elbow = np.sin(phi3 + np.angle(arm.fore) - np.angle(arm.upper))
    return BranchMeasures(ahead, elbow, np.sin(q[:, 4] + arm.bend))


def _turn_z(angle: ca.SX) -> ca.SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def _turn_y(angle: ca.SX) -> ca.SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, 0, s), ca.horzcat(0, 1, 0), ca.horzcat(-s, 0, c))


def _np_turn_y(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
