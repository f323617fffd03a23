"""A URDF read by the plant itself: main chain, lumped link masses."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .geometry import Array, placement, rigid_inverse

MOVING = ("revolute", "continuous")


@dataclass
class Edge:
    """A URDF joint: origin is the pose of the joint in its parent link."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Array
    axis: Array
    lower: float = -np.inf
    upper: float = np.inf
    mimic: bool = False


@dataclass
class Tree:
    """The links (own mass and centre in the link frame) and joints of a URDF."""

    mass: dict[str, tuple[float, Array]] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)

    def up(self, link: str) -> list[Edge]:
        """Edges from the root to `link`."""
        above = {e.child: e for e in self.edges}
        path: list[Edge] = []
        while link in above:
            path.insert(0, above[link])
            link = above[link].parent
        return path

    def rigid(self, link: str) -> list[tuple[str, Array]]:
        """`link` and everything fixed to it, with poses in `link`."""
        out = [(link, np.eye(4))]
        for name, pose in out:
            out += [(e.child, pose @ e.origin) for e in self.edges if e.parent == name and e.kind == "fixed"]
        return out

    def lumped(self, link: str) -> tuple[float, Array]:
        """Mass (kg) and centre (3,) in `link` of the link with all that is fixed to it."""
        total, moment = 0.0, np.zeros(3)
        for name, pose in self.rigid(link):
            mass, com = self.mass.get(name, (0.0, np.zeros(3)))
            total += mass
            moment += mass * (pose[:3, :3] @ com + pose[:3, 3])
        return total, moment / total if total > 0 else np.zeros(3)


def numbers(element: ElementTree.Element | None, key: str, default: str) -> Array:
    """The floats of an attribute."""
    text = default if element is None else element.get(key, default)
    return np.array([float(word) for word in text.split()])


def parse(path: Path) -> Tree:
    """Links with masses and joints of the file."""
    root = ElementTree.parse(path).getroot()
    tree = Tree()
    for link in root.findall("link"):
        inertial = link.find("inertial")
        mass = 0.0 if inertial is None else float(numbers(inertial.find("mass"), "value", "0")[0])
        origin = None if inertial is None else inertial.find("origin")
        tree.mass[link.get("name", "")] = (mass, numbers(origin, "xyz", "0 0 0"))
    for joint in root.findall("joint"):
        tree.edges.append(parse_joint(joint))
    return tree


def parse_joint(joint: ElementTree.Element) -> Edge:
    """One joint element."""
    origin, limit = joint.find("origin"), joint.find("limit")
    parent, child = joint.find("parent"), joint.find("child")
    if parent is None or child is None:
        raise ValueError(f"joint {joint.get('name')} has no parent or child")
    edge = Edge(
        name=joint.get("name", ""),
        kind=joint.get("type", ""),
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        origin=placement(numbers(origin, "xyz", "0 0 0"), numbers(origin, "rpy", "0 0 0")),
        axis=numbers(joint.find("axis"), "xyz", "1 0 0"),
        mimic=joint.find("mimic") is not None,
    )
    if limit is not None and edge.kind == "revolute":
        edge.lower, edge.upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
    return edge


def main_chain(tree: Tree, tip: str | None) -> list[Edge]:
    """Edges from the root to the tip; default tip: the link with most driven joints above it."""
    if tip is not None:
        if tip not in tree.mass:
            raise ValueError(f"no link {tip!r}")
        return tree.up(tip)

    def driven(link: str) -> int:
        path = tree.up(link)
        return 0 if any(e.mimic for e in path) else sum(e.kind in MOVING for e in path)

    # the first (nearest the root) of those with the most driven joints is the last moving link itself
    ends = [e.child for e in tree.edges if e.kind in MOVING]
    return tree.up(max(ends, key=driven))


def read_urdf(path: Path, base: str | None, tip: str | None) -> dict[str, Any]:
    """The fields of an Arm: placements before and after each joint, axes, limits, masses."""
    tree = parse(path)
    root_to_base = np.eye(4)
    for edge in tree.up(base or ("base" if "base" in tree.mass else "")):
        root_to_base = root_to_base @ edge.origin
        if edge.kind != "fixed":
            raise ValueError(f"base {base} moves with joint {edge.name}")
    pending, before, after = rigid_inverse(root_to_base), [], []
    joints: list[Edge] = []
    for edge in main_chain(tree, tip):
        pending = pending @ edge.origin
        if edge.kind in MOVING:
            before.append(pending)
            joints.append(edge)
            pending = np.eye(4)
        elif edge.kind != "fixed":
            raise ValueError(f"joint {edge.name}: type {edge.kind} is not a turning joint")
    after = [np.eye(4)] * (len(joints) - 1) + [pending]
    lumps = [tree.lumped(edge.child) for edge in joints]
    known = all(mass > 0 for mass, _ in lumps)
    back = [rigid_inverse(T) for T in after]
    return {
        "name": path.stem,
        "joint_names": tuple(e.name for e in joints),
        "before": np.array(before),
        "axis": np.array([e.axis / np.linalg.norm(e.axis) for e in joints]),
        "after": np.array(after),
        "lower": np.array([e.lower for e in joints]),
        "upper": np.array([e.upper for e in joints]),
        "mass": np.array([mass for mass, _ in lumps]) if known else None,
        "com": np.array([T[:3, :3] @ com + T[:3, 3] for T, (_, com) in zip(back, lumps, strict=True)])
        if known
        else None,
    }
