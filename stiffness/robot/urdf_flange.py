"""The frame of a URDF that controllers measure tools from: ``tool0``, else a flange, fixed to the last moving link.

ROS-Industrial: ``tool0`` is the maker's tool frame without a tool. REP 199: x of ``flange`` points out of it; a frame
such as Fanuc's ``fanuc_flange`` beside it, whose z does, is what its controller has.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.robot.controller_frame import ControllerFrame, along, frame_at, named
from stiffness.robot.tips import FLANGE, MAKERS
from stiffness.robot.urdf_tree import UrdfTree

Floats = npt.NDArray[np.float64]


def flange_frame(tree: UrdfTree, end: str, axis: Floats) -> ControllerFrame | None:
    """The frame that tools are measured from; None where the file has none.

    Args:
        end: the last moving link, the tip by default. axis: (3,) of its joint, in its axes.
    """
    found = _fixed_to(tree, end)
    ranked = [(_rank(name, pose, axis), name) for name, pose in found.items() if named(name, MAKERS, FLANGE)]
    if not ranked:
        return None
    name = min(ranked)[1]
    return frame_at(name, found[name], axis)


def _rank(name: str, pose: Floats, axis: Floats) -> tuple[bool, bool, bool]:
    """Least first: tool0, z on the axis, no prefix."""
    return not named(name, MAKERS), not along(pose, axis), name not in (MAKERS, FLANGE)


def _fixed_to(tree: UrdfTree, end: str) -> dict[str, Floats]:
    """Poses (4, 4) of a link and of what is fixed to it, in the link."""
    out, stack = dict[str, Floats](), [(end, np.eye(4))]
    while stack:
        name, pose = stack.pop()
        out[name] = pose
        stack += [(j.child, pose @ j.origin) for j in tree.below[name] if j.kind == "fixed"]
    return out
