"""Arm loads: what loads the arm of every reading, and the arms at rest under it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]

PIECE = 512  # readings at a time


@dataclass(frozen=True)
class LoadKind:
    """What loads of one kind have in common: they share one CasADi function.

    Attributes:
        link: the load acts on.
        point_link: the point that its moment is taken about moves with (0: it does not move).
        tool_axes: the wrench is written in the axes of the tool (else of the base).
        programmed: it is what a process says (else what a sensor shows).
    """

    link: int
    point_link: int
    tool_axes: bool
    programmed: bool = False


@dataclass(frozen=True, repr=False, eq=False)
class ArmLoads:
    """What loads N arms.

    Attributes:
        q: (N, n) rad, commanded.
        wrench: (N, 6) N and N*m, as the sensor shows it. point: (N, 3) m in its link, that the moment is about.
        state: (N, s) memory as a share of its half range, -1 ... 1.
        payload: (N, 1) kg at the tool's centre of mass. warm: (N, 1) K above the reference temperature.
        path_axes: (N, 9) of a programmed wrench, in the base, column after column; None: of a sensor.
    """

    q: Floats
    wrench: Floats
    point: Floats
    state: Floats
    payload: Floats
    warm: Floats
    path_axes: Floats | None = None

    def take(self, rows: Index) -> ArmLoads:
        """Some of them, in the given order."""
        there = {f.name: getattr(self, f.name) for f in fields(self)}
        some: dict[str, Any] = {name: None if values is None else values[rows] for name, values in there.items()}
        return ArmLoads(**some)

    @property
    def axes(self) -> Floats:
        """(N, 9) path axes, (N, 0) where there are none."""
        return np.empty((len(self.q), 0)) if self.path_axes is None else self.path_axes

    def table(self) -> Floats:
        """All numbers of an arm in one row: arms with equal rows deflect alike."""
        return np.concatenate([self.q, self.wrench, self.point, self.state, self.payload, self.warm, self.axes], axis=1)


@dataclass(frozen=True, repr=False, eq=False)
class ArmEquilibria:
    """N arms at rest under their loads.

    Attributes:
        q: (N, n) rad.
        x: (N, m) elastic coordinates, the start of the next call; behind them those of the sag that a
            controller knows, and of the arm without any load.
        torque: (N, n) N*m.
        by_parameter, by_wrench, by_state, by_angle: (N, m, P), (N, m, 6), (N, m, s), (N, m, n) slopes of ``x``; P
            without the tables of laws of the angle alone, which act by way of ``by_angle``.
    """

    q: Floats
    x: Floats
    torque: Floats
    by_parameter: Floats
    by_wrench: Floats
    by_state: Floats
    by_angle: Floats

    def take(self, rows: Index) -> ArmEquilibria:
        """Some of them, in the given order."""
        return ArmEquilibria(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    @classmethod
    def gathered(cls, parts: Sequence[tuple[Index, ArmEquilibria]]) -> ArmEquilibria:
        """Arms under several kinds of load as one: each part with the rows (k,) that it takes."""
        if len(parts) == 1:
            return parts[0][1]
        count = sum(len(rows) for rows, _ in parts)
        out = {}
        for name in (f.name for f in fields(cls)):
            out[name] = np.empty((count, *getattr(parts[0][1], name).shape[1:]))
            for rows, part in parts:
                out[name][rows] = getattr(part, name)
        return cls(**out)


def pieces_of_links(link: Index) -> list[Index]:
    """Readings of one link each (k,), few enough at a time to keep memory small."""
    each = [np.flatnonzero(link == k) for k in np.unique(link)]
    return [part for rows in each for part in np.array_split(rows, -(-len(rows) // PIECE))]
