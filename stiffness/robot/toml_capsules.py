"""[capsules] of a robot file: what its links look like, mm in the frame of each link; format: docs/collisions.md."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from stiffness.robot.link_shape import LinkShape, RobotShapes, along_z
from stiffness.schema import StrictTable

Floats = npt.NDArray[np.float64]
Length = Annotated[float, Field(ge=-20_000, le=20_000, allow_inf_nan=False, strict=True)]
Point = tuple[Length, Length, Length]


class CapsuleTable(StrictTable):
    """A capsule on a link: 0 the base, 1 what joint 1 turns, ...; ends of its axis and radius, mm."""

    link: Annotated[int, Field(ge=0, le=20, strict=True)]
    start: Point
    end: Point
    radius: Annotated[float, Field(ge=5, le=3000, allow_inf_nan=False, strict=True)]

    def shape(self, shift: Floats) -> LinkShape:
        """In SI; ``shift`` (4, 4): the frame that the numbers are given in, in the frame of the link."""
        placement, length = along_z(np.array(self.start) * 1e-3, np.array(self.end) * 1e-3)
        size = (self.radius * 1e-3, length)
        return LinkShape(self.link, f"link-{self.link}", "capsule", size=size, placement=shift @ placement)


class ShapesTable(StrictTable):
    """[shapes] of a robot file. ``source``: where the figures come from; ``approximate``: they are rough."""

    source: Annotated[str, Field(min_length=1)]
    approximate: bool
    neighbours: tuple[tuple[int, int], ...] = ()
    capsules: Annotated[tuple[CapsuleTable, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _ordered(self) -> ShapesTable:
        for pair in self.neighbours:
            if not 0 <= pair[0] < pair[1]:
                raise ValueError(f"neighbours: {list(pair)}: two links, the inner one first, such as [4, 6]")
        return self

    def shapes(self, n: int, tip: Floats) -> RobotShapes:
        """The shapes of an arm of ``n`` joints; ``tip`` (4, 4) of the frame L_n on the flange.

        Raises:
            ValueError: a link that the arm does not have.
        """
        last = np.asarray(np.linalg.inv(tip), dtype=np.float64)
        beyond = [c.link for c in self.capsules if c.link > n] + [b for _, b in self.neighbours if b > n]
        if beyond:
            raise ValueError(f"link {beyond[0]}: the arm has the links 0 to {n}")
        shapes = tuple(c.shape(last if c.link == n else np.eye(4)) for c in self.capsules)
        bare = sorted(set(range(n + 1)) - {s.link for s in shapes})
        missing = f"no shape for link {', '.join(map(str, bare))}" if bare else ""
        return RobotShapes(shapes, self.source, self.approximate, missing=missing, neighbours=self.neighbours)
