"""Friction along a compensated path, on a plant whose links are dragged by dry bearings: reversals included."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.compensator.milled_circle import GCODE, MODEL, bench

TORQUES = [300.0, 250.0, 200.0, 60.0, 30.0, 12.0]  # N*m
WEIGHTS = {"weight_half": [0.5] * 6, "weight_double": [0.3] * 6, "weight_quarter": [0.8] * 6}


@pytest.mark.parametrize(("held", "weights"), [(0.99, {}), (0.8, WEIGHTS)], ids=["one", "four"])
def test_a_circle_is_round_though_joints_let_go_late(
    tmp_path: Path, held: float, weights: dict[str, list[float]]
) -> None:
    """Each reversal takes a travel of 2 T / (b K) to turn the friction over; poses stand within it."""
    friction = {"friction_nm": TORQUES, "held": [held] * 6, "lag": [1.0] * 6, **weights}
    springs = MODEL["joint-stiffness"]
    job = replace(bench(tmp_path, 1.0), effects={"joint-stiffness": springs, "joint-friction": friction})
    path = tmp_path / "circle.nc"
    path.write_text(GCODE)
    _, table = job.compensate(path)
    plant, wanted = job.plant(), job.in_base(table.nominal)

    def error(nominal: bool) -> np.ndarray:
        walk = job.walk(plant, table, nominal=nominal)
        return np.asarray(np.linalg.norm(walk.tcp[:, :3, 3] - wanted[:, :3, 3], axis=1)[table.cut])

    assert error(nominal=True).mean() > 5e-4
    assert error(nominal=False).max() < 1e-6
    stiffness, most = np.array(springs["k_nm_per_rad"]), np.array(TORQUES)
    release = 2 * most / held / stiffness
    move = np.abs(np.diff(table.q[table.cut], axis=0))
    within = (move < release) & (np.sign(np.diff(table.q[table.cut], axis=0)) != 0)
    assert within.sum() > 50  # moves shorter than the release travel
