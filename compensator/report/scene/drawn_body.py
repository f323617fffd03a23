"""DrawnBody: a mesh of the scene and what carries it, as the page takes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from compensator.report.scene.packing import packed
from compensator.report.scene.solids import SolidMesh
from compensator.report.scene.stages import Stages

WORK, FLOOR = -1, -2  # what carries a body beside the links
MOST_SHORT = np.iinfo(np.uint16).max
Kind = Literal["arm", "tool", "cutter", "stock", "left", "part", "fixture", "reflector"]


@dataclass(frozen=True, repr=False, eq=False)
class DrawnBody:
    """A body of the scene.

    Attributes:
        mesh: in the axes of what carries it, m.
        frame: number of the link that carries it, 0 the base; WORK: the work object, FLOOR: what a rail stands on.
        kind: what a reader switches on and off.
        colour: as the page writes it. opacity: 1 hides what is behind.
        tool: number of the tool that it belongs to; None: it is there with every tool.
        stages: which faces are there at which station; None: all of them, always.
    """

    mesh: SolidMesh
    frame: int
    kind: Kind
    colour: str
    opacity: float = 1.0
    tool: int | None = None
    stages: Stages | None = None

    def __repr__(self) -> str:
        return f"DrawnBody({self.kind}, frame {self.frame}, {self.mesh!r})"

    def as_dict(self) -> dict[str, Any]:
        """For the page."""
        wide = len(self.mesh.vertices) > MOST_SHORT
        return {
            "kind": self.kind,
            "frame": self.frame,
            "tool": self.tool,
            "colour": self.colour,
            "opacity": self.opacity,
            "smooth": self.mesh.smooth,
            **(self._floats() if self.stages is None else self._shorts(self.stages)),
            "wide": wide,
            "faces": packed(self.mesh.faces, np.uint32 if wide else np.uint16),
        }

    def _floats(self) -> dict[str, Any]:
        return {"vertices": packed(self.mesh.vertices)}

    def _shorts(self, stages: Stages) -> dict[str, Any]:
        """Many vertices: each in a 65,535th of the box around all of them."""
        low, high = self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)
        unit = (high - low) / MOST_SHORT
        places = packed(np.round((self.mesh.vertices - low) / unit), np.uint16)
        return {"places": places, "low": low.tolist(), "unit": unit.tolist(), "stages": stages.as_dict()}
