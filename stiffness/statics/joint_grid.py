"""Postures over two joints, the others fixed: what a stiffness map is computed on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class JointGrid:
    """Postures over two joints.

    Attributes:
        joints: the two, counted from 0.
        first, second: (A,) and (B,) deg of the two.
        fixed: (n,) deg of all joints; those of the two do not count.
    """

    joints: tuple[int, int]
    first: Floats
    second: Floats
    fixed: Floats

    def __repr__(self) -> str:
        i, j = (k + 1 for k in self.joints)
        return f"JointGrid(joints {i} and {j}, {len(self.first)} x {len(self.second)})"

    @property
    def q(self) -> Floats:
        """(A * B, n) rad; the second joint runs fastest."""
        q = np.tile(self.fixed, (len(self.first) * len(self.second), 1))
        q[:, self.joints[0]] = np.repeat(self.first, len(self.second))
        q[:, self.joints[1]] = np.tile(self.second, len(self.first))
        return np.asarray(np.radians(q))

    def over(self, values: Floats) -> Floats:
        """(A * B,) -> (A, B)."""
        return values.reshape(len(self.first), len(self.second))
