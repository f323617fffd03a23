"""Wrench scale: whether displacements ask for the wrench turned round, or in another unit, and not as it stands there.

Displacements are linear in the compliance of the joints, d = sum_j a_j J_j dtau_j. Compliances are positive: where they
fit far better with the wrench turned round, its sign is wrong. And they have a size: under its own weight no arm turns
a joint by a tenth of a radian, or by a hundred-thousandth; where they would, the wrench is in another unit.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls

from stiffness.diagnosis.doubt import Doubt
from stiffness.identification.session_fit import SessionFit
from stiffness.numerics.kernel import Kernel
from stiffness.statics.statics import Statics

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

# studied in tests/stiffness/diagnosis/test_doubts.py
WORSE = 2.0  # times: so much more than turned round the displacements are missed before a sign is called wrong
CLEAR = 0.5  # of the mean square of displacements has to be explained by springs before they say anything
SAG = (3e-5, 0.1)  # rad under its own weight, three decades and a half about the 1 to 5 mrad of industrial arms
FEWEST = 5  # displacements per joint
COLUMNS = "columns fx fy fz mx my mz"


def wrench_doubt(fit: SessionFit) -> Doubt | None:
    """What is wrong with the wrench of a session as a whole; None where nothing is, or nothing tells."""
    found = _Compliances.of(fit) if fit.session.has_wrench else None
    if found is None:
        return None
    where = f"{fit.session.samples_file}, {COLUMNS}"
    best = min(found.missed, found.turned)
    if best**2 > (1 - CLEAR) * found.size**2:
        return None
    words = []
    if found.missed > WORSE * found.turned:
        words.append(
            f"the wrench seems to have the wrong sign: springs miss the displacements by {found.missed * 1e3:.3g} mm "
            f"(RMS) with it as it is, by {found.turned * 1e3:.3g} mm with all six columns negated. Expected is the "
            "wrench of the environment ON the robot"
        )
    unit = "in kN and kN*m" if found.sag > SAG[1] else "a thousand times too large (N written as mN)"
    if found.sag > SAG[1] or 0 < found.sag < SAG[0]:
        words.append(
            f"the wrench seems to be {unit}: as it is, joint {found.joint + 1} would turn by {found.sag * 1e3:.2g} "
            f"mrad under the arm's own weight, expected are {SAG[0] * 1e3:g} to {SAG[1] * 1e3:g}. Write N and N*m"
        )
    return Doubt(where, "; ".join(words), len(fit.samples)) if words else None


@dataclass(frozen=True)
class _Compliances:
    """What springs make of displacements: RMS per axis of the displacements, ``size``, and of what they miss with the
    wrench as it is and ``turned`` round, m; ``sag`` rad of the ``joint`` that carries most of the arm."""

    size: float
    missed: float
    turned: float
    sag: float
    joint: int

    @classmethod
    def of(cls, fit: SessionFit) -> _Compliances | None:
        rows, references = _pairs(fit)
        n = fit.session.robot.n
        if len(rows) < FEWEST * n:
            return None
        arm = _RigidArm.of(fit)
        carried = arm.torque[rows] - arm.torque[references]
        design = arm.slopes[rows] * carried[:, None, :]
        shown = fit.samples.position[rows] - fit.samples.position[references]
        flat = design.reshape(-1, n)
        scale = np.sqrt((flat**2).sum(axis=0))
        scale = np.where(scale > 0, scale, 1.0)
        count = np.sqrt(shown.size)
        compliance, missed = nnls(flat / scale, shown.reshape(-1))
        other, turned = nnls(-flat / scale, shown.reshape(-1))
        at_rest = np.abs(fit.predicted.torque[references] - arm.torque[references]).max(axis=0)
        joint = int(np.argmax(at_rest))
        found = (compliance if missed <= turned else other) / scale
        return cls(
            size=float(np.linalg.norm(shown) / count),
            missed=float(missed / count),
            turned=float(turned / count),
            sag=float(found[joint] * at_rest[joint]),
            joint=joint,
        )


def _pairs(fit: SessionFit) -> tuple[Index, Index]:
    """Loaded readings in use and their references, of reflectors that the arm moves, with the payload of these."""
    pairs, s = fit.session.pairs, fit.samples
    moving = fit.observations.data.link[pairs.row] > 0
    same = s.payload[pairs.row] == s.payload[pairs.reference]
    keep = fit.used[pairs.row] & fit.used[pairs.reference] & moving & same
    return pairs.row[keep], pairs.reference[keep]


@dataclass(frozen=True, eq=False)
class _RigidArm:
    """The rigid arm under the wrenches as they are read: ``torque`` (N, n) N*m that they put on the joints, ``slopes``
    (N, 3, n) m/rad of the readings by the joints, in their axes."""

    torque: Floats
    slopes: Floats

    @classmethod
    def of(cls, fit: SessionFit) -> _RigidArm:
        robot, s = fit.session.robot, fit.samples
        n, count = robot.n, len(s)
        statics, q = Statics(robot, ()), ca.SX.sym("q", n)
        posture = statics.posture(q, ca.SX.zeros(statics.n_x))
        frames = [ca.horzcat(link.rotation, link.origin) for link in posture.links]
        parts = [ca.vertcat(*posture.axes), ca.vertcat(*(j.origin for j in posture.joints)), *map(ca.vec, frames)]
        kernel = Kernel(ca.Function("arm", [q], [ca.densify(part) for part in parts]))
        axes, pivots, *shaped = kernel.run(s.q)
        axes, pivots = axes.reshape(count, n, 3), pivots.reshape(count, n, 3)
        links = np.stack([np.swapaxes(each.reshape(count, 4, 3), 1, 2) for each in shaped], axis=1)
        every = np.arange(count)

        def at(link: Index, point: Floats) -> Floats:
            frame = links[every, link]
            return np.asarray(np.einsum("nij,nj->ni", frame[:, :, :3], point) + frame[:, :, 3])

        load = s.load
        tool = links[:, n, :, :3] @ fit.session.tool.rotation
        axes_of = np.where(load.in_tool[:, None, None], tool, np.eye(3))
        force, moment = (np.einsum("nij,nj->ni", axes_of, load.wrench[:, k : k + 3]) for k in (0, 3))
        point = at(load.point_link, load.point)
        arm = np.cross(point[:, None] - pivots, force[:, None])
        torque = np.einsum("nkj,nkj->nk", axes, arm + moment[:, None])
        inward = np.arange(n)[None, :] < load.link[:, None]
        link = fit.observations.data.link
        lever = np.cross(axes, at(link, fit.reflectors[s.reflector])[:, None] - pivots)
        slopes = np.swapaxes(np.where((np.arange(n)[None, :] < link[:, None])[:, :, None], lever, 0.0), 1, 2)
        return cls(np.where(inward, torque, 0.0), fit.predicted.back @ slopes)
