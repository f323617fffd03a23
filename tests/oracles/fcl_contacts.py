"""Contacts of the links of a URDF by python-fcl, posed by Pinocchio's own reader of the URDF."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import fcl
import numpy as np
import pinocchio as pin
import trimesh


class FclArm:
    """Links of a URDF, each with one mesh file, and whatever stands around as (mesh, pose) in the root link.

    Args:
        meshes: name of the link -> its mesh, m, in the link.
    """

    def __init__(self, urdf: Path, meshes: dict[str, trimesh.Trimesh], around: Sequence[trimesh.Trimesh] = ()) -> None:
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.frames = {name: self.model.getFrameId(name) for name in meshes}
        self.objects = {name: fcl.CollisionObject(trimesh.collision.mesh_to_BVH(m)) for name, m in meshes.items()}
        self.around = [fcl.CollisionObject(trimesh.collision.mesh_to_BVH(m)) for m in around]

    def touching(self, q: np.ndarray, apart: int = 2) -> set[tuple[str, str]]:
        """Names of links that touch, ``apart`` or more places from each other; ``around-K`` for what stands around."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        for name, shape in self.objects.items():
            pose = self.data.oMf[self.frames[name]]
            shape.setTransform(fcl.Transform(pose.rotation, pose.translation))
        names = list(self.objects)
        pairs = [(a, b) for (i, a), (k, b) in itertools.combinations(enumerate(names), 2) if k - i >= apart]
        found = {(a, b) for a, b in pairs if self._touch(self.objects[a], self.objects[b])}
        for k, thing in enumerate(self.around):
            found |= {(name, f"around-{k}") for name in names[1:] if self._touch(self.objects[name], thing)}
        return found

    def numbered(self, found: set[tuple[str, str]]) -> list[tuple[str, str]]:
        """Names with the place of each link in the chain in place of its name."""
        place = {name: str(k) for k, name in enumerate(self.objects)}
        return [(place[a], place.get(b, b)) for a, b in found]

    @staticmethod
    def _touch(a: fcl.CollisionObject, b: fcl.CollisionObject) -> bool:
        return bool(fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()) > 0)
