"""Station: the numbers of a measurement set-up that are estimated with the robot's parameters.

The tracker's pose per block, reflectors that are only roughly known, and the placement of a rigid probe whose
reflectors form a group. A vector holds six numbers per pose [d; phi] and three per reflector, as increments on a first
guess. Of a registered session a pose is what the registration misses by (``registration``); of a registered trace there
is none: one path does not tell a frame from the arm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from stiffness.rotation import skew
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]


# studied in tests/stiffness/identification/test_registration.py
REGISTERED_SD = (2e-4,) * 6  # m, rad: of a frame that was measured on a robot
EXACT_SD = (1e-9,) * 6  # of one that is taken as it was declared


@dataclass(frozen=True)
class StationEntry:
    """One estimated pose or position: ``name`` for reports, and its ``span`` in the vector."""

    name: str
    span: slice


@dataclass(frozen=True, repr=False, eq=False)
class TrackerPoses:
    """First guess of every tracker pose in the base: ``rotation`` (B, 3, 3), ``origin`` (B, 3) m, by block."""

    rotation: Floats
    origin: Floats


class Station:
    """Layout and geometry of one session's own numbers; constant."""

    def __init__(self, session: Session) -> None:
        self.session = session
        s = session.samples
        fixed = session.registered and session.path is not None
        self.blocks = np.empty(0, dtype=np.int64) if fixed else np.unique(s.block)
        rough = [k for k, r in enumerate(session.reflectors) if not r.exact]
        self.single = [k for k in rough if session.group[k] < 0]
        self.groups = sorted({int(session.group[k]) for k in rough if session.group[k] >= 0})
        self.entries = self._layout()
        self.size = self.entries[-1].span.stop if self.entries else 0
        self._nominal = np.array([r.position for r in session.reflectors]).reshape(-1, 3)

    def __repr__(self) -> str:
        return f"Station({', '.join(e.name for e in self.entries) or 'nothing to estimate'})"

    def _layout(self) -> tuple[StationEntry, ...]:
        sizes = [(f"tracker block {b}", 6) for b in self.blocks]
        sizes += [(f"reflector {self.session.reflectors[k].name}", 3) for k in self.single]
        sizes += [(f"probe {self.session.reflectors[self._members(g)[0]].group}", 6) for g in self.groups]
        ends = np.cumsum([size for _, size in sizes])
        return tuple(StationEntry(name, slice(int(e) - n, int(e))) for (name, n), e in zip(sizes, ends, strict=True))

    def _members(self, group: int) -> list[int]:
        return [k for k, g in enumerate(self.session.group) if g == group]

    def prior_sd(self, exact: bool = False) -> Floats:
        """(S,) how far a first guess may be off, m and rad: so loose that of all equivalent solutions the one with the
        robot nearest to its drawing is the likeliest. ``exact``: a registration is taken as it was declared."""
        sd = np.empty(self.size)
        for entry in self.entries:
            six = entry.span.stop - entry.span.start == 6
            sd[entry.span] = [1.0] * 3 + [0.5] * 3 if six else [1.0] * 3
        if self.session.registered:
            sd[: 6 * len(self.blocks)] = (EXACT_SD if exact else REGISTERED_SD) * len(self.blocks)
        return sd

    def placed(self, base: Floats) -> TrackerPoses:
        """First guess of the tracker poses: the base where registered; else the rigid motion that fits predicted base
        positions (N, 3) best."""
        samples, count = self.session.samples, len(self.blocks)
        if self.session.registered:
            return TrackerPoses(np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3)))
        found = [
            rigid_fit(samples.position[samples.block == block], base[samples.block == block]) for block in self.blocks
        ]
        return TrackerPoses(
            np.array([rotation for rotation, _ in found]).reshape(-1, 3, 3),
            np.array([origin for _, origin in found]).reshape(-1, 3),
        )

    def reflectors(self, vector: Floats) -> Floats:
        """(R, 3) m, every reflector in the frame of its link."""
        out = self._nominal.copy()
        first = len(self.blocks)
        for k, entry in zip(self.single, self.entries[first:], strict=False):
            out[k] = self._nominal[k] + vector[entry.span]
        for g, entry in zip(self.groups, self.entries[first + len(self.single) :], strict=True):
            members = self._members(g)
            d, phi = vector[entry.span][:3], vector[entry.span][3:]
            origin = self._nominal[members[0]]
            turned = (self._nominal[members] - origin) @ Rotation.from_rotvec(phi).as_matrix().T
            out[members] = origin + d + turned
        return out

    def reflector_derivative(self, vector: Floats) -> Floats:
        """(R, 3, S) of every reflector's place in its link by the vector."""
        out = np.zeros((len(self._nominal), 3, self.size))
        first = len(self.blocks)
        for k, entry in zip(self.single, self.entries[first:], strict=False):
            out[k, :, entry.span] = np.eye(3)
        places = self.reflectors(vector)
        for g, entry in zip(self.groups, self.entries[first + len(self.single) :], strict=True):
            members = self._members(g)
            for k in members:
                arm = places[k] - places[members[0]]
                out[k, :, entry.span] = np.hstack([np.eye(3), -skew(arm[None])[0]])
        return out

    def seen(self, vector: Floats, base: Floats, poses: TrackerPoses) -> tuple[Floats, Floats, Floats]:
        """Positions (N, 3) as read, rotations (N, 3, 3) base -> reading, derivatives (N, 3, S) by tracker poses."""
        count = len(base)
        derivative = np.zeros((count, 3, self.size))
        if not len(self.blocks):
            return base, np.tile(np.eye(3), (count, 1, 1)), derivative
        which = np.searchsorted(self.blocks, self.session.samples.block)
        pose = vector[: 6 * len(self.blocks)].reshape(-1, 6)
        turn = Rotation.from_rotvec(pose[:, 3:]).as_matrix() @ poses.rotation
        origin = poses.origin + pose[:, :3]
        back = np.swapaxes(turn, 1, 2)[which]
        arm = base - origin[which]
        read = np.einsum("nij,nj->ni", back, arm)
        by_pose = np.concatenate([-back, back @ skew(arm)], axis=2)
        for k in range(len(self.blocks)):
            rows = which == k
            derivative[rows, :, 6 * k : 6 * k + 6] = by_pose[rows]
        return read, back, derivative


def rigid_fit(measured: Floats, base: Floats) -> tuple[Floats, Floats]:
    """Rotation (3, 3) and origin (3,) with base = R measured + t in the least-squares sense (Kabsch 1976)."""
    a, b = measured.mean(axis=0), base.mean(axis=0)
    rotation, _ = Rotation.align_vectors(base - b, measured - a) if len(base) > 1 else (Rotation.identity(), 0.0)
    matrix = rotation.as_matrix()
    return matrix, b - matrix @ a
