"""Lagging station: readings that show where the arm was a moment before their rows: one number, in seconds.

    shown(t) = p + c(i(t - lag)) - c(i(t))

c is the commanded path, i(t) the row at a time, as the readings of a run have it. A clock that is late and a servo that
follows its command at one distance in time do the same.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.path_station import Placing
from stiffness.identification.station import StationEntry, TrackerPoses
from stiffness.session.path_trace import PathTrace
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

LAG = 0.05  # s: how late readings may be, one standard deviation
STEP = 1e-3  # s, of a difference


class LaggingStation:
    """What ``inner`` sees, some time later; the lag is the last number of the vector."""

    def __init__(self, inner: Placing, path: PathTrace) -> None:
        self._inner, self._path = inner, path
        own = () if path.latency is not None else (StationEntry("latency", slice(inner.size, inner.size + 1)),)
        self.entries = (*inner.entries, *own)
        self.size = inner.size + len(own)

    def __repr__(self) -> str:
        return f"LaggingStation({self._inner!r})"

    @property
    def session(self) -> Session:
        """What was measured."""
        return self._inner.session

    @property
    def blocks(self) -> Ints:
        """Tracker stations."""
        return self._inner.blocks

    def prior_sd(self) -> Floats:
        """(S,) m, rad and s."""
        return np.concatenate([self._inner.prior_sd(), [LAG] * (self.size - self._inner.size)])

    def placed(self, base: Floats) -> TrackerPoses:
        """First guess of tracker poses."""
        return self._inner.placed(base)

    def reflectors(self, vector: Floats) -> Floats:
        """(R, 3) m in the frames of their links."""
        return self._inner.reflectors(vector[: self._inner.size])

    def reflector_derivative(self, vector: Floats) -> Floats:
        """(R, 3, S)."""
        inner = self._inner.reflector_derivative(vector[: self._inner.size])
        return np.concatenate([inner, np.zeros((*inner.shape[:2], self.size - self._inner.size))], axis=2)

    def seen(self, vector: Floats, base: Floats, poses: TrackerPoses) -> tuple[Floats, Floats, Floats]:
        """As ``Station.seen``."""
        count = self._inner.size
        given = self._path.latency
        lag = float(vector[count]) if given is None else given
        read, back, by = self._inner.seen(vector[:count], base + self._moved(lag), poses)
        if given is not None:
            return read, back, by
        slope = (self._moved(lag + STEP) - self._moved(lag - STEP)) / (2 * STEP)
        return read, back, np.concatenate([by, back @ slope[:, :, None]], axis=2)

    def _moved(self, lag: float) -> Floats:
        """(N, 3) m, from where the command is at every reading to where it was ``lag`` s before."""
        path, time = self._path, self.session.samples.time
        out = np.zeros((len(time), 3))
        now = path.rows.at(path.rows.position, path.index)
        for run in np.unique(path.run):
            mine = np.flatnonzero(path.run == run)
            order = mine[np.argsort(time[mine], kind="stable")]
            then = np.interp(time[mine] - lag, time[order], path.index[order])
            out[mine] = path.rows.at(path.rows.position, then) - now[mine]
        return out
