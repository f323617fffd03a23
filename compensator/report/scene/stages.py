"""Stages of a mesh that changes along a path: all their triangles once, and which of them are there when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.scene.packing import packed
from compensator.report.scene.solids import SolidMesh

Floats = npt.NDArray[np.float64]
Index = npt.NDArray[np.intp]
Longs = npt.NDArray[np.int64]

FINE = 512  # places along a step of the grid at which corners of triangles may stand
BITS = 21  # of each of three numbers in a key


@dataclass(frozen=True, repr=False, eq=False)
class Stages:
    """Which faces of a mesh are there.

    Attributes:
        runs: (G, 3) of faces in their order: how many, the first stage that has them, the first that has them no more.
        stage: (S,) of every station.
    """

    runs: Longs
    stage: Index

    def __repr__(self) -> str:
        return f"Stages({int(self.stage.max(initial=0)) + 1}, {int(self.runs[:, 0].sum())} faces)"

    def as_dict(self) -> dict[str, Any]:
        """For the page."""
        return {"runs": self.runs.ravel().tolist(), "stage": packed(self.stage, np.uint8)}


def merged(meshes: Sequence[tuple[Floats, Longs]], start: Floats, step: float) -> tuple[SolidMesh, Longs]:
    """Meshes of one grid as one that has every triangle once, and the runs of its faces.

    Args:
        meshes: vertices (V, 3) m and faces (F, 3), a stage each, in their order.
        start, step: m, first node of the grid and what lies between nodes.
    """
    corner = np.concatenate([vertices for vertices, _ in meshes])
    place = np.round((corner - start) * (FINE / step)).astype(np.int64)
    place, number = _distinct(place)
    ahead = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    every = number[np.concatenate([faces + k for (_, faces), k in zip(meshes, ahead, strict=False)])]
    stage = np.repeat(np.arange(len(meshes)), [len(faces) for _, faces in meshes])
    a, b, c = every.T
    some = (a != b) & (b != c) & (c != a)  # where corners fell together nothing is left of a triangle
    faces, which = _distinct(every[some])
    first, end = np.full(len(faces), len(meshes)), np.zeros(len(faces), dtype=np.int64)
    np.minimum.at(first, which, stage[some])
    np.maximum.at(end, which, stage[some] + 1)
    order = np.lexsort((np.arange(len(faces)), end, first))
    kinds, count = np.unique(np.column_stack([first, end])[order], axis=0, return_counts=True)
    return SolidMesh(start + place * (step / FINE), faces[order]), np.column_stack([count, kinds])


def _distinct(rows: Longs) -> tuple[Longs, Index]:
    """Different rows of three numbers (N, 3) below 2^21, and which of them each row is."""
    key = rows[:, 0] << 2 * BITS | rows[:, 1] << BITS | rows[:, 2]
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    return rows[first], number
