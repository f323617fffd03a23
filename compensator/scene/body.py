"""Body: one thing that may be hit, what carries it, and where it stands there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from compensator.scene.shape import Shape3
from toolpaths.frame import Frame

Role = Literal["link", "tool", "cutter", "shank", "holder", "stock", "part", "scene"]
Carrier = int | Literal["base", "tool", "workobject", "world"]
BASE: Literal["base"] = "base"
TOOL: Literal["tool"] = "tool"
WORKOBJECT: Literal["workobject"] = "workobject"
WORLD: Literal["world"] = "world"


@dataclass(frozen=True, eq=False)
class Body:
    """One body.

    Attributes:
        name: as messages have it.
        carrier: number of the link (1 is what joint 1 turns); ``base``; ``tool``: the flange; ``workobject``;
            ``world``: the floor, in base axes with every rail at 0.
        shape: SI.
        placement: of the shape in the frame of the carrier.
        role: what it is.
        tool: number of the tool that it belongs to; None: it is there with every tool.
        approximate: whether it stands for the real outline only roughly.
        sacrificial: whether the cutter may go into it on a feed.
    """

    name: str
    carrier: Carrier
    shape: Shape3
    placement: Frame
    role: Role
    tool: int | None = None
    approximate: bool = False
    sacrificial: bool = False

    @property
    def on_arm(self) -> bool:
        """Whether it belongs to arm or tool."""
        return self.role in ("link", "tool", "cutter", "shank", "holder")

    def __repr__(self) -> str:
        return f"Body({self.name}, on {self.carrier}, {self.shape!r})"
