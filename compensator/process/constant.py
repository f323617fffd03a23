"""A constant process: the same wrench at every cutting pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from compensator.process.given_wrench import GivenWrench
from compensator.process.process import NamedCutterTable, ProcessContext, ProcessTable, ToolMotion, WrenchAxes
from compensator.toml_table import Wrench

Floats = npt.NDArray[np.float64]


class ConstantWrenchTable(ProcessTable):
    """The same wrench at every cutting pose: on the robot, about the TCP, N and N*m."""

    kind: Literal["constant"]
    frame: WrenchAxes
    wrench: Wrench

    material: str | None = None
    cutter: NamedCutterTable | None = None

    def process(self, context: ProcessContext) -> ConstantProcess:
        return ConstantProcess(context, self.frame, self.wrench)


@dataclass(frozen=True)
class ConstantProcess(GivenWrench):
    """The same ``wrench`` (6,) in ``axes`` at every cutting pose."""

    context: ProcessContext
    axes: WrenchAxes
    wrench: tuple[float, float, float, float, float, float]

    def given(self, motion: ToolMotion) -> Floats:
        return np.broadcast_to(np.array(self.wrench, dtype=float), (len(motion), 6))

    def description(self) -> str:
        values = ", ".join(f"{w:g}" for w in self.wrench)
        return f"constant in the {self.axes} frame: [{values}] N and N·m on the robot, about the TCP"
