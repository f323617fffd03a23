"""The toolpath of a trial: poses in the work object, where readings are taken, where the program waits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from toolpaths.frame import Frame
from toolpaths.rotation import matrix_from_quaternion
from toolpaths.toolpath import CUT, RAPID, SENSE_OPEN, Event, MachineCommand, Toolpath, tool_axis

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


@dataclass(frozen=True)
class TrialMoves:
    """Moves that follow each other: N poses.

    Attributes:
        position: (N, 3) m, work object. quaternion: (N, 4). feed: (N,) m/s; NaN: a rapid.
        read: (N,) whether a reading is taken there. columns: name -> (N,) of what is told beside it.
        wait: rows before which the program waits, and for what.
    """

    position: Floats
    quaternion: Floats
    feed: Floats
    read: npt.NDArray[np.bool_]
    columns: dict[str, Floats] = field(default_factory=dict)
    wait: tuple[tuple[int, str], ...] = ()

    def __len__(self) -> int:
        return len(self.position)

    def after_first(self) -> TrialMoves:
        """Without the first pose, where the moves before them ended."""
        return replace(
            self,
            position=self.position[1:],
            quaternion=self.quaternion[1:],
            feed=self.feed[1:],
            read=self.read[1:],
            columns={name: values[1:] for name, values in self.columns.items()},
            wait=tuple((max(row - 1, 0), what) for row, what in self.wait),
        )


def moves(
    position: Floats,
    quaternion: Floats,
    feed: float,
    *,
    read: npt.NDArray[np.bool_] | bool = False,
    wait: str = "",
    **columns: Floats | float,
) -> TrialMoves:
    """N moves of one kind.

    Args:
        position: (N, 3) m. quaternion: (4,) or (N, 4). feed: m/s, NaN: rapids. read: (N,) or of all.
        wait: what the program waits for before the first. columns: (N,) or a number each.
    """
    count = len(position)
    return TrialMoves(
        position=position,
        quaternion=np.broadcast_to(quaternion, (count, 4)),
        feed=np.full(count, feed),
        read=np.broadcast_to(np.asarray(read, dtype=np.bool_), (count,)),
        columns={name: np.broadcast_to(np.asarray(v, dtype=float), (count,)) for name, v in columns.items()},
        wait=((0, wait),) if wait else (),
    )


def joined(parts: Sequence[TrialMoves]) -> TrialMoves:
    """All of them, one after the other; NaN in columns that a part has not."""
    names = list(dict.fromkeys(name for p in parts for name in p.columns))
    begins = np.cumsum([0, *(len(p) for p in parts)])
    return TrialMoves(
        position=np.concatenate([p.position for p in parts]),
        quaternion=np.concatenate([p.quaternion for p in parts]),
        feed=np.concatenate([p.feed for p in parts]),
        read=np.concatenate([p.read for p in parts]),
        columns={
            name: np.concatenate([p.columns.get(name, np.full(len(p), np.nan)) for p in parts]) for name in names
        },
        wait=tuple((int(b) + row, what) for b, p in zip(begins, parts, strict=False) for row, what in p.wait),
    )


def toolpath_of(trial: TrialMoves, source: str) -> Toolpath:
    """As the planner and the writers take it; ``source``: its name in messages. A pose is a line of it."""
    count = len(trial)
    halt = (MachineCommand("M0"),)
    return Toolpath(
        source=source,
        language="csv",
        position=trial.position.copy(),
        axis=tool_axis(trial.quaternion),
        quaternion=trial.quaternion.copy(),
        feed=trial.feed.copy(),
        kind=np.where(np.isnan(trial.feed), RAPID, CUT).astype(np.uint8),
        tool=np.zeros(count, dtype=np.int32),
        spindle=np.zeros(count),
        sense=np.full(count, SENSE_OPEN),
        line=np.arange(1, count + 1, dtype=np.int32),
        row=np.arange(count, dtype=np.float64),
        events=tuple(Event(row, what, row + 1, halt) for row, what in trial.wait),
    )


def frames(toolpath: Toolpath) -> Frame:
    """(N) TCP of a toolpath whose orientation is fixed, in the work object."""
    if toolpath.quaternion is None:
        raise ValueError("the toolpath leaves the turn about the tool axis open")
    return Frame(matrix_from_quaternion(toolpath.quaternion), toolpath.position)
