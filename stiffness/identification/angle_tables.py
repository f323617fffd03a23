"""Angle tables: joint errors that follow the joint's angle alone, interpolated between hundreds of numbers.

Such an error does not depend on the load, so it is evaluated once per posture and given to the statics. By the chain
rule the derivative of a reading by a number of the table is its derivative by the joint's angle, times that of the
angle error by the number.
"""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca
import numpy as np
import numpy.typing as npt

from stiffness.effects.effect import Numbers
from stiffness.identification.unknowns import Unknowns
from stiffness.numerics.kernel import Kernel

Floats = npt.NDArray[np.float64]


class AngleTables:
    """Numbers of ``unknowns`` that belong to laws of the angle alone, and the ``core`` of the others.

    Attributes:
        core: (C,) indices of the other numbers.
        own: (T,) indices of the tables' numbers. joint: (T,) the joint that each acts on.
    """

    def __init__(self, joints: int, unknowns: Unknowns, fixed: Mapping[str, Numbers]) -> None:
        self.joints, self.unknowns, self.fixed = joints, unknowns, fixed
        self.effects = tuple(e for e in unknowns.effects if e.angle)
        names = {e.name for e in self.effects}
        mine = np.array([u.effect in names for u in unknowns.free], dtype=bool)
        self.core, self.own = np.flatnonzero(~mine), np.flatnonzero(mine)
        self.joint = np.array(
            [unknowns.free[k].index // unknowns.free[k].parameter.each for k in self.own], dtype=np.intp
        )
        self._kernel = self._built() if self.effects else None

    def __bool__(self) -> bool:
        return bool(self.effects)

    def __repr__(self) -> str:
        return f"AngleTables({', '.join(e.name for e in self.effects) or 'none'}, {len(self.own)} free numbers)"

    def whole(self, core: ca.SX) -> ca.SX:
        """All free numbers as symbols: those of tables are zero, their laws are worked out beside the statics."""
        out = ca.SX.zeros(len(self.unknowns))
        for k, place in enumerate(self.core.tolist()):
            out[place] = core[k]
        return out

    def error(self, q: Floats, p: Floats) -> Floats:
        """(N, n) rad of every joint; (N, 0) without such laws."""
        if self._kernel is None:
            return np.zeros((len(q), 0))
        return self._kernel.run(q, p[self.own])[0]

    def slopes(self, q: Floats, p: Floats) -> Floats:
        """(N, T): how the error of its joint moves with every number."""
        if self._kernel is None:
            return np.zeros((len(q), 0))
        return self._kernel.run(q, p[self.own])[1]

    def _built(self) -> Kernel:
        q, own = ca.SX.sym("q", self.joints), ca.SX.sym("own", len(self.own))
        p = ca.SX.zeros(len(self.unknowns))
        for k, place in enumerate(self.own.tolist()):
            p[place] = own[k]
        values = self.unknowns.values(p, self.fixed)
        error = sum((e.angle(q, values[e.name]) for e in self.effects if e.angle), ca.SX.zeros(self.joints))
        slopes = ca.sum1(ca.jacobian(error, own)).T  # every number acts on one joint
        return Kernel(ca.Function("tables", [q, own], [ca.densify(error), ca.densify(slopes)]))
