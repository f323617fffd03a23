"""Table turn: where the tool goes when a table that turns along a path stands elsewhere than the path has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.axes.free_axes import FreeAxes
from compensator.path.free_turn import about_z, steadiest_guide
from compensator.path.planned_path import PlannedPath
from toolpaths.rotation import aligned, matrix_about

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Some = slice | Rows


@dataclass(frozen=True, repr=False, eq=False)
class TableTurn:
    """Where the tool is at K keys of a path with the table elsewhere.

    It keeps the point and the tool axis that it has on the part; the turn about that stays the number that it is, from
    the direction that the path counts it from, or what the file gives is kept on the part.

    Attributes:
        column: of the axis. at: (K,) deg where the path has it.
        direction: (3,) of length 1, center: (3,) m, base.
        turn: (K,) rad about the tool axis. guide: (3,) what it is counted from, base; None: it is carried along.
        whole: whether the file gives the whole orientation. carried: whether the wrench goes with the part.
    """

    column: int
    at: Floats
    direction: Floats
    center: Floats
    turn: Floats
    guide: Floats | None
    whole: bool
    carried: bool

    @classmethod
    def of(cls, free: FreeAxes, path: PlannedPath, rows: Rows, places: Floats) -> TableTurn | None:
        """Of the keys ``rows`` of a path with axes at ``places`` (K, A) there; None: no table may turn."""
        columns = np.flatnonzero(free.moving & ~free.rail)
        if not len(columns):
            return None
        k, placement = int(columns[0]), free.placement
        axis, guide = placement.external[free.names[k]], steadiest_guide(path.toolpath)
        return cls(
            column=k, at=places[:, k], direction=np.array(axis.direction), center=np.array(axis.center) * 1e-3,
            turn=path.turn[rows], guide=None if guide is None else placement.workobject.along(guide),
            whole=path.toolpath.quaternion is not None, carried=placement.process.axes != "base",
        )  # fmt: skip

    def by(self, places: Floats, some: Some) -> Floats:
        """(M, 3, 3) what the part is turned by at places (M, A) of some keys, from where the path has it."""
        return matrix_about(self.direction, np.radians(places[:, self.column] - self.at[some]))

    def moved(self, rotation: Floats, origin: Floats, places: Floats, some: Some) -> tuple[Floats, Floats]:
        """TCP (M, 3, 3) and (M, 3) m of some keys, as the path has it with rails at 0, with the table at ``places``."""
        by = self.by(places, some)
        origin = np.einsum("nij,nj->ni", by, origin - self.center) + self.center
        if self.whole:
            return by @ rotation, origin
        z = np.einsum("nij,nj->ni", by, rotation[:, :, 2])
        if self.guide is None:
            return aligned(rotation, -z), origin
        x = self.guide - z * (z @ self.guide)[:, None]
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        return np.stack([x, np.cross(z, x), z], axis=2) @ about_z(self.turn[some]), origin

    def load(self, wrench: Floats, places: Floats, some: Some) -> Floats:
        """The wrench (M, 6) of the path at some keys, with the table at ``places``."""
        if not self.carried:
            return wrench
        return np.asarray(np.einsum("nij,nkj->nki", self.by(places, some), wrench.reshape(-1, 2, 3)).reshape(-1, 6))
