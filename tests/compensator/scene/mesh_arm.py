"""An arm of six joints whose links are meshes: a URDF and its STL files, written by the test itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

# joint -> xyz of its origin in the link before (m), axis, limits (rad)
JOINTS = (
    ((0.0, 0.0, 0.40), "0 0 1", 3.0),
    ((0.20, 0.0, 0.30), "0 1 0", 2.0),
    ((0.0, 0.0, 0.80), "0 1 0", 2.4),
    ((0.30, 0.0, 0.12), "1 0 0", 3.0),
    ((0.45, 0.0, 0.0), "0 1 0", 2.1),
    ((0.12, 0.0, 0.0), "1 0 0", 3.0),
)


def meshes() -> list[trimesh.Trimesh]:
    """Of the base and the links: lumpy, none of them convex or along an axis."""
    rng = np.random.default_rng(3)
    base = trimesh.creation.cylinder(0.22, height=0.36, sections=24)
    base.apply_translation([0.0, 0.0, 0.18])
    out = [base]
    ways = [(0.2, 0.0, 0.3), (0.0, 0.0, 0.8), (0.3, 0.0, 0.12), (0.45, 0.0, 0.0), (0.12, 0.0, 0.0), (0.05, 0.0, 0.0)]
    for way, radius in zip(ways, (0.16, 0.11, 0.12, 0.08, 0.07, 0.05), strict=True):
        lump = trimesh.creation.icosphere(subdivisions=3, radius=1.0)
        shift = np.array(way)
        length = float(np.linalg.norm(shift))
        stretched = lump.vertices * [radius, radius, 0.5 * length + 0.5 * radius]
        stretched *= 1.0 + 0.15 * np.sin(9.0 * lump.vertices[:, [0]] + rng.uniform(0, 6))
        turn = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], shift / length)[:3, :3]
        out.append(trimesh.Trimesh(stretched @ turn.T + 0.5 * shift, lump.faces, process=False))
    return out


def write(folder: Path, scale: float = 1.0) -> Path:
    """The URDF, with its meshes in the package ``lumps`` beside it; ``scale``: of the numbers in the meshes."""
    (folder / "lumps" / "meshes").mkdir(parents=True, exist_ok=True)
    parts = ['<robot name="lumpy">']
    for k, mesh in enumerate(meshes()):
        mesh.vertices = mesh.vertices / scale
        mesh.export(folder / "lumps" / "meshes" / f"link{k}.stl")
        name = f"package://lumps/meshes/link{k}.stl"
        parts.append(
            f'<link name="link{k}"><collision><geometry><mesh filename="{name}" scale="{scale} {scale} {scale}"/>'
            "</geometry></collision></link>"
        )
    for k, (xyz, axis, limit) in enumerate(JOINTS):
        place = " ".join(map(str, xyz))
        parts.append(
            f'<joint name="j{k + 1}" type="revolute"><parent link="link{k}"/><child link="link{k + 1}"/>'
            f'<origin xyz="{place}" rpy="0 0 0"/><axis xyz="{axis}"/>'
            f'<limit lower="{-limit}" upper="{limit}" effort="1" velocity="1"/></joint>'
        )
    (folder / "lumpy.urdf").write_text("\n".join([*parts, "</robot>"]), encoding="utf-8")
    return folder / "lumpy.urdf"
