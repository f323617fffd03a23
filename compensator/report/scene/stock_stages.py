"""What is left of the stock in stages along the path, as one body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from compensator.process.milling.mill import Cut
from compensator.process.milling.remains import Remains
from compensator.process.milling.stages import stock_stages
from compensator.process.milling.surface import Nodes, nodes_around, surface
from compensator.report.scene.moments import Moments
from compensator.report.scene.solids import SolidMesh
from compensator.report.scene.stages import Stages, merged

Index = npt.NDArray[np.intp]

CELLS = 60  # of the mesh of what remains, along the longest side of the stock
FEWEST, MOST = 12, 48  # stages along the path
MOST_VALUES = 3_000_000  # nodes of all stages: a second
MOST_WANTED = 12  # poses with a stage of their own beside these
MOST_FACES = 80_000  # of all stages: a megabyte of a page


def left_cell(remains: Remains, cell: float) -> float:
    """m between nodes of the mesh of what remains, where the cut was computed with ``cell`` m."""
    return max(float(np.ptp(remains.stock.box, axis=0).max()) / CELLS, cell)


def left_stages(cut: Cut, remains: Remains, cell: float, moments: Moments) -> tuple[SolidMesh, Stages]:
    """The faces of all stages, and which are there at which station: those of the last stage that is over then.

    Args:
        remains: of the cut. cell: m between nodes.
    """
    nodes = nodes_around(remains.stock.box, cell)
    poses = stage_poses(cut, stage_count(nodes), moments.wanted)
    meshes = [surface(values, nodes) for values in stock_stages(cut, remains, nodes, poses.tolist())]
    mesh, runs = merged(meshes, nodes.start, nodes.step)
    while len(mesh.faces) > MOST_FACES and len(poses) > 2:
        kept = [*range(0, len(poses) - 1, 2), len(poses) - 1]
        poses, meshes = poses[kept], [meshes[k] for k in kept]
        mesh, runs = merged(meshes, nodes.start, nodes.step)
    return mesh, Stages(runs, np.searchsorted(poses, moments.rows, side="right") - 1)


def stage_count(nodes: Nodes) -> int:
    """How many stages a grid allows."""
    return int(np.clip(MOST_VALUES // int(np.prod(nodes.count)), FEWEST, MOST))


def stage_poses(cut: Cut, count: int, wanted: tuple[int, ...] = ()) -> Index:
    """Poses (P,), ascending, at whose moves a stage ends: the first, the last, the ``wanted``, and ``count`` others.

    Even in poses and volume alike: a finish takes little away, and has many poses.
    """
    last = len(cut) - 1
    gone = np.cumsum(cut.removed)
    share = 0.5 * (np.arange(len(cut)) / max(last, 1) + gone / max(float(gone[-1]), 1e-18))
    even = np.searchsorted(share, np.linspace(0.0, share[-1], count + 1))
    return np.union1d(np.minimum(even, last), np.array([0, last, *wanted[:MOST_WANTED]], dtype=np.intp))
