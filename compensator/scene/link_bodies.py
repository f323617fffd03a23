"""Link bodies: the shapes of a robot's links, their meshes found and read."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compensator.errors import CellError
from compensator.process.milling.mesh_reader import FORMATS, loaded_mesh
from compensator.scene.body import BASE, Body, Carrier
from compensator.scene.shape import BoxShape, CapsuleShape, CylinderShape, MeshShape, Shape3
from stiffness.robot.link_shape import LinkShape
from stiffness.robot.robot import Robot
from toolpaths.frame import Frame

PACKAGE = "package://"
ROS_PATHS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")


@dataclass(frozen=True)
class LinkBodies:
    """What the links of a robot look like; ``missing``: what of them is not there, in words."""

    bodies: tuple[Body, ...]
    missing: str


def link_bodies(robot: Robot, packages: Sequence[Path] = ()) -> LinkBodies:
    """The links as bodies; a mesh that is nowhere is told in ``missing``.

    Args:
        packages: folders in which the packages of a URDF are looked for first.

    Raises:
        CellError: a mesh is there and cannot be read.
    """
    given = robot.shapes
    found, lost, several = list[Body](), list[str](), _several(given.shapes)
    for shape in given.shapes:
        made = _shape(shape, given.folder, packages)
        if made is None:
            lost.append(shape.file)
            continue
        name = (f"link-{shape.link}" if shape.link else "base") + (f" ({shape.name})" if shape.link in several else "")
        carrier: Carrier = shape.link if shape.link else BASE
        frame = Frame(shape.placement[:3, :3].copy(), shape.placement[:3, 3].copy())
        found.append(Body(name, carrier, made, frame, role="link", approximate=given.approximate))
    missing = [given.missing] if given.missing else []
    if lost:
        missing.append(f"{len(lost)} of {len(given.shapes)} meshes are not found ({lost[0]})")
    return LinkBodies(tuple(found), "; ".join(missing))


def _several(shapes: Sequence[LinkShape]) -> set[int]:
    links = [s.link for s in shapes]
    return {link for link in links if links.count(link) > 1}


def _shape(shape: LinkShape, folder: Path, packages: Sequence[Path]) -> Shape3 | None:
    """None: its mesh is not found, or has a format that is not read."""
    size = shape.size
    if shape.kind == "capsule":
        return CapsuleShape(size[0], size[1])
    if shape.kind == "sphere":
        return CapsuleShape(size[0], 0.0)
    if shape.kind == "cylinder":
        return CylinderShape(size[0], size[1])
    if shape.kind == "box":
        return BoxShape(np.array(size))
    file = next((f for f in _places(shape.file, folder, packages) if f.is_file()), None)
    if file is None or file.suffix.lower() not in FORMATS:
        return None
    vertices, faces = loaded_mesh(file)
    scaled = vertices * np.array(size)
    extent = float(np.ptp(scaled, axis=0).max())
    if extent > 10.0:
        raise CellError(
            f"{file}: a link {extent:.4g} m large: the mesh is in mm: give scale=\"0.001 0.001 0.001\" in the URDF"
        )
    return MeshShape(scaled, faces)


def _places(name: str, folder: Path, packages: Sequence[Path]) -> Iterator[Path]:
    """Where a mesh may be: of a package, under the folders given, those above the URDF, and those of ROS."""
    if not name.startswith(PACKAGE):
        yield folder / name.removeprefix("file://")
        return
    inside = Path(name.removeprefix(PACKAGE))
    above = [folder.resolve(), *folder.resolve().parents]
    ros = [Path(p) for key in ROS_PATHS for p in os.environ.get(key, "").split(os.pathsep) if p]
    for place in [*packages, *above, *ros, *(p / "share" for p in ros)]:
        yield place / inside
        if place.name == inside.parts[0]:  # the folder of the package itself is given
            yield place.joinpath(*inside.parts[1:])
