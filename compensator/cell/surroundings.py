"""Surroundings: what a cell tells of bodies beside the arm, and how collisions with them are looked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from compensator.cell.cell_file import Cell
from compensator.cell.scene_tables import BodyTable, CollisionsTable, SceneTable
from compensator.path.tool_set import ONE_TOOL


@dataclass(frozen=True, repr=False)
class Surroundings:
    """Bodies as the cell file has them, in its units; meshes are not read yet.

    Attributes:
        folder: what mesh files are relative to.
        scene: what stands around.
        tools: number of the tool -> what it looks like, in the flange frame.
        settings: of the search for collisions.
    """

    folder: Path = Path()
    scene: tuple[SceneTable, ...] = ()
    tools: Mapping[int, tuple[BodyTable, ...]] = field(default_factory=dict)
    settings: CollisionsTable = field(default_factory=CollisionsTable)

    def __repr__(self) -> str:
        return f"Surroundings({', '.join(s.name for s in self.scene)})"


def surroundings_of(cell: Cell) -> Surroundings:
    """What a cell tells."""
    tools = {number: table.bodies for number, table in cell.tools.items()}
    if cell.tool is not None:
        tools[ONE_TOOL] = cell.tool.bodies
    return Surroundings(cell.folder, cell.scene, tools, cell.collisions)
