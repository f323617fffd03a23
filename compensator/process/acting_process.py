"""Acting process: a process as it really cuts, by what a model knows of it: effects of scope ``process``.

The wrench that the process says stays beside the one that acts: a program that is written tells the first, so that a
model that is applied to it does not count twice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np
import numpy.typing as npt

from compensator.process.process import Process, ProcessLoad, ToolMotion
from stiffness.effects.effect import Effect, Numbers, ProgrammedWrench, acting_wrench
from stiffness.numerics.kernel import Kernel
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


@dataclass(frozen=True, repr=False, eq=False)
class ActingProcess(Process):
    """``said`` as ``effects`` with ``values`` leave it."""

    said: Process
    effects: Sequence[Effect]
    values: Mapping[str, Numbers]

    def __post_init__(self) -> None:
        for name in ("axes", "yields", "cuts_stock", "tells_walls"):
            object.__setattr__(self, name, getattr(self.said, name))

    def __repr__(self) -> str:
        return f"ActingProcess({self.said!r}, {', '.join(e.name for e in self.effects)})"

    def load(self, motion: ToolMotion) -> ProcessLoad:
        return self._acting(motion, self.said.load(motion))

    def preparation(self) -> str:
        return self.said.preparation()

    def with_corner_poses(self, toolpath: Toolpath, position: Floats | None = None) -> Toolpath:
        return self.said.with_corner_poses(toolpath, position)

    def path_axes(self, motion: ToolMotion) -> Floats:
        return self.said.path_axes(motion)

    def wrench_between(
        self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad, rows: Rows | None = None
    ) -> Floats:
        said = replace(known, wrench=known.unchanged)
        return self._changed(motion, self.said.wrench_between(motion, known_path, said, rows), rows)

    def load_between(self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad) -> ProcessLoad:
        said = replace(known, wrench=known.unchanged)
        return self._acting(motion, self.said.load_between(motion, known_path, said))

    def description(self) -> str:
        return f"{self.said.description()}, changed by {', '.join(e.name for e in self.effects)}"

    def _acting(self, motion: ToolMotion, load: ProcessLoad) -> ProcessLoad:
        return replace(load, wrench=self._changed(motion, load.wrench), programmed=load.wrench)

    def _changed(self, motion: ToolMotion, wrench: Floats, rows: Rows | None = None) -> Floats:
        axes = self.path_axes(motion) if rows is None else self.path_axes(motion)[rows]
        flat = np.swapaxes(axes, 1, 2).reshape(-1, 9)
        (changed,) = self._kernel.run(wrench, flat)
        return changed

    @cached_property
    def _kernel(self) -> Kernel:
        w, axes = ca.SX.sym("w", 6), ca.SX.sym("axes", 9)
        values = {e.name: {k: ca.SX(ca.DM(v)) for k, v in self.values[e.name].items()} for e in self.effects}
        out = acting_wrench(self.effects, ProgrammedWrench(w, ca.reshape(axes, 3, 3).T), values)
        return Kernel(ca.Function("acting", [w, axes], [ca.densify(out)]))
