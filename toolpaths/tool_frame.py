"""ToolFrame: where the TCP of one tool stands on the flange, and what the tool weighs."""

from __future__ import annotations

from dataclasses import dataclass

from toolpaths.frame import Floats, Frame


@dataclass(frozen=True)
class ToolFrame:
    """One tool of a robot.

    Attributes:
        name: as the user calls it.
        frame: of the TCP in the flange, m.
        mass: kg, or None where it is not known.
        com: (3,) m, centre of mass in the flange frame, or None.
    """

    name: str
    frame: Frame
    mass: float | None = None
    com: Floats | None = None
