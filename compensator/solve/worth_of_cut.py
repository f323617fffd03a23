"""What the inputs of a computed cut are worth: its material by standard deviations, its stock by a millimetre."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from compensator.cell.external_axes import workobject_along
from compensator.process.milling.kernels.stock_distance import BOX, KIND, MESH, SIZE
from compensator.process.milling.milling import MillingProcess, Shop
from compensator.process.milling.milling_load import MilledForce
from compensator.process.milling.stock import Stock, box_stock, cylinder_stock
from compensator.process.process import ToolMotion
from compensator.solve.compensation import Compensation
from toolpaths.finding import NOTE, WARNING, Finding

Floats = npt.NDArray[np.float64]
Moved = Callable[[Floats], float]

MORE_STOCK = 1e-3  # m, all over
COARSER = 2.0  # than the grid of the cut: what is asked for is worth no more digits
WIDE = 0.25  # share of the force that a standard deviation is: above it, the material is to be measured


def cut_worths(c: Compensation, rows: npt.NDArray[np.intp], moved: Moved) -> Iterator[tuple[Finding, float]]:
    """Findings and how far the TCP moves at most, m; nothing where the force is not computed.

    Args:
        rows: (K,) poses that are looked at. moved: of a wrench (K, 6) there, how far it moves the TCP.
    """
    if isinstance(c.load, MilledForce):
        yield from _material(c.load, rows, moved)
        yield from _stock(c, c.load, rows, moved)


def _material(load: MilledForce, rows: npt.NDArray[np.intp], moved: Moved) -> Iterator[tuple[Finding, float]]:
    material = load.material
    if material.covariance is None or load.shares is None:
        return
    variance, ways = np.linalg.eigh(material.covariance)
    shares = load.shares.at(rows)
    parts = [shares @ (way * np.sqrt(v)) for v, way in zip(variance, ways.T, strict=True) if v > 0]
    size = float(np.linalg.norm([moved(load.wrench[rows] + part) for part in parts]))
    whole = float(np.linalg.norm(load.wrench[rows, :3]))
    share = float(np.linalg.norm([np.linalg.norm(part[:, :3]) for part in parts])) / whole if whole else 0.0
    what = f"the coefficients of the cutting force, by their standard deviations ({share:.0%} of the force)"
    level = WARNING if share > WIDE else NOTE
    remedy = "Measure yours: compensator cutting"
    yield Finding(level, f"material {material.name}", what, remedy, kind="process"), size


def _stock(
    c: Compensation, load: MilledForce, rows: npt.NDArray[np.intp], moved: Moved
) -> Iterator[tuple[Finding, float]]:
    process, placement = c.job.placement.process, c.job.placement
    larger = None if not isinstance(process, MillingProcess) else _larger(process.shop)
    if larger is None or not isinstance(process, MillingProcess):
        return
    other = replace(process, shop=replace(process.shop, stock=larger))
    work = workobject_along(placement, c.path.toolpath)
    motion = ToolMotion(c.path.toolpath, work, c.path.tcp)
    size = moved(other.wrench_at(motion, rows, COARSER * load.cell))
    what = f"the stock: were it {MORE_STOCK * 1e3:g} mm larger all over"
    yield Finding(NOTE, f"{placement.source}: process.stock", what, "Measure it, or probe it", kind="process"), size


def _larger(shop: Shop) -> Stock | None:
    """A box or cylinder with more on it; None for a mesh."""
    number = shop.stock.solid.number
    if number[KIND] == BOX:
        return box_stock(shop.stock.box[0] - MORE_STOCK, shop.stock.box[1] + MORE_STOCK)
    if number[KIND] == MESH:
        return None
    x, y, radius, lower, upper = (float(v) for v in number[SIZE : SIZE + 5])
    return cylinder_stock(np.array([x, y]), radius + MORE_STOCK, (lower - MORE_STOCK, upper + MORE_STOCK))
