"""Stock, what remains of it and the finished part as bodies in the work object."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.kernels.stock_distance import BOX, CYLINDER
from compensator.process.milling.milling import MillingProcess
from compensator.process.milling.milling_load import MillingLoad
from compensator.process.milling.stock import Stock
from compensator.process.process import Process
from compensator.report.scene.drawn_body import DrawnBody
from compensator.report.scene.solids import SolidMesh, box, turned

Floats = npt.NDArray[np.float64]

STOCK_COLOUR, LEFT_COLOUR, PART_COLOUR = "#8fa3b5", "#b8c0c8", "#7fb08a"
CELLS = 60  # of the mesh of what remains, along the longest side of the stock
MOST_FACES = 30_000


def stock_bodies(process: Process, load: MillingLoad) -> list[DrawnBody]:
    """Bodies of a milled path; none where nothing was cut."""
    if load.cut.remains is None:
        return []
    bodies = [DrawnBody(stock_mesh(load.cut.remains.stock), -1, "stock", STOCK_COLOUR, opacity=0.25)]
    size = float(np.ptp(load.cut.remains.stock.box, axis=0).max())
    vertices, faces = load.cut.remains.mesh(max(size / CELLS, load.cell))
    if len(faces):
        bodies.append(DrawnBody(SolidMesh(vertices, faces), -1, "left", LEFT_COLOUR))
    if isinstance(process, MillingProcess) and process.shop.part is not None:
        part = stock_mesh(process.shop.part)
        bodies.append(DrawnBody(part, -1, "part", PART_COLOUR, opacity=0.6))
    return bodies


def stock_mesh(stock: Stock) -> SolidMesh:
    """The surface of a stock; of a fine mesh every so many triangles are left out."""
    number = stock.solid.number
    if number[0] == BOX:
        return box(stock.box[0], stock.box[1])
    if number[0] == CYLINDER:
        x, y, radius, low, high = number[1:6]
        return turned(np.full(2, radius), np.array([low, high])).moved(np.eye(3), np.array([x, y, 0.0]))
    return thinned(stock.solid.tree.corner)


def thinned(corner: Floats) -> SolidMesh:
    """Triangles (T, 3, 3) as a mesh whose corners lie on a grid, as coarse as MOST_FACES asks for."""
    points = corner.reshape(-1, 3)
    size = max(float(np.ptp(points, axis=0).max()), 1e-6)
    grid = size * 1e-6
    while True:
        cell = np.round(points / grid).astype(np.int64)
        _, first, index = np.unique(cell, axis=0, return_index=True, return_inverse=True)
        faces = index.reshape(-1, 3)
        some = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        if some.sum() <= MOST_FACES:
            return SolidMesh(points[first], faces[some])
        grid = max(2 * grid, size / 2000)
