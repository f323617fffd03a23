"""URDF files: the chain of joints from a base link to a tip link, and the weight on each of its links.

URDF 1.0 (wiki.ros.org/urdf/XML): lengths in m, angles in rad, R = Rz(yaw) Ry(pitch) Rx(roll).
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.chain import Chain, placement, rpy_rotation
from stiffness.errors import RobotError

Floats = npt.NDArray[np.float64]

_TURNING = ("revolute", "continuous")
_KNOWN = (*_TURNING, "fixed", "prismatic", "planar", "floating")
_FAR = 1.0  # m: a centre of mass farther than this beyond its link's own extent is no measured figure


@dataclass(frozen=True, eq=False)
class _Joint:
    name: str
    kind: str
    parent: str
    child: str
    origin: Floats
    axis: Floats
    limits: tuple[float, float, float]  # rad, rad, rad/s
    mimics: str


@dataclass(frozen=True, eq=False)
class _Link:
    mass: float | None
    com: Floats


class _Tree:
    """Links and joints of one file."""

    def __init__(self, path: Path, links: dict[str, _Link], joints: list[_Joint]) -> None:
        self.path, self.links, self.joints = path, links, joints
        self.above = {j.child: j for j in joints}
        self.below: dict[str, list[_Joint]] = {name: [] for name in links}
        for joint in joints:
            self.below[joint.parent].append(joint)

    def up(self, link: str) -> list[_Joint]:
        """Joints from a link to the root, outermost first."""
        found: list[_Joint] = []
        while link in self.above:
            found.append(self.above[link])
            link = self.above[link].parent
        return found


def read(path: Path, *, base: str | None, tip: str | None) -> Chain:
    """Read a URDF.

    Args:
        base, tip: links; None for the link ``base`` (else the root), and the last moving link.

    Raises:
        RobotError: the file is missing, broken, or has no plain chain of rotary joints from base to tip.
    """
    tree = _parse(path)
    start = base if base is not None else ("base" if "base" in tree.links else _root(tree))
    end = tip if tip is not None else _last_moving(tree)
    for link, key in ((start, "base"), (end, "tip")):
        if link not in tree.links:
            raise RobotError(f"{path}: {key} = {link!r} is no link; there are: {', '.join(tree.links)}")
    offset, joints = _path_between(tree, start, end)
    turning = [j for j in joints if j.kind in _TURNING]
    _check_chain(path, joints)
    before, after = _placements(offset, joints)
    mass, com, problem = _weights(tree, turning, after)
    limits = np.array([j.limits for j in turning]).reshape(-1, 3)
    return Chain(
        tuple(j.name for j in turning), before, np.array([j.axis for j in turning]).reshape(-1, 3), after,
        limits[:, 0], limits[:, 1], limits[:, 2], mass, com, problem, (), (f"URDF {path.name}",), start, end,
    )


def _parse(path: Path) -> _Tree:
    try:
        root = ET.parse(path).getroot()
    except OSError as error:
        raise RobotError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ET.ParseError, ValueError) as error:
        raise RobotError(f"{path}: is not XML: {error}") from error
    if root.tag != "robot":
        raise RobotError(f"{path}: is no URDF: the root element is <{root.tag}>, expected <robot>")
    links: dict[str, _Link] = {}
    for element in root.findall("link"):
        name = _attribute(path, element, "name")
        if name in links:
            raise RobotError(f"{path}: two links are named {name!r}")
        links[name] = _link(path, element, name)
    if not links:
        raise RobotError(f"{path}: has no <link> (an unexpanded xacro file? Run xacro first)")
    joints = [_joint(path, element) for element in root.findall("joint")]
    _check_tree(path, links, joints)
    return _Tree(path, links, joints)


def _check_tree(path: Path, links: dict[str, _Link], joints: list[_Joint]) -> None:
    children, names = set(), set()
    for joint in joints:
        if joint.name in names:
            raise RobotError(f"{path}: two joints are named {joint.name!r}")
        for link in (joint.parent, joint.child):
            if link not in links:
                raise RobotError(f"{path}: joint {joint.name!r} names the link {link!r}, which does not exist")
        if joint.child in children:
            raise RobotError(f"{path}: link {joint.child!r} hangs on two joints: loops are not URDF")
        children.add(joint.child)
        names.add(joint.name)
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        raise RobotError(f"{path}: expected one root link, found {roots or 'none (the links form a loop)'}")
    parents = {j.child: j.parent for j in joints}
    for link in links:
        steps = 0
        while link in parents and steps <= len(links):
            link, steps = parents[link], steps + 1
        if steps > len(links):
            raise RobotError(f"{path}: the links form a loop at {link!r}")


def _link(path: Path, element: ET.Element, name: str) -> _Link:
    inertial = element.find("inertial")
    mass = inertial.find("mass") if inertial is not None else None
    if inertial is None or mass is None:
        return _Link(None, np.zeros(3))
    place = f"inertial of link {name!r}"
    value = _numbers(path, _attribute(path, mass, "value"), 1, place)[0]
    return _Link(value, _origin(path, inertial, place)[:3, 3])


def _joint(path: Path, element: ET.Element) -> _Joint:
    name, kind = _attribute(path, element, "name"), _attribute(path, element, "type")
    place = f"joint {name!r}"
    if kind not in _KNOWN:
        raise RobotError(f"{path}: {place} has the type {kind!r}, expected one of {', '.join(_KNOWN)}")
    ends = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None:
            raise RobotError(f"{path}: {place} has no <{tag}>")
        ends.append(_attribute(path, end, "link"))
    given = element.find("axis")
    axis = np.array(_numbers(path, _attribute(path, given, "xyz"), 3, place) if given is not None else [1.0, 0, 0])
    length = float(np.linalg.norm(axis))
    if kind in _TURNING and length < 1e-6:
        raise RobotError(f"{path}: {place} has the axis 0 0 0")
    mimic = element.find("mimic")
    return _Joint(
        name, kind, ends[0], ends[1], _origin(path, element, place), axis / (length or 1.0),
        _limits(path, element, kind, place), "" if mimic is None else _attribute(path, mimic, "joint"),
    )


def _limits(path: Path, element: ET.Element, kind: str, place: str) -> tuple[float, float, float]:
    limit = element.find("limit")
    speed = math.nan
    if limit is not None and "velocity" in limit.attrib:
        value = _numbers(path, limit.attrib["velocity"], 1, place)[0]
        speed = value if value > 0 else math.nan
    if kind != "revolute":
        return -math.inf, math.inf, speed
    if limit is None or "lower" not in limit.attrib or "upper" not in limit.attrib:
        raise RobotError(f"{path}: {place} is revolute and has no <limit lower= upper=>: give its limits in rad")
    low, high = (_numbers(path, limit.attrib[key], 1, place)[0] for key in ("lower", "upper"))
    if not low < high:
        raise RobotError(f"{path}: {place} has the limits {low} .. {high} rad: expected lower below upper")
    return low, high, speed


def _origin(path: Path, element: ET.Element, place: str) -> Floats:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    xyz = _numbers(path, origin.get("xyz", "0 0 0"), 3, place)
    return placement(rpy_rotation(*_numbers(path, origin.get("rpy", "0 0 0"), 3, place)), xyz)


def _numbers(path: Path, text: str, count: int, place: str) -> list[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(math.isfinite(v) for v in values):
        raise RobotError(f"{path}: {place}: {text!r} is not {count} finite number{'s' if count > 1 else ''}")
    return values


def _attribute(path: Path, element: ET.Element, key: str) -> str:
    if key not in element.attrib:
        raise RobotError(f"{path}: a <{element.tag}> {element.get('name', '')!r} has no {key}")
    return element.attrib[key]


def _root(tree: _Tree) -> str:
    return next(name for name in tree.links if name not in tree.above)


def _last_moving(tree: _Tree) -> str:
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
        raise RobotError(f"{tree.path}: several chains are equally long: set tip to one of {', '.join(deepest)}")
    return deepest[0]


def _path_between(tree: _Tree, start: str, end: str) -> tuple[Floats, list[_Joint]]:
    """Pose of the common ancestor in the base link, and the joints from there to the tip."""
    up, down = tree.up(start), tree.up(end)[::-1]
    while up and down and up[-1] is down[0]:
        up, down = up[:-1], down[1:]
    offset = np.eye(4)
    for joint in up[::-1]:
        if joint.kind != "fixed":
            raise RobotError(f"{tree.path}: base {start!r} moves with joint {joint.name!r}: choose a link that stands still")
        offset = offset @ joint.origin
    return np.linalg.inv(offset), down


def _check_chain(path: Path, joints: list[_Joint]) -> None:
    for joint in joints:
        if joint.mimics:
            raise RobotError(
                f"{path}: joint {joint.name!r} of the chain mimics {joint.mimics!r}: arms with coupled joints "
                "(palletisers, parallelograms) are not supported"
            )
        if joint.kind in ("prismatic", "planar", "floating"):
            raise RobotError(f"{path}: joint {joint.name!r} of the chain is {joint.kind}: only turning joints are supported")


def _placements(offset: Floats, joints: list[_Joint]) -> tuple[Floats, Floats]:
    """``before`` and ``after`` of the turning joints; fixed ones are folded in, the tail into the last ``after``."""
    before, waiting = [], offset
    for joint in joints:
        waiting = waiting @ joint.origin
        if joint.kind in _TURNING:
            before.append(waiting)
            waiting = np.eye(4)
    after = np.tile(np.eye(4), (len(before), 1, 1))
    if before:
        after[-1] = waiting
    return np.array(before).reshape(-1, 4, 4), after


def _weights(tree: _Tree, chain: list[_Joint], after: Floats) -> tuple[Floats | None, Floats | None, str]:
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


def _hanging(tree: _Tree, joint: _Joint) -> float:
    """Mass, kg, of everything outward of a joint."""
    inner = sum(_hanging(tree, below) for below in tree.below[joint.child])
    return (tree.links[joint.child].mass or 0.0) + inner


def _absurd(tree: _Tree, names: list[str], mass: Floats, moment: Floats) -> str:
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
