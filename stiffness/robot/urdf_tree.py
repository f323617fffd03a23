"""The links and joints of a URDF file, checked and converted; what chain they make is in ``urdf``.

URDF 1.0 (wiki.ros.org/urdf/XML): lengths in m, angles in rad, R = Rz(yaw) Ry(pitch) Rx(roll).
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.urdf_shapes import UrdfShape, shapes_of
from stiffness.robot.urdf_values import attribute_of, numbers_of, origin_of
from stiffness.text_file import file_bytes

Floats = npt.NDArray[np.float64]

TURNING = ("revolute", "continuous")
_KNOWN = (*TURNING, "fixed", "prismatic", "planar", "floating")


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint element: ``origin`` (4, 4) parent -> joint at zero, ``axis`` (3,), ``limits`` lower, upper, velocity."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Floats
    axis: Floats
    limits: tuple[float, float, float]  # rad, rad, rad/s
    mimics: str


@dataclass(frozen=True, eq=False)
class UrdfLink:
    """A link element: kg, centre of mass (3,) m in the link, and what it looks like."""

    mass: float | None
    com: Floats
    shapes: tuple[UrdfShape, ...] = ()


class UrdfTree:
    """Links and joints of one file."""

    def __init__(self, path: Path, links: dict[str, UrdfLink], joints: list[UrdfJoint]) -> None:
        self.path, self.links, self.joints = path, links, joints
        self.above = {j.child: j for j in joints}
        self.below: dict[str, list[UrdfJoint]] = {name: [] for name in links}
        for joint in joints:
            self.below[joint.parent].append(joint)

    def up(self, link: str) -> list[UrdfJoint]:
        """Joints from a link to the root, outermost first."""
        found: list[UrdfJoint] = []
        while link in self.above:
            found.append(self.above[link])
            link = self.above[link].parent
        return found


def parse(path: Path) -> UrdfTree:
    raw = file_bytes(str(path), path, RobotError)
    try:
        root = ET.fromstring(raw)
    except (ET.ParseError, ValueError) as error:
        raise RobotError(f"{path}: is not XML: {error}") from error
    if root.tag != "robot":
        raise RobotError(f"{path}: is no URDF: the root element is <{root.tag}>, expected <robot>")
    links: dict[str, UrdfLink] = {}
    for element in root.findall("link"):
        name = attribute_of(path, element, "name")
        if name in links:
            raise RobotError(f"{path}: two links are named {name!r}")
        links[name] = _link(path, element, name)
    if not links:
        raise RobotError(f"{path}: has no <link> (an unexpanded xacro file? Run xacro first)")
    joints = [_joint(path, element) for element in root.findall("joint")]
    _check_tree(path, links, joints)
    return UrdfTree(path, links, joints)


def _check_tree(path: Path, links: dict[str, UrdfLink], joints: list[UrdfJoint]) -> None:
    children, names = set(), set()
    for joint in joints:
        if joint.name in names:
            raise RobotError(f"{path}: two joints are named {joint.name!r}")
        for link in (joint.parent, joint.child):
            if link not in links:
                raise RobotError(
                    f"{path}: joint {joint.name!r} names the link {link!r}, which does not exist"
                )
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


def _link(path: Path, element: ET.Element, name: str) -> UrdfLink:
    shapes, inertial = shapes_of(path, element, name), element.find("inertial")
    mass = inertial.find("mass") if inertial is not None else None
    if inertial is None or mass is None:
        return UrdfLink(None, np.zeros(3), shapes)
    place = f"inertial of link {name!r}"
    value = numbers_of(path, attribute_of(path, mass, "value"), 1, place)[0]
    return UrdfLink(value, origin_of(path, inertial, place)[:3, 3], shapes)


def _joint(path: Path, element: ET.Element) -> UrdfJoint:
    name, kind = attribute_of(path, element, "name"), attribute_of(path, element, "type")
    place = f"joint {name!r}"
    if kind not in _KNOWN:
        raise RobotError(f"{path}: {place} has the type {kind!r}, expected one of {', '.join(_KNOWN)}")
    ends = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None:
            raise RobotError(f"{path}: {place} has no <{tag}>")
        ends.append(attribute_of(path, end, "link"))
    given = element.find("axis")
    axis = np.array(
        numbers_of(path, attribute_of(path, given, "xyz"), 3, place) if given is not None else [1.0, 0, 0]
    )
    length = float(np.linalg.norm(axis))
    if kind in TURNING and length < 1e-6:
        raise RobotError(f"{path}: {place} has the axis 0 0 0")
    mimic = element.find("mimic")
    return UrdfJoint(
        name=name,
        kind=kind,
        parent=ends[0],
        child=ends[1],
        origin=origin_of(path, element, place),
        axis=axis / (length or 1.0),
        limits=_limits(path, element, kind, place),
        mimics="" if mimic is None else attribute_of(path, mimic, "joint"),
    )


def _limits(path: Path, element: ET.Element, kind: str, place: str) -> tuple[float, float, float]:
    limit = element.find("limit")
    speed = math.nan
    if limit is not None and "velocity" in limit.attrib:
        value = numbers_of(path, limit.attrib["velocity"], 1, place)[0]
        speed = value if value > 0 else math.nan
    if kind != "revolute":
        return -math.inf, math.inf, speed
    if limit is None or "lower" not in limit.attrib or "upper" not in limit.attrib:
        raise RobotError(
            f"{path}: {place} is revolute and has no <limit lower= upper=>: give its limits in rad"
        )
    low, high = (numbers_of(path, limit.attrib[key], 1, place)[0] for key in ("lower", "upper"))
    if not low < high:
        raise RobotError(f"{path}: {place} has the limits {low} .. {high} rad: expected lower below upper")
    return low, high, speed
