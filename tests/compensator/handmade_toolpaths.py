"""Toolpaths in memory, by hand or at random."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from toolpaths.toolpath import CUT, RAPID, SENSE_OPEN, Toolpath

DOWN = Rotation.from_euler("x", 180, degrees=True).as_matrix()  # TCP z into the table, x along x


def toolpath(
    xyz: Sequence[Sequence[float]] | np.ndarray,
    kind: str | None = None,
    axis: np.ndarray | None = None,
    quaternion: np.ndarray | None = None,
    **other: Any,
) -> Toolpath:
    """Poses at `xyz` (mm); `kind` is a word of r and c, all cut by default; axis z by default."""
    position = np.asarray(xyz, dtype=float) / 1e3
    n = len(position)
    if quaternion is not None:
        axis = -Rotation.from_quat(quaternion[:, [1, 2, 3, 0]]).as_matrix()[:, :, 2]
    given: dict[str, Any] = {
        "source": "test.csv",
        "language": "csv",
        "position": position,
        "axis": np.tile([0.0, 0.0, 1.0], (n, 1)) if axis is None else axis,
        "quaternion": quaternion,
        "feed": np.full(n, 0.02),
        "kind": np.array([CUT if c == "c" else RAPID for c in kind or "c" * n], dtype=np.uint8),
        "tool": np.zeros(n, dtype=np.int32),
        "spindle": np.full(n, np.nan),
        "sense": np.full(n, SENSE_OPEN),
        "line": np.arange(2, n + 2, dtype=np.int32),
        "row": np.arange(n, dtype=float),
    }
    return Toolpath(**{**given, **other})


def wandering_axes(n: int, seed: int, centre: Sequence[float], spread: float) -> np.ndarray:
    """(n, 3) unit axes on a smooth random way, at most about `spread` rad from `centre`."""
    g = np.random.default_rng(seed)
    keys = Rotation.from_rotvec(g.uniform(-1, 1, (8, 3)) * spread / np.sqrt(3))
    way = Slerp(np.linspace(0, 1, 8), keys)(np.linspace(0, 1, n))
    return way.apply(np.asarray(centre, dtype=float) / np.linalg.norm(centre))


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(N,) rad between rotations (N, 3, 3)."""
    return Rotation.from_matrix(np.swapaxes(a, 1, 2) @ b).magnitude()
