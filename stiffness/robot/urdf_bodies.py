"""Bodies of a URDF chain: the shapes of its links, and of all that is fixed to them, in the frames of the chain."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.robot.link_shape import LinkShape, RobotShapes
from stiffness.robot.urdf_tree import UrdfJoint, UrdfTree

Floats = npt.NDArray[np.float64]


def chain_shapes(tree: UrdfTree, start: str, chain: list[UrdfJoint], after: Floats) -> RobotShapes:
    """Shapes on the links of a chain.

    Args:
        start: link that is the base. chain: turning joints; after: (n, 4, 4) as in Robot.
    """
    found, loose = _fixed_to(tree, start, np.eye(4), chain)
    shapes = _placed(tree, 0, found)
    empty = [] if shapes else [start]
    for k, joint in enumerate(chain):
        found, more = _fixed_to(tree, joint.child, np.linalg.inv(after[k]), chain)
        mine = _placed(tree, k + 1, found)
        shapes, loose = shapes + mine, loose + more
        empty += [] if mine else [joint.child]
    missing = []
    if empty:
        missing.append(f"no shape for {', '.join(empty)}")
    if loose:
        missing.append(f"{', '.join(loose)} on joints beside the chain")
    if not shapes:
        return RobotShapes(missing=f"{tree.path.name} has no collision or visual shapes")
    return RobotShapes(tuple(shapes), f"URDF {tree.path.name}", missing="; ".join(missing), folder=tree.path.parent)


def _placed(tree: UrdfTree, link: int, found: list[tuple[str, Floats]]) -> list[LinkShape]:
    return [
        LinkShape(link, name, s.kind, size=s.size, placement=pose @ s.origin, file=s.file)
        for name, pose in found
        for s in tree.links[name].shapes
    ]


def _fixed_to(
    tree: UrdfTree, start: str, pose: Floats, chain: list[UrdfJoint]
) -> tuple[list[tuple[str, Floats]], list[str]]:
    """Links that move with ``start`` and their poses (4, 4); links with shapes on joints that are not in the chain."""
    out, loose, stack, seen = list[tuple[str, Floats]](), list[str](), [(start, pose)], {start}
    while stack:
        name, at = stack.pop()
        out.append((name, at))
        steps = [(j.child, at @ j.origin, j) for j in tree.below[name]]
        if name in tree.above:
            up = tree.above[name]
            steps.append((up.parent, at @ np.linalg.inv(up.origin), up))
        for other, there, joint in steps:
            if other in seen or joint in chain:
                continue
            if joint.kind == "fixed":
                seen.add(other)
                stack.append((other, there))
            elif other == joint.child:
                loose += _with_shapes(tree, other)
    return out, loose


def _with_shapes(tree: UrdfTree, link: str) -> list[str]:
    below = [name for joint in tree.below[link] for name in _with_shapes(tree, joint.child)]
    return ([link] if tree.links[link].shapes else []) + below
