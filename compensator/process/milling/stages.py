"""Stages: the stock as it is at some poses of a path, coarsely: its moves taken away anew on a grid for drawing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from compensator.process.milling.grid import empty_field
from compensator.process.milling.kernels.survey import on_grid
from compensator.process.milling.kernels.thinning import take_moves
from compensator.process.milling.mill import Cut
from compensator.process.milling.path import prepared
from compensator.process.milling.remains import Remains
from compensator.process.milling.surface import Nodes

Floats = npt.NDArray[np.float64]
Floats32 = npt.NDArray[np.float32]


def stock_stages(cut: Cut, remains: Remains, nodes: Nodes, poses: Sequence[int]) -> Iterator[Floats32]:
    """Signed distances (nx, ny, nz) m on ``nodes`` to the stock when the move to each of ``poses`` is done.

    They are right within a step of its surface. One array that changes from pose to pose.

    Args:
        poses: ascending.
    """
    ready = prepared(cut.path, nodes.step)
    values = np.empty(nodes.count, dtype=np.float32)
    on_grid(empty_field(remains.stock.solid, ready.moves, nodes.step), nodes.start, nodes.step, values)
    done = 0
    for pose in poses:
        full, row = int(np.searchsorted(ready.last, pose, side="right")), int(ready.move[pose])
        take_moves(ready.moves, done, full, 1.0, low=nodes.start, cell=nodes.step, values=values)
        if row >= full:  # under way: a straight run of poses is one row
            share = float(ready.share[pose])
            take_moves(ready.moves, full, row + 1, share, low=nodes.start, cell=nodes.step, values=values)
        done = full
        yield values
