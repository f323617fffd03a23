"""The scene as glTF binary for other viewers: arm, tool, work and path at the worst pose, as large as they are.

glTF has y upwards and metres (Khronos, glTF 2.0, 3.4); the base's z becomes y.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.scene.path_colours import VIRIDIS
from compensator.report.scene.posed_bodies import posed_bodies
from compensator.report.scene.stations import MOST_POINTS, stations
from compensator.solve.compensation import Compensation
from toolpaths.toolpath import CUT

Floats = npt.NDArray[np.float64]

UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
RAPID = (0.62, 0.66, 0.7)
THIN, THINNEST = 0.002, 2e-4  # radius of the path: of its extent; m


def glb_scene(c: Compensation) -> bytes:
    """The file."""
    import trimesh  # half a second, and only where a file is asked for

    bodies, path = posed_bodies(c)
    scene: Any = trimesh.Scene()
    look: Any = trimesh.visual  # untyped
    for k, body in enumerate(bodies):
        colour = [int(body.colour[i : i + 2], 16) for i in (1, 3, 5)] + [round(255 * body.opacity)]
        mode = "BLEND" if body.opacity < 1 else "OPAQUE"
        material = look.material.PBRMaterial(baseColorFactor=colour, roughnessFactor=0.75, alphaMode=mode)
        visual = look.TextureVisuals(material=material)
        mesh = trimesh.Trimesh(body.vertices, body.faces, process=False, visual=visual)
        name = f"{body.kind}-{k}"
        scene.add_geometry(mesh, node_name=name, geom_name=name, transform=UPRIGHT)
    scene.add_geometry(_path(c, path), node_name="path", geom_name="path", transform=UPRIGHT)
    return bytes(scene.export(file_type="glb"))


def _path(c: Compensation, path: Floats) -> Any:
    """A thin tube from pose to pose, coloured by the deflection where it cuts.

    Lines would do, but trimesh writes them black.
    """
    import trimesh

    rows = stations(len(c), (), MOST_POINTS)
    position = path[rows]
    size, cut = np.linalg.norm(c.error_before, axis=1)[rows], c.path.toolpath.kind[rows] == CUT
    share = size / max(float(size[cut].max(initial=0.0)), 1e-12)
    stops = np.linspace(0.0, 1.0, len(VIRIDIS))
    mapped = np.column_stack([np.interp(share, stops, column) for column in np.array(VIRIDIS).T]) / 255.0
    colour = np.where(cut[:, None], mapped, RAPID)
    vertices, faces = tube(position, max(THIN * float(np.ptp(position, axis=0).max()), THINNEST))
    tint = np.column_stack([np.repeat(colour[1:], 6, axis=0), np.ones(len(vertices))])
    return trimesh.Trimesh(vertices, faces, process=False, vertex_colors=(255 * tint).round().astype(np.uint8))


def tube(position: Floats, radius: float) -> tuple[Floats, npt.NDArray[np.int64]]:
    """A three-sided prism along every line between points (N, 3): six corners each, and faces."""
    start, end = position[:-1], position[1:]
    way = end - start
    length = np.linalg.norm(way, axis=1, keepdims=True)
    way = np.where(length > 0, way / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])
    aside = np.cross(way, np.eye(3)[np.argmin(np.abs(way), axis=1)])
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    up = np.cross(way, aside)
    turns = [np.cos(t) * aside + np.sin(t) * up for t in 2 * np.pi * np.arange(3) / 3]
    vertices = np.stack([p + radius * t for p in (start, end) for t in turns], axis=1).reshape(-1, 3)
    sides = [(k, (k + 1) % 3, 3 + (k + 1) % 3) for k in range(3)] + [(k, 3 + (k + 1) % 3, 3 + k) for k in range(3)]
    faces = 6 * np.arange(len(start))[:, None, None] + np.array(sides)
    return vertices, faces.reshape(-1, 3)
