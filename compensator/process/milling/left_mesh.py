"""What is left of the stock as a mesh file: STL, PLY or OBJ by its suffix."""

from __future__ import annotations

from pathlib import Path

from compensator.errors import CompensatorError
from compensator.process.milling.milling_load import MillingLoad

SUFFIXES = (".stl", ".ply", ".obj")


def refuse_suffix(target: Path) -> None:
    """Refuse a name that is of no mesh that is written.

    Raises:
        CompensatorError: names the suffixes that are.
    """
    if target.suffix.lower() not in SUFFIXES:
        raise CompensatorError(f"{target}: the stock that remains is written as {', '.join(SUFFIXES)}: name it so")


def left_mesh(load: MillingLoad, suffix: str) -> bytes:
    """The mesh of what remains, mm, in the work object.

    Raises:
        CompensatorError: nothing remains.
    """
    import trimesh  # half a second, and only where a mesh is asked for

    remains = load.cut.remains
    if remains is None:
        raise CompensatorError("nothing was cut: there is no remaining stock to write")
    vertices, faces = remains.mesh()
    if not len(faces):
        raise CompensatorError("nothing of the stock remains: there is no mesh to write. Leave out --left")
    mesh = trimesh.Trimesh(vertices * 1e3, faces, process=False)
    data = mesh.export(file_type=suffix.lower().lstrip("."))
    return data.encode() if isinstance(data, str) else bytes(data)
