"""Lean: the tool axis away from that of the toolpath, by a small rotation normal to it.

A lean (2,) is a rotation vector, rad, along x and y of the reference orientation; its length is the angle between the
two axes. A ball keeps its centre, so that it touches where it did: the tip moves. Without a ball the TCP stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from compensator.errors import CellError
from compensator.path.free_turn import about_z, reference_rotation
from toolpaths.toolpath import CUT, Toolpath

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class CutterShape:
    """What a cell tells of a cutter: its ``shape``, None: nothing; ``diameter`` m, None: not told."""

    shape: str | None
    diameter: float | None


@dataclass(frozen=True, eq=False)
class LeanRoom:
    """Where along a path the tool may lean.

    Attributes:
        cone: rad, at most.
        radius: (N,) m of the ball whose centre stays; 0: the TCP stays.
        open: (N,) whether it may lean.
        declared: nothing is known of the cutter: the cell file says that it may lean about the TCP.
    """

    cone: float
    radius: Floats
    open: Bools
    declared: bool

    @classmethod
    def of(cls, cone: float, toolpath: Toolpath, shapes: Mapping[int | None, CutterShape], source: str) -> LeanRoom:
        """Of a path whose tools have ``shapes``, by their number; None: of all.

        Raises:
            CellError: no cutter in use is a ball, or the size of one is not told.
        """
        radius, room = np.zeros(len(toolpath)), np.zeros(len(toolpath), dtype=np.bool_)
        unknown, cuts = CutterShape(None, None), toolpath.kind == CUT
        declared, refused = False, ""
        for number in np.unique(toolpath.tool[cuts]):
            found = shapes.get(int(number), shapes.get(None, unknown))
            mine = toolpath.tool == number
            if found.shape is None:
                room, declared = room | mine, True
            elif found.shape.strip().lower() != "ball":
                refused = refused or found.shape
            elif found.diameter is None:
                raise CellError(
                    f"{source}: solve.lean: a ball leans about its centre, and this one has no diameter: give it"
                )
            else:
                room, radius = room | mine, np.where(mine, found.diameter / 2, radius)
        if not room.any():
            raise CellError(
                f"{source}: solve.lean: a {refused} cutter that leans cuts another surface; only a ball may (shape = "
                '"ball"), or a cutter whose shape the cell does not tell; take lean away'
            )
        return cls(cone, radius, room, declared)


def leaned_rotation(lean: Floats) -> Floats:
    """(N, 3, 3) of leans (N, 2)."""
    angle = np.linalg.norm(lean, axis=1)
    u, v, zero = lean[:, 0], lean[:, 1], np.zeros(len(lean))
    cross = np.stack([zero, zero, v, zero, zero, -u, -v, u, zero], axis=1).reshape(-1, 3, 3)
    sine = np.sinc(angle / np.pi)[:, None, None]
    half = (np.sinc(angle / (2 * np.pi)) ** 2 / 2)[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + half * (cross @ cross))


def leaned(toolpath: Toolpath, radius: Floats, state: Floats) -> tuple[Toolpath, Floats]:
    """The path with leaned tool axes, and its turns (N,) rad from its own reference orientation.

    Args:
        radius: (N,) m of the ball whose centre stays; 0: the TCP stays.
        state: (N, 3) rad: turn, from the reference orientation of ``toolpath``, and lean.
    """
    turn, lean = state[:, 0], state[:, 1:]
    if not lean.any():
        return toolpath, turn
    wanted = reference_rotation(toolpath) @ leaned_rotation(lean)
    leans = np.any(lean, axis=1, keepdims=True)
    axis = np.where(leans, -wanted[:, :, 2], toolpath.axis)
    position = toolpath.position + radius[:, None] * (toolpath.axis - axis)
    out = replace(toolpath, axis=axis, position=position)
    relative = np.swapaxes(reference_rotation(out), 1, 2) @ wanted @ about_z(turn)
    return out, np.unwrap(np.arctan2(relative[:, 1, 0], relative[:, 0, 0]))


def within_cone(lean: Floats, cone: float) -> Floats:
    """Leans (N, 2), those beyond the cone brought back to its edge."""
    angle = np.linalg.norm(lean, axis=1, keepdims=True)
    return np.asarray(lean * np.minimum(1.0, cone / np.maximum(angle, 1e-12)))
