"""Session data: the readings of a session, prepared once for every prediction and every fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.identification.arm_loads import ArmLoads, LoadKind
from stiffness.identification.lagging_station import LaggingStation
from stiffness.identification.load_history import LoadHistory
from stiffness.identification.path_history import PathHistory
from stiffness.identification.path_station import Placing, station_of
from stiffness.session.samples import Samples
from stiffness.session.session import Session

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

# studied in tests/stiffness/identification/test_prediction.py
SILENT = 4.0  # standard deviations of the sensor


@dataclass(frozen=True, repr=False, eq=False)
class SessionData:
    """What of a session no parameter changes.

    Attributes:
        wrench: (N, 6) N and N*m, as read; zero where the sensor shows nothing but its noise.
        warm: (N, 1) K above the reference temperature; 0 where not known.
        time: (N, 1) s since the first reading; 0 where not known.
        link: (N,) the link that the reflector of a reading sits on.
        kinds: the kinds of load, each with its readings (N,). kind_number: (N,) which of them every reading has.
        history: approaches and the order of loads; of a trace, the walk along its path.
        station: layout of the session's own numbers.
        path_axes: (N, 9) of a trace, column after column; None: of a session of set-ups.
    """

    session: Session
    wrench: Floats
    warm: Floats
    time: Floats
    link: Index
    kinds: Mapping[LoadKind, Bools]
    kind_number: Index
    history: LoadHistory | PathHistory
    station: Placing
    path_axes: Floats | None = None

    def __repr__(self) -> str:
        return f"SessionData({self.session.source!r}, {len(self.samples)} readings)"

    @classmethod
    def of(cls, session: Session) -> SessionData:
        """Prepare a session."""
        s = session.samples
        reference = session.reference_temperature
        warm = s.temperature - (20.0 if reference is None else reference)
        began = np.nanmin(s.time) if np.isfinite(s.time).any() else 0.0
        kinds, number = _load_kinds(session)
        return cls(
            session=session,
            wrench=_loading_wrench(session),
            warm=np.where(np.isfinite(warm), warm, 0.0)[:, None],
            time=np.where(np.isfinite(s.time), s.time - began, 0.0)[:, None],
            link=np.array([r.link for r in session.reflectors])[s.reflector],
            kinds=kinds,
            kind_number=number,
            history=LoadHistory(session) if session.path is None else PathHistory(session, session.path),
            station=_station(session),
            path_axes=None if session.path is None or session.path.as_said else session.path.axes_at_readings,
        )

    @property
    def samples(self) -> Samples:
        """The readings."""
        return self.session.samples

    def loads(self, places: Floats, state: Floats) -> ArmLoads:
        """What loads the arm of every reading.

        Args:
            places: (R, 3) m, reflectors in their links: a rope may pull at one. state: (N, s) memory.
        """
        s = self.samples
        point = np.where((s.load.at >= 0)[:, None], places[s.load.at], s.load.point)
        return ArmLoads(
            q=s.q,
            wrench=self.wrench,
            point=point,
            state=state,
            payload=s.payload[:, None],
            warm=self.warm,
            path_axes=self.path_axes,
        )

    def cases(self, loads: ArmLoads, rows: Index | None = None) -> tuple[Index, Index]:
        """Rows of ``loads`` that differ in load or posture, and which of them each is; ``rows``: the readings that they
        belong to, where these are not all."""
        kind = self.kind_number if rows is None else self.kind_number[rows]
        keys = np.column_stack([loads.table(), kind])
        _, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        return np.asarray(first), np.asarray(of).reshape(-1)


def _station(session: Session) -> Placing:
    inner, path = station_of(session), session.path
    return inner if path is None or not (path.lagging or path.latency) else LaggingStation(inner, path)


def _loading_wrench(session: Session) -> Floats:
    """(N, 6) wrench as read; zero where the sensor shows nothing but its noise, which must not choose flanks."""
    wrench, sensor = session.samples.load.wrench, session.instruments
    if not session.has_wrench:
        return wrench
    sd = np.array([sensor.force or 0.0] * 3 + [sensor.torque or 0.0] * 3)
    nothing = np.all(np.abs(wrench) <= SILENT * sd, axis=1)
    return np.where(nothing[:, None], 0.0, wrench)


def _load_kinds(session: Session) -> tuple[dict[LoadKind, Bools], Index]:
    """The kinds of load of a session, each with its readings, and the number of the kind of every reading."""
    load = session.samples.load
    keys = np.stack([load.link, load.point_link, load.in_tool.astype(np.int64)], axis=1)
    unique, of = np.unique(keys, axis=0, return_inverse=True)
    of = of.reshape(-1)
    programmed = session.path is not None and not session.path.as_said
    return {LoadKind(int(a), int(b), bool(c), programmed): of == k for k, (a, b, c) in enumerate(unique)}, of
