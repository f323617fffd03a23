"""Turnarounds along a commanded path: where a joint reverses, and where the torque on it changes sign."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.solve.compensation import Compensation
from stiffness.memory.last_direction import last_direction

Floats = npt.NDArray[np.float64]
NO_TORQUE = 1e-6  # N*m that have no sign


@dataclass(frozen=True)
class Turnaround:
    """A joint that reverses, or whose torque changes sign.

    Attributes:
        joint: counted from 1.
        pose: index of the first pose after it.
        line: of the source file.
        file: that it is in, where the source has several; else empty.
    """

    joint: int
    pose: int
    line: int
    file: str = ""

    def as_dict(self) -> dict[str, Any]:
        """As in the JSON report."""
        more = {"source_file": self.file} if self.file else {}
        return {"where": f"joint-{self.joint}", "source_line": self.line, "pose": self.pose, **more}


def reversals(c: Compensation, q: Floats) -> list[Turnaround]:
    """Where a joint turns around along the commanded joint angles (N, n) rad, rapids included."""
    return _where_signs_change(c, q, lambda one: last_direction(np.diff(one, axis=0, prepend=one[:1])))


def sign_changes(c: Compensation) -> list[Turnaround]:
    """Where the torque of gravity and process on a joint changes sign."""
    return _where_signs_change(c, c.command.torque, lambda t: np.where(np.abs(t) > NO_TORQUE, np.sign(t), 0.0))


def _where_signs_change(
    c: Compensation, values: Floats, sign: Callable[[Floats], Floats]
) -> list[Turnaround]:
    """In the order of poses, of values (N, n), joint by joint: memory stays small. A sign of 0 is passed over."""
    path = c.path.toolpath
    found = [
        Turnaround(j + 1, int(k), int(path.line[k]), "" if path.file is None else path.sources[path.file[k]])
        for j in range(values.shape[1])
        for k in _changes(sign(values[:, j : j + 1])[:, 0].astype(np.int8))
    ]
    return sorted(found, key=lambda t: (t.pose, t.joint))


def _changes(sign: npt.NDArray[np.int8]) -> npt.NDArray[np.intp]:
    known = np.flatnonzero(sign != 0)
    return np.asarray(known[1:][sign[known[1:]] != sign[known[:-1]]])
