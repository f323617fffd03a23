"""Predicted readings: what a session is predicted to show, and where the next prediction starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.reading_slopes import ReadingSlopes
from stiffness.identification.station import TrackerPoses

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, repr=False, eq=False)
class SessionState:
    """Where the fit of a session stands.

    Attributes:
        x: (N, n_x) elastic coordinates that the next equilibria start from.
        torque: (N, n) N*m of the joints that the next load histories start from.
        poses: first guess of the tracker poses; None before the first prediction, which makes it.
        used: (N,) readings that take part. allowed: (N,) readings that may: no search for outliers brings others back.
    """

    x: Floats
    torque: Floats
    poses: TrackerPoses | None
    used: Bools
    allowed: Bools

    def __repr__(self) -> str:
        return f"SessionState({int(self.used.sum())} of {len(self.used)} readings used)"


@dataclass(frozen=True, repr=False, eq=False)
class PredictedReadings:
    """Predicted readings of a session.

    Attributes:
        position: (N, 3) m, as read.
        by_number: derivatives by the P free numbers. by_station, by_wrench: (N, 3, S), (N, 3, 6).
        back: (N, 3, 3) rotation, base -> axes of the reading.
        state: where the prediction ended.
    """

    position: Floats
    by_number: ReadingSlopes
    by_station: Floats
    by_wrench: Floats
    back: Floats
    state: SessionState

    @property
    def by_parameter(self) -> Floats:
        """(N, 3, P) derivatives by all free numbers."""
        return self.by_number.whole()

    @property
    def x(self) -> Floats:
        """(N, n_x) elastic coordinates."""
        return self.state.x

    @property
    def torque(self) -> Floats:
        """(N, n) N*m."""
        return self.state.torque
