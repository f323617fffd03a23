"""Part check: where the remaining stock is below the finished part (gouges) and above it (rest material)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from compensator.path.pose_text import mm, place
from compensator.process.milling.kernels.field import CELL
from compensator.process.milling.mill import Cut
from compensator.process.milling.remains import Remains
from compensator.process.milling.stock import Stock
from toolpaths.finding import NOTE, WARNING, Finding
from toolpaths.toolpath import Toolpath

Floats = npt.NDArray[np.float64]

TOLERANCE = 5e-5  # m: below is the chord of a mesh
MOST_POINTS = 2_000_000
GOLDEN = (0.7548776662466927, 0.5698402909980532)  # of a sequence that fills a square evenly (Roberts 2018, R2)


@dataclass(frozen=True, repr=False)
class PartCheck:
    """Points (P, 3) on the part, m, and how thick the material over them is.

    Attributes:
        points: in the work object; area: (P,) m2 of the part that each stands for.
        over: (P,) m of material over the part; negative: cut so deep into it.
        pose: (P,) the pose whose move cut deepest there; -1: none did.
    """

    points: Floats
    area: Floats
    over: Floats
    pose: npt.NDArray[np.int64]

    def __repr__(self) -> str:
        return f"PartCheck({len(self.points)} points, {self.over.min():.2g} to {self.over.max():.2g} m)"

    def gouges(self, tolerance: float) -> npt.NDArray[np.int64]:
        """Points cut deeper than ``tolerance`` m by a move, the deepest first."""
        found = np.flatnonzero((self.over < -tolerance) & (self.pose >= 0))
        return found[np.argsort(self.over[found], kind="stable")]

    def rest(self, tolerance: float) -> tuple[float, float]:
        """Largest thickness of material over the part, m, and the share of its surface that has more than that."""
        more = self.over > tolerance
        return float(max(self.over.max(initial=0.0), 0.0)), float(self.area[more].sum() / self.area.sum())


def check_part(remains: Remains, part: Stock) -> PartCheck:
    """Compare what is left with a part; a point per cell of the grid."""
    points, area = surface_points(part.solid.tree.corner, float(remains.field.frame[CELL]))
    over = -remains.depth(points)
    return PartCheck(points, area, over, remains.writers(points))


def surface_points(corner: Floats, pitch: float) -> tuple[Floats, Floats]:
    """Points (P, 3) about ``pitch`` m apart on triangles (T, 3, 3), each triangle at least one, and their area (P,)."""
    size = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    pitch = max(pitch, float(np.sqrt(size.sum() / MOST_POINTS)))
    count = np.maximum(np.ceil(size / pitch**2), 1).astype(np.int64)
    of = np.repeat(np.arange(len(corner)), count)
    k = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
    u, v = ((0.5 + (k + 0.5) * g) % 1.0 for g in GOLDEN)
    fold = u + v > 1.0
    u, v = np.where(fold, 1.0 - u, u), np.where(fold, 1.0 - v, v)
    a, b, c = corner[of].transpose(1, 0, 2)
    return a + u[:, None] * (b - a) + v[:, None] * (c - a), (size / count)[of]


def part_findings(cut: Cut, part: Stock, toolpath: Toolpath) -> Iterator[Finding]:
    """Gouges and rest material against the finished part."""
    if cut.remains is None:
        return
    check = check_part(cut.remains, part)
    deep = check.gouges(TOLERANCE)
    if len(deep):
        worst, area = deep[0], float(check.area[deep].sum())
        what = (
            f"cuts {-check.over[worst] * 1e3:.3f} mm into the finished part at {mm(check.points[worst])} mm; "
            f"{area * 1e6:.3g} mm2 of it are gouged by more than {TOLERANCE * 1e3:g} mm"
        )
        yield Finding(WARNING, place(toolpath, int(check.pose[worst])), what, "Check part, work object and cutter")
    rest, share = check.rest(TOLERANCE)
    if rest > TOLERANCE:
        what = (
            f"up to {rest * 1e3:.3f} mm of material are left on the finished part; {share:.0%} of its surface has more "
            f"than {TOLERANCE * 1e3:g} mm"
        )
        yield Finding(NOTE, "finished part", what)
