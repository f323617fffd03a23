"""The frame of a URDF that its controller measures positions from: beside the ``base_link`` that carries the arm.

ROS-Industrial and REP 199 (draft): ``base`` is the controller's own base or world; it has no shape and carries nothing.
Fanuc's own descriptions call it ``wbase``: on axis 1, at the height of axis 2. Either may have the prefix of its robot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from stiffness.robot.controller_frame import ControllerFrame, frame_at, named
from stiffness.robot.urdf_tree import UrdfJoint, UrdfTree

Floats = npt.NDArray[np.float64]

BASE = "base"
UPRIGHT = 1.0 - 1e-7  # least cosine of what does not count as tilted: 0.03 deg
_WORLD = "wbase"


def base_frame(tree: UrdfTree, start: str, first: UrdfJoint, before: Floats) -> ControllerFrame | None:
    """The frame that positions are measured from; None where the file has none.

    Args:
        start: the base by default. first: turning joint of the chain. before: (4, 4) of it, in ``start``.
    """
    found = []
    for depth, link in enumerate(_held(tree, first.parent)):
        for joint in tree.below[link]:
            if joint.kind == "fixed" and not _moves(tree, joint.child):
                if named(joint.child, _WORLD):
                    found.append((0, depth, joint.child))
                elif named(joint.child, BASE) and link == f"{joint.child}_link":
                    found.append((1, depth, joint.child))
    if start == BASE:  # wherever it stands
        found.append((2, 0, start))
    if not found:
        return None
    name = min(found)[2]
    in_root = _placed(tree, name)
    seen = frame_at(name, np.linalg.inv(_placed(tree, start)) @ in_root, before[:3, :3] @ first.axis)
    return seen if in_root[2, 2] > UPRIGHT else replace(seen, mount=_rpy(in_root))


def _rpy(pose: Floats) -> tuple[float, float, float]:
    roll, pitch, yaw = (round(float(v), 4) + 0.0 for v in np.degrees(pin.rpy.matrixToRpy(pose[:3, :3])))
    return roll, pitch, yaw


def _held(tree: UrdfTree, link: str) -> list[str]:
    """A link and what holds it without a joint that moves, inwards."""
    out = [link]
    while link in tree.above and tree.above[link].kind == "fixed":
        link = tree.above[link].parent
        out.append(link)
    return out


def _moves(tree: UrdfTree, link: str) -> bool:
    """Whether anything outward of a link moves."""
    return any(j.kind != "fixed" or _moves(tree, j.child) for j in tree.below[link])


def _placed(tree: UrdfTree, link: str) -> Floats:
    """(4, 4) pose in the root, joints at zero: both frames stand on one body, so what moves it does not count."""
    pose = np.eye(4)
    for joint in tree.up(link):
        pose = joint.origin @ pose
    return pose
