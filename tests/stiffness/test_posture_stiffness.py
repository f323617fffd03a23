"""A joint whose stiffness varies over the workspace: identified from several postures on the independent plant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffness.identify import identify
from tests.plant import Plant
from tests.stiffness.bench_lab import Lab

SOFTER = np.array([0.0, 0.6, 0.4, 0.0, 0.0, 0.0])
STIFFEST = np.array([0.0, 0.3, -0.4, 0.0, 0.0, 0.0])


@dataclass(frozen=True)
class Varying(Lab):
    """The laboratory's arm, joints 2 and 3 softer away from one angle."""

    def plant(self) -> Plant:
        plain = super().plant()
        k = self.stiffness

        def softer(torque: np.ndarray, angle: np.ndarray) -> np.ndarray:
            return torque / k * SOFTER * np.sin((angle - STIFFEST) / 2) ** 2

        return Plant(plain.arm, stiffness=k, hardening=softer, gravity_on=True)


def test_several_postures_tell(tmp_path: Path) -> None:
    lab = Varying()
    session, _ = lab.session(tmp_path, 5, setups=40)
    plain = identify([session], ["joint-stiffness"])
    fit = identify([session], ["joint-stiffness", "posture-stiffness"])
    assert plain.solution.chi2 > 1.8 * fit.solution.chi2  # although it left out what it could not explain
    assert fit.outlier_rows() == []
    found = fit.values()["posture-stiffness"]
    assert np.abs(found["softer"] - SOFTER)[1:3].max() < 0.05
    assert np.abs(found["stiffest_rad"] - STIFFEST)[1:3].max() < 0.1
    k = fit.values()["joint-stiffness"]["k_nm_per_rad"]
    assert np.abs(k / lab.stiffness - 1)[:3].max() < 0.02
