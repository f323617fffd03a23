"""Shapes of a URDF file: the collision elements of its links, or the visual ones where a link has none of these."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.link_shape import ShapeKind
from stiffness.robot.urdf_values import attribute_of, numbers_of, origin_of

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class UrdfShape:
    """A collision or visual element: ``kind`` and ``size`` as in LinkShape, ``origin`` (4, 4) in the link."""

    kind: ShapeKind
    size: tuple[float, ...]
    origin: Floats
    file: str = ""


def shapes_of(path: Path, link: ET.Element, name: str) -> tuple[UrdfShape, ...]:
    """What a link looks like.

    Raises:
        RobotError: numbers of a shape are wrong; names link and value.
    """
    elements = link.findall("collision") or link.findall("visual")
    found = [_shape(path, element, f"shape of link {name!r}") for element in elements]
    return tuple(shape for shape in found if shape is not None)


def _shape(path: Path, element: ET.Element, place: str) -> UrdfShape | None:
    """None where the element holds no geometry that URDF knows."""
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        return None
    given, origin = geometry[0], origin_of(path, element, place)
    if given.tag == "mesh":
        scale = numbers_of(path, given.get("scale", "1 1 1"), 3, place)
        return UrdfShape("mesh", tuple(scale), origin, attribute_of(path, given, "filename"))
    if given.tag == "box":
        size = numbers_of(path, attribute_of(path, given, "size"), 3, place)
        return UrdfShape("box", _positive(path, size, place), origin)
    if given.tag in ("cylinder", "capsule"):
        size = [numbers_of(path, attribute_of(path, given, key), 1, place)[0] for key in ("radius", "length")]
        return UrdfShape("cylinder" if given.tag == "cylinder" else "capsule", _positive(path, size, place), origin)
    if given.tag == "sphere":
        size = numbers_of(path, attribute_of(path, given, "radius"), 1, place)
        return UrdfShape("sphere", _positive(path, size, place), origin)
    return None


def _positive(path: Path, size: list[float], place: str) -> tuple[float, ...]:
    if min(size) <= 0:
        raise RobotError(f"{path}: {place} has the size {min(size):g}: expected a length above 0, m")
    return tuple(size)
