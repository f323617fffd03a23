"""Where a point of a deflected arm is, and how it moves with every elastic coordinate.

Plain kinematics on the frames that the statics gives: a joint turns all outward of it about its axis, a place
that yields moves and turns all outward of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.numerics.kernel import Kernel
from stiffness.statics.statics import Statics

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False)
class ArmFrames:
    """Frames of N deflected arms, in the base.

    Attributes:
        rotation, origin: (N, n + 1, 3, 3) and (N, n + 1, 3) of the links.
        axis, joint: (N, n, 3) direction and a point of every joint's axis.
        place: (N, K, 3, 3) axes of the places that yield.
        turn: (N, K, 3) rotation vector of every such place.
    """

    rotation: Floats
    origin: Floats
    axis: Floats
    joint: Floats
    place: Floats
    turn: Floats

    def take(self, rows: Index) -> ArmFrames:
        """Some of them."""
        return ArmFrames(*(a[rows] for a in (self.rotation, self.origin, self.axis, self.joint, self.place, self.turn)))


class PointMotion:
    """Frames of one arm."""

    def __init__(self, statics: Statics) -> None:
        self.statics, n = statics, statics.robot.n
        q, x = ca.SX.sym("q", n), ca.SX.sym("x", statics.n_x)
        p = statics.posture(q, x)
        out = [ca.vertcat(*(ca.vec(f.rotation.T) for f in p.links)), ca.vertcat(*(f.origin for f in p.links))]
        out += [ca.vertcat(*p.axes), ca.vertcat(*(f.origin for f in p.joints))]
        out.append(ca.vertcat(*(ca.vec(p.places[k].rotation.T) for k in statics.places)))
        self._kernel = Kernel(ca.Function("frames", [q, x], [ca.densify(v) if v.numel() else ca.SX(0, 1) for v in out]))

    def frames(self, q: Floats, x: Floats) -> ArmFrames:
        """Frames at joint angles q (N, n) rad with elastic coordinates x (N, n_x)."""
        count, n, k = len(q), self.statics.robot.n, len(self.statics.places)
        rotation, origin, axis, joint, place = self._kernel.run(q, x)
        return ArmFrames(
            rotation=rotation.reshape(count, n + 1, 3, 3),
            origin=origin.reshape(count, n + 1, 3),
            axis=axis.reshape(count, n, 3),
            joint=joint.reshape(count, n, 3),
            place=place.reshape(count, k, 3, 3),
            turn=x[:, n:].reshape(count, k, 6)[:, :, 3:],
        )

    def slopes(self, frames: ArmFrames, link: int, point: Floats) -> Floats:
        """(N, 3, n_x): how points (N, 3) m of a link, given in the base, move with the coordinates."""
        n = self.statics.robot.n
        out = np.zeros((len(point), 3, self.statics.n_x))
        for k in range(link):
            out[:, :, k] = np.cross(frames.axis[:, k], point - frames.joint[:, k])
        for i, k in enumerate(self.statics.places):
            if k > link:
                continue
            at, turn = frames.place[:, i], frames.turn[:, i]
            arm = point - frames.origin[:, k]
            for c in range(3):
                unit = np.broadcast_to(np.eye(3)[c], turn.shape)
                about = unit + 0.5 * np.cross(turn, unit)  # left Jacobian of a small rotation vector
                out[:, :, n + 6 * i + c] = at[:, :, c]
                out[:, :, n + 6 * i + 3 + c] = np.cross(np.einsum("nij,nj->ni", at, about), arm)
        return out
