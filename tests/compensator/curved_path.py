"""A 5-axis finish of a curved surface: lanes over a wavy sheet, the tool axis leaning as it goes."""

from __future__ import annotations

import numpy as np

from tests.plant.geometry import Array

LANES = (-80.0, -40.0, 0.0, 40.0, 80.0)
PER_LANE = 12
CLEARANCE = 60.0  # mm along the tool axis


def surface(x: float, y: float) -> tuple[Array, Array]:
    """Point (mm) and tool axis: the normal, leaning by up to some 12 deg."""
    z = 40 * np.sin(x / 120) * np.cos(y / 150)
    slope_x = np.cos(x / 120) * np.cos(y / 150) / 3
    slope_y = -np.sin(x / 120) * np.sin(y / 150) * 4 / 15
    normal = np.array([-slope_x, -slope_y, 1.0])
    axis = normal / np.linalg.norm(normal) + 0.15 * np.array([np.sin(x / 60), np.cos(y / 50), 0.0])
    return np.array([x, y, z]), axis / np.linalg.norm(axis)


def rows() -> list[list[object]]:
    """Rows of a csv toolpath: x y z i j k feed kind; a retract and an approach after the third lane."""
    out: list[list[object]] = []

    def pose(x: float, y: float, kind: str) -> None:
        point, axis = surface(x, y)
        out.append([*(point + (CLEARANCE * axis if kind == "rapid" else 0)), *axis, 1200.0, kind])

    for lane, y in enumerate(LANES):
        xs = np.linspace(-150, 150, PER_LANE)[:: -1 if lane % 2 else 1]
        if lane in (0, 3):
            pose(xs[0], y, "rapid")
        for x in xs:
            pose(x, y, "cut")
        if lane in (2, len(LANES) - 1):
            pose(xs[-1], y, "rapid")
    return out
