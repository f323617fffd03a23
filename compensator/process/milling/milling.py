"""Milling: the wrench of every pose from cutter, material and stock, and what is hit on the way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.path.added_poses import with_poses_after_corners
from compensator.path.pose_text import place
from compensator.process.milling.cutter import Cutter
from compensator.process.milling.doubts import material_doubts
from compensator.process.milling.findings import cut_findings
from compensator.process.milling.first_run import compiling
from compensator.process.milling.fit_check import cell_for, meets, refuse_apart
from compensator.process.milling.material import MaterialText
from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.milling_load import CoefficientShares, CutColumns, MillingLoad
from compensator.process.milling.part_check import part_findings
from compensator.process.milling.path import MillingPath, arriving_axes, arriving_feed, axes_with
from compensator.process.milling.spacing_check import spacing_findings
from compensator.process.milling.stock import Stock
from compensator.process.milling.used_tools import Spindle, used_cutters, used_spindle
from compensator.process.process import Process, ProcessContext, ProcessLoad, ToolMotion
from toolpaths.columns import blocks, once
from toolpaths.finding import ERROR, WARNING, Finding, of_kind
from toolpaths.steps import tell
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]

UPRIGHT = ("flat", "bull")  # shapes whose walls are along the axis
BESIDE = np.radians(75.0)  # from the feed: a wall stands at 90 deg, the grid of the cut is coarser
IDLE_SPEED = 1.0  # rev/s where the spindle stands still: something to divide by; no force is given there


@dataclass(frozen=True, repr=False)
class Shop:
    """What is machined.

    Attributes:
        stock: before the first move. stock_file, units: of its mesh, for messages; empty: it is no mesh.
        part: the finished one, or None. grid: m, or None: from the smallest cutter.
    """

    stock: Stock
    stock_file: str
    units: str
    part: Stock | None
    grid: float | None

    def __repr__(self) -> str:
        return f"Shop({self.stock!r})"


@dataclass(frozen=True, repr=False)
class MillingProcess(Process):
    """A mechanistic cutting force on the engaged part of the cutter, walked through the stock along the path.

    Attributes:
        context: the cell around it.
        material: its coefficients; cutters: by the number of the tool in the file, None: of all tools.
        shop: stock and part; spindle: speed and sense where the file gives none.
        coupled: whether a preview solves force and deflection together.
    """

    context: ProcessContext
    material: MaterialText
    cutters: Mapping[int | None, Cutter]
    shop: Shop
    spindle: Spindle
    coupled: bool = True
    axes = "path"
    cuts_stock = True
    between_ends = True

    def __repr__(self) -> str:
        return f"MillingProcess({self.material!r}, {len(self.cutters)} cutters, {self.shop.stock!r})"

    @property
    def yields(self) -> bool:  # type: ignore[override]
        return self.coupled

    @property
    def tells_walls(self) -> bool:  # type: ignore[override]
        return all(c.shape in UPRIGHT for c in self.cutters.values())

    def description(self) -> str:
        kinds = ", ".join(f"{c.shape} {c.diameter * 1e3:g} mm, {c.flutes} flutes" for c in self.cutters.values())
        return f"milling of {self.material.file.name} in {self.shop.stock.source} with {kinds}: computed from the cut"

    def preparation(self) -> str:
        return compiling()

    def with_corner_poses(self, toolpath: Toolpath, position: Floats | None = None) -> Toolpath:
        return with_poses_after_corners(toolpath, position)

    def path_axes(self, motion: ToolMotion) -> Floats:
        """Of the feed that arrives."""
        path, _ = self.milling_path(motion)
        return np.asarray(motion.workobject.rotation @ arriving_axes(path))

    def wrench_between(
        self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad, rows: Rows | None = None
    ) -> Floats:
        """Between the wrenches of the ends: to walk through the stock for every place would take too long."""
        rows = np.arange(len(motion)) if rows is None else rows
        old, row = known_path.row, motion.toolpath.row[rows]
        start = np.clip(np.searchsorted(old, row, side="right") - 1, 0, len(old) - 2)
        share = np.clip((row - old[start]) / (old[start + 1] - old[start]), 0.0, 1.0)[:, None]
        wrench = (1.0 - share) * known.wrench[start] + share * known.wrench[start + 1]
        return np.where((motion.toolpath.kind[rows] == CUT)[:, None], wrench, 0.0)

    def load_between(self, motion: ToolMotion, known_path: Toolpath, known: ProcessLoad) -> ProcessLoad:
        """Poses put in have an engagement of their own; what each coefficient does is asked of ``known``."""
        return self._load(motion, shares=False)

    def load(self, motion: ToolMotion) -> MillingLoad:
        return self._load(motion, shares=True)

    def _load(self, motion: ToolMotion, *, shares: bool) -> MillingLoad:
        path, found = self.milling_path(motion)
        material = self.material.at(_mean_feed_per_tooth(path))
        stock, source = self.shop.stock, self.context.source
        if self.shop.stock_file:
            refuse_apart(path, stock, self.shop.stock_file, self.shop.units)
        cell, work = cell_for(path.cutters, stock, self.shop.grid, source), motion.workobject.rotation
        shares = shares and material.covariance is not None
        cut = mill(path, stock, material.coefficients, cell=cell, axes=work, shares=shares, progress=tell)
        stopped = np.asarray((motion.toolpath.spindle == 0.0) & ~path.rapid)
        findings = (
            *found,
            *self._hits(motion.toolpath, cut, stopped),
            *spacing_findings(cut, motion.toolpath, source),
            *of_kind("process", material_doubts(material, *_used_range(path, cut.engaged & ~stopped))),
            *(() if self.shop.part is None else part_findings(cut, self.shop.part, motion.toolpath)),
        )
        for column in (cut.wrench, cut.peak):
            column[stopped] = 0.0
        kept = cut.shares
        for b in blocks(len(cut)):
            if kept is not None and stopped[b].any():
                kept.put(b, np.where(stopped[b, None, None], 0.0, kept[b]))
        cut = replace(cut, shares=None)
        return MillingLoad(
            cut.wrench, findings, CutColumns(cut, stopped), wall=_wall(cut, work), cut=cut, material=material,
            key=self.material.source, cell=cell, shares=None if kept is None else CoefficientShares(None, kept),
        )  # fmt: skip

    def wrench_at(self, motion: ToolMotion, rows: npt.NDArray[np.intp], cell: float) -> Floats:
        """(K, 6) N, N*m of some poses alone, on a grid of ``cell`` m, base frame; cheap where the grid is coarse."""
        path, _ = self.milling_path(motion)
        coefficients = self.material.at(_mean_feed_per_tooth(path)).coefficients
        cut = mill(path, self.shop.stock, coefficients, cell=cell, only=rows, progress=tell)
        rotation = (motion.workobject.rotation @ cut.axes)[rows]
        turned = np.einsum("kij,kaj->kai", rotation, cut.wrench[rows].reshape(-1, 2, 3))
        return np.where(motion.toolpath.spindle[rows, None] == 0.0, 0.0, turned.reshape(-1, 6))

    def milling_path(self, motion: ToolMotion) -> tuple[MillingPath, list[Finding]]:
        """The path as the cutter goes along it in the work object, and what is noteworthy about its feeds and speeds.

        Raises:
            CellError: a tool that cuts has no cutter, or no speed is known; names the line and the key.
        """
        toolpath = motion.toolpath
        rapid = toolpath.kind != CUT
        cutters, index = used_cutters(toolpath, self.cutters, self.context.source)
        speed, sense, found = used_spindle(toolpath, self.spindle, self.context.source)
        feed, more = _feeds(toolpath, self.context)
        position, axis, programmed = toolpath.position, toolpath.axis, None
        if motion.workobject.rotation.ndim > 2:  # rail or table: the way of the tool on the part
            on_part = motion.nominal.relative_to(motion.workobject)
            position, axis = on_part.origin, -on_part.rotation[:, :, 2]
        if motion.deflected is not None:  # its tilt is left out: micrometres, and every move would be one of five axes
            programmed = np.diff(position, axis=0, prepend=position[:1])
            position = motion.deflected.relative_to(motion.workobject).origin
        path = MillingPath(
            position, axis, feed=np.where(rapid, 0.0, feed), spindle=once(np.where(speed > 0, speed, IDLE_SPEED)),
            sense=once(sense), rapid=rapid, cutter=once(index), cutters=cutters, programmed=programmed,
        )  # fmt: skip
        if not meets(path, self.shop.stock.box):
            what = f"the path never meets the stock ({self.shop.stock.source}): everything is cut in the air"
            more.append(Finding(WARNING, f"{self.context.source}: process.stock", what, "Check box and [workobject]"))
        return path, [*found, *more]

    def _hits(self, toolpath: Toolpath, cut: Cut, stopped: npt.NDArray[np.bool_]) -> Iterator[Finding]:
        for f in cut_findings(cut):
            yield Finding(f.level, place(toolpath, f.pose), f.what, f.remedy)
        for k in np.flatnonzero(stopped & cut.engaged):
            what = "the spindle stands still in the material (M5, or a tool change without a speed after it)"
            yield Finding(ERROR, place(toolpath, int(k)), what, "Start it before the cut (S and M3 or M4)")


def _feeds(toolpath: Toolpath, context: ProcessContext) -> tuple[Floats, list[Finding]]:
    """m/s of every move; what a file does not give is that of the cell."""
    feed, found = toolpath.feed.copy(), list[Finding]()
    cut = toolpath.kind == CUT
    missing = cut & np.isnan(feed)
    feed[missing] = context.default_feed
    if missing.any():
        first = place(toolpath, int(np.argmax(missing)))
        what = f"no feed in the toolpath at {int(missing.sum())} cutting poses: chips are computed for "
        what += f"{context.default_feed * 60e3:g} mm/min"
        found.append(Finding(WARNING, first, what, "Give feeds in the toolpath, or program.default_feed in the cell"))
    still = cut & (feed == 0.0)
    if still.any():
        what = "the feed is zero: no chip, no force"
        found.append(Finding(WARNING, place(toolpath, int(np.argmax(still))), what, count=int(still.sum())))
    return np.nan_to_num(feed), found


def _mean_feed_per_tooth(path: MillingPath) -> float | None:
    rows = np.flatnonzero(~path.rapid & (path.feed > 0))
    per_tooth = path.feed[rows] / path.teeth_at(rows)
    return float(per_tooth.mean()) if len(per_tooth) else None


def _used_range(
    path: MillingPath, engaged: npt.NDArray[np.bool_]
) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
    """Smallest and largest feed per tooth (m) and cutting speed (m/s) of the engaged moves."""
    if not engaged.any():
        return None, None
    rows = np.flatnonzero(engaged)
    per_tooth = path.feed[rows] / path.teeth_at(rows)
    speed = 2 * np.pi * np.array([c.radius for c in path.cutters])[path.cutter[rows]] * path.spindle[rows]
    return (float(per_tooth.min()), float(per_tooth.max())), (float(speed.min()), float(speed.max()))


def _wall(cut: Cut, work: Floats) -> Floats:
    """(N, 3) unit vector, base, to the wall that is cut beside the feed; zero where there is none or one on each side.

    Args:
        work: (3, 3), or (N, 3, 3), rotation of the work object in the base.
    """
    feed, wall = arriving_feed(cut.path), np.zeros((len(cut), 3))
    for b in blocks(len(cut)):
        axes = axes_with(feed[b], cut.path.axis[b])
        left, right = cut.exit[b] > BESIDE, cut.entry[b] < -BESIDE  # false where nothing is engaged
        side = left.astype(float) - right.astype(float)
        wall[b] = side[:, None] * ((work if work.ndim == 2 else work[b]) @ axes)[:, :, 1]
    return wall
