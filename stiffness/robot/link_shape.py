"""Link shapes: what the links of a robot look like, as far as its file tells; for collisions and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
ShapeKind = Literal["capsule", "cylinder", "box", "sphere", "mesh"]


@dataclass(frozen=True, eq=False)
class LinkShape:
    """One shape on a link.

    Attributes:
        link: 0 the base ... n the flange.
        name: of the link in its file.
        kind: of the shape; axes of capsule and cylinder are z, their middle is the origin.
        size: m; capsule and cylinder: radius, length between the ends of the axis; box: edges along x, y, z;
            sphere: radius; mesh: factors (1, not m) along x, y, z that make m of the numbers of its file.
        placement: (4, 4) in the frame L_k of the link.
        file: of a mesh, as the robot file names it.
    """

    link: int
    name: str
    kind: ShapeKind
    size: tuple[float, ...]
    placement: Floats
    file: str = ""

    def __post_init__(self) -> None:
        self.placement.setflags(write=False)


@dataclass(frozen=True)
class RobotShapes:
    """The shapes of all links.

    Attributes:
        shapes: of the links.
        source: where they come from, in words.
        approximate: whether they stand for the real outline only roughly.
        missing: what has no shape or does not follow the joints, in words; empty: nothing.
        neighbours: pairs of links, besides those that follow each other, that may touch.
        folder: that relative mesh files start from.
    """

    shapes: tuple[LinkShape, ...] = ()
    source: str = ""
    approximate: bool = False
    missing: str = "its file describes no shapes"
    neighbours: tuple[tuple[int, int], ...] = ()
    folder: Path = Path()


NO_SHAPES = RobotShapes()


def along_z(start: Floats, end: Floats) -> tuple[Floats, float]:
    """Placement (4, 4), half-way, whose z leads from ``start`` (3,) to ``end`` (3,), and the distance of both."""
    way = end - start
    length = float(np.linalg.norm(way))
    z = way / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    out = np.eye(4)
    out[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    out[:3, 3] = 0.5 * (start + end)
    return out, length
