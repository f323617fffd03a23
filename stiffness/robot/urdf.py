"""URDF files: the chain of joints from a base link to a tip link, and the weight on each of its links."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.robot import Robot
from stiffness.robot.urdf_base import BASE, base_frame
from stiffness.robot.urdf_bodies import chain_shapes
from stiffness.robot.urdf_flange import flange_frame
from stiffness.robot.urdf_tree import TURNING, UrdfJoint, UrdfTree, parse

Floats = npt.NDArray[np.float64]

_FAR = 1.0  # m: a centre of mass farther than this beyond its link's own extent was not measured


def read(path: Path, *, base: str | None, tip: str | None) -> Robot:
    """Read a URDF.

    Args:
        base, tip: links; None for the link ``base`` (else the root), and the last moving link.

    Raises:
        RobotError: the file is missing, broken, or has no plain chain of rotary joints from base to tip.
    """
    tree = parse(path)
    start = base if base is not None else (BASE if BASE in tree.links else _root(tree))
    end = tip if tip is not None else _last_moving(tree)
    for link, key in ((start, "base"), (end, "tip")):
        if link not in tree.links:
            raise RobotError(f"{path}: {key} = {link!r} is no link; there are: {', '.join(tree.links)}")
    offset, joints = _path_between(tree, start, end)
    turning = [j for j in joints if j.kind in TURNING]
    _check_chain(path, joints)
    before, after = _placements(offset, joints)
    mass, com, problem = _weights(tree, turning, after)
    limits = np.array([j.limits for j in turning]).reshape(-1, 3)
    return Robot(
        name=path.stem,
        joint_names=tuple(j.name for j in turning),
        before=before,
        axis=np.array([j.axis for j in turning]).reshape(-1, 3),
        after=after,
        lower=limits[:, 0],
        upper=limits[:, 1],
        velocity=limits[:, 2],
        mass=mass,
        com=com,
        mass_problem=problem,
        assumptions=(),
        sources=(f"URDF {path.name}",),
        base=start,
        tip=end,
        shapes=chain_shapes(tree, start, turning, after),
        flange_frame=flange_frame(tree, end, turning[-1].axis) if tip is None and turning else None,
        base_frame=base_frame(tree, start, turning[0], before[0]) if base is None and turning else None,
    )


def _root(tree: UrdfTree) -> str:
    return next(name for name in tree.links if name not in tree.above)


def _last_moving(tree: UrdfTree) -> str:
    """Child of the last turning joint of the longest chain; mimic joints belong to side branches."""
    depth = {
        j.child: sum(k.kind != "fixed" for k in tree.up(j.child))
        for j in tree.joints
        if j.kind != "fixed" and not any(k.mimics for k in tree.up(j.child))
    }
    if not depth:
        raise RobotError(f"{tree.path}: no joint moves")
    deepest = [link for link, d in depth.items() if d == max(depth.values())]
    if len(deepest) > 1:
        raise RobotError(
            f"{tree.path}: several chains are equally long: set tip to one of {', '.join(deepest)}"
        )
    return deepest[0]


def _path_between(tree: UrdfTree, start: str, end: str) -> tuple[Floats, list[UrdfJoint]]:
    """Pose of the common ancestor in the base link, and the joints from there to the tip."""
    up, down = tree.up(start), tree.up(end)[::-1]
    while up and down and up[-1] is down[0]:
        up, down = up[:-1], down[1:]
    offset = np.eye(4)
    for joint in up[::-1]:
        if joint.kind != "fixed":
            raise RobotError(
                f"{tree.path}: base {start!r} moves with joint {joint.name!r}: choose one that stands still"
            )
        offset = offset @ joint.origin
    return np.asarray(np.linalg.inv(offset)), down


def _check_chain(path: Path, joints: list[UrdfJoint]) -> None:
    for joint in joints:
        if joint.mimics:
            raise RobotError(
                f"{path}: joint {joint.name!r} of the chain mimics {joint.mimics!r}: coupled joints "
                "(palletisers, parallelograms) are not supported"
            )
        if joint.kind in ("prismatic", "planar", "floating"):
            raise RobotError(
                f"{path}: joint {joint.name!r} of the chain is {joint.kind}: only turning joints will do"
            )


def _placements(offset: Floats, joints: list[UrdfJoint]) -> tuple[Floats, Floats]:
    """``before`` and ``after`` of the turning joints; fixed ones are folded in, the tail into the last."""
    before, waiting = [], offset
    for joint in joints:
        waiting = waiting @ joint.origin
        if joint.kind in TURNING:
            before.append(waiting)
            waiting = np.eye(4)
    after = np.tile(np.eye(4), (len(before), 1, 1))
    if before:
        after[-1] = waiting
    return np.array(before).reshape(-1, 4, 4), after


def _weights(tree: UrdfTree, chain: list[UrdfJoint], after: Floats) -> tuple[Floats | None, Floats | None, str]:
    """Mass (n,) kg and centre (n, 3) m of each chain link with all that is fixed to it, or what is wrong."""
    mass, moment, bodies = np.zeros(len(chain)), np.zeros((len(chain), 3)), []
    for k, joint in enumerate(chain):
        stack = [(joint.child, np.linalg.inv(after[k]))]
        while stack:
            name, pose = stack.pop()
            link = tree.links[name]
            if link.mass is not None:
                bodies.append(link.mass)
                mass[k] += link.mass
                moment[k] += link.mass * (pose[:3, :3] @ link.com + pose[:3, 3])
            for below in tree.below[name]:
                if below.kind == "fixed":
                    stack.append((below.child, pose @ below.origin))
                elif below not in chain and (loose := _hanging(tree, below)) > 0:
                    where = f"{loose:g} kg hang on joint {below.name!r}, which is not in the chain"
                    return None, None, f"{tree.path.name}: {where}: their weight belongs to no joint"
    problem = _absurd(tree, [j.child for j in chain], mass, moment)
    if problem:
        return None, None, f"{tree.path.name}: {problem}"
    return mass, moment / mass[:, None], ""


def _hanging(tree: UrdfTree, joint: UrdfJoint) -> float:
    """Mass, kg, of everything outward of a joint."""
    inner = sum(_hanging(tree, below) for below in tree.below[joint.child])
    return (tree.links[joint.child].mass or 0.0) + inner


def _absurd(tree: UrdfTree, names: list[str], mass: Floats, moment: Floats) -> str:
    own = [tree.links[name].mass for name in names]
    if all(m is None or m == 0 for m in own):
        return "gives no masses"
    for name, value, total in zip(names, own, mass, strict=True):
        if value is not None and value < 0:
            return f"link {name!r} has the mass {value:g} kg"
        if total <= 0:
            return f"link {name!r} has no mass"
    if len(set(own)) == 1 and len(own) > 2:
        return f"every link weighs {own[0]:g} kg: a placeholder, not a mass"
    reach = [float(np.linalg.norm(j.origin[:3, 3])) for name in names for j in tree.below[name]]
    for name, value, lever in zip(names, mass, moment, strict=True):
        distance = float(np.linalg.norm(lever / value))
        if distance > max(reach, default=0.0) + _FAR:
            return f"the centre of mass of link {name!r} lies {distance:.3g} m from its frame"
    return ""
