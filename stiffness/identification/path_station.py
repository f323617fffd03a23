"""Path stations: the numbers that belong to the measurement of a trace: centre and length of a ball-bar, a part's pose.

A reading of one number is the first of three: what is read of a position is its part along the direction of reading,
and derivatives of the other two are zero.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from stiffness.identification.station import Station, StationEntry, TrackerPoses
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ROUGHLY = 0.05  # m: how well the centre of a ball-bar is known beforehand
LENGTH = 1e-3  # m: the error of a length that is not calibrated
PART = (0.01, 0.02)  # m and rad: how far a part may lie from its work object


class Placing(Protocol):
    """Layout and geometry of the numbers that belong to the measurement of one session; see ``Station``."""

    @property
    def session(self) -> Session: ...

    @property
    def entries(self) -> tuple[StationEntry, ...]: ...

    @property
    def size(self) -> int: ...

    @property
    def blocks(self) -> Ints: ...

    def prior_sd(self) -> Floats: ...

    def placed(self, base: Floats) -> TrackerPoses: ...

    def reflectors(self, vector: Floats) -> Floats: ...

    def reflector_derivative(self, vector: Floats) -> Floats: ...

    def seen(self, vector: Floats, base: Floats, poses: TrackerPoses) -> tuple[Floats, Floats, Floats]: ...


def station_of(session: Session) -> Placing:
    """The layout of a session's own numbers."""
    path = session.path
    if path is None or path.kind == "positions":
        return Station(session)
    return BallbarStation(session, path) if path.kind == "ballbar" else PartStation(session, path)


class _Exact:
    """What stations of one number have in common: the TCP is where the tool has it, and no tracker stands anywhere."""

    def __init__(self, session: Session, path: PathTrace, entries: tuple[StationEntry, ...]) -> None:
        self.session, self.path, self.entries = session, path, entries
        self.size = entries[-1].span.stop if entries else 0
        self.blocks: Ints = np.empty(0, dtype=np.int64)
        self._places = np.array([r.position for r in session.reflectors]).reshape(-1, 3)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(e.name for e in self.entries) or 'nothing to estimate'})"

    def placed(self, base: Floats) -> TrackerPoses:
        """No tracker."""
        return TrackerPoses(np.empty((0, 3, 3)), np.empty((0, 3)))

    def reflectors(self, vector: Floats) -> Floats:
        """(R, 3) m in the frames of their links."""
        return self._places

    def reflector_derivative(self, vector: Floats) -> Floats:
        """(R, 3, S)."""
        return np.zeros((len(self._places), 3, self.size))


class BallbarStation(_Exact):
    """A bar between a centre and the TCP shows |p - c| + e: three numbers of c, one of e where it is not calibrated."""

    def __init__(self, session: Session, path: PathTrace) -> None:
        entries = [StationEntry("centre", slice(0, 3))]
        if not path.calibrated or path.length_sd > 0:
            entries.append(StationEntry("length", slice(3, 4)))
        super().__init__(session, path, tuple(entries))

    def prior_sd(self) -> Floats:
        """(S,) m."""
        length = self.path.length_sd if self.path.calibrated else LENGTH
        return np.array([ROUGHLY] * 3 + [length] * (self.size - 3))

    def seen(self, vector: Floats, base: Floats, poses: TrackerPoses) -> tuple[Floats, Floats, Floats]:
        """Lengths (N, 3) as read, the direction of the bar in the first row of (N, 3, 3), derivatives (N, 3, S)."""
        bar = base - (self.path.centre + vector[:3])
        length = np.linalg.norm(bar, axis=1)
        direction = bar / np.maximum(length, 1e-9)[:, None]
        slopes = np.concatenate([-direction, np.ones((len(bar), self.size - 3))], axis=1)
        return _one_number(direction, length + vector[3:].sum(), slopes)


class PartStation(_Exact):
    """A part whose surface is read: n . (p - nominal), less its place where it was not measured in the work object, and
    an offset of the probe where that is not calibrated."""

    def __init__(self, session: Session, path: PathTrace) -> None:
        part = () if session.registered else (StationEntry("part", slice(0, 6)),)
        begin = 6 * len(part)
        probe = (StationEntry("probe", slice(begin, begin + 1)),) if path.probe_sd else ()
        super().__init__(session, path, (*part, *probe))
        self._placed = begin
        self._middle = path.point.mean(axis=0)

    def prior_sd(self) -> Floats:
        """(S,) m and rad."""
        return np.concatenate([np.repeat(PART, 3)[: self._placed], [self.path.probe_sd] * (self.size - self._placed)])

    def seen(self, vector: Floats, base: Floats, poses: TrackerPoses) -> tuple[Floats, Floats, Floats]:
        """Deviations (N, 3) as read, the normal in the first row of (N, 3, 3), derivatives (N, 3, S)."""
        path = self.path
        nominal = path.rows.at(path.rows.nominal, path.index)
        deviation = np.sum(path.normal * (base - nominal), axis=1)
        six = np.concatenate([-path.normal, -np.cross(path.point - self._middle, path.normal)], axis=1)
        ones = np.ones((len(six), self.size - self._placed))
        slopes = np.concatenate([six[:, : self._placed], ones], axis=1)
        return _one_number(path.normal, deviation + slopes @ vector, slopes)


def _one_number(direction: Floats, number: Floats, slopes: Floats) -> tuple[Floats, Floats, Floats]:
    """A number (N,) read along a direction (N, 3), and its slopes (N, S), in the first of three places."""
    out, back = np.zeros_like(direction), np.zeros((len(direction), 3, 3))
    derivative = np.zeros((len(direction), 3, slopes.shape[1]))
    out[:, 0], back[:, 0], derivative[:, 0] = number, direction, slopes
    return out, back, derivative
