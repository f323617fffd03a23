"""Tool: what hangs on the flange, where its TCP stands and what it weighs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Tool:
    """What hangs on the flange.

    Attributes:
        rotation, position: (3, 3) and (3,) m, flange -> TCP.
        mass: kg, 0 for none.
        com: (3,) m in the flange frame.
        name: tool effects of a model hold for the tool of this name.
    """

    rotation: Floats
    position: Floats
    mass: float = 0.0
    com: Floats | None = None
    name: str = "tool"

    def __post_init__(self) -> None:
        if self.mass and self.com is None:
            raise ValueError(f"tool {self.name!r}: {self.mass:g} kg without a centre of mass have no weight torque")
