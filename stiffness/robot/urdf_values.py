"""Values of a URDF file: attributes, numbers and origins of its elements, checked."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stiffness.errors import RobotError
from stiffness.robot.robot import placement
from stiffness.rotation import rpy_rotation

Floats = npt.NDArray[np.float64]


def origin_of(path: Path, element: ET.Element, place: str) -> Floats:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    xyz = numbers_of(path, origin.get("xyz", "0 0 0"), 3, place)
    return placement(rpy_rotation(*numbers_of(path, origin.get("rpy", "0 0 0"), 3, place)), xyz)


def numbers_of(path: Path, text: str, count: int, place: str) -> list[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(math.isfinite(v) for v in values):
        raise RobotError(f"{path}: {place}: {text!r} is not {count} finite number{'s' if count > 1 else ''}")
    return values


def attribute_of(path: Path, element: ET.Element, key: str) -> str:
    if key not in element.attrib:
        raise RobotError(f"{path}: a <{element.tag}> {element.get('name', '')!r} has no {key}")
    return element.attrib[key]
