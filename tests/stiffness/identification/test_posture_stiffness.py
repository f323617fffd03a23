"""A joint whose stiffness varies over the workspace: identified from several postures on the independent plant."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffness.identification.fit import Fit
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
    q = session.samples.q  # what the readings can say: the compliance at the angles that were measured
    truth = (1 + SOFTER * np.sin((q - STIFFEST) / 2) ** 2) / lab.stiffness
    assert np.abs(compliance(fit, q) / truth - 1)[:, 1:3].max() < 0.02
    assert np.abs(1 / plain.values()["joint-stiffness"]["k_nm_per_rad"] / truth - 1)[:, 1:3].max(axis=0).min() > 0.1
    found = fit.values()["posture-stiffness"]
    sd = dict(zip(map(str, fit.unknowns.free), np.ravel(fit.sd), strict=False))
    waves = dict.fromkeys(("cos2", "sin2", "cos3", "sin3"), np.zeros(6))
    expectations = {"softer": SOFTER, "stiffest_rad": STIFFEST, **waves}
    near = {(name, j): sd[f"posture-stiffness.{name}[{j + 1}]"] for name in expectations for j in (1, 2)}
    near = {key: s for key, s in near.items() if s < 0.25}  # beyond, the valley of chi-square is no parabola
    assert len(near) >= 8
    for (name, joint), s in near.items():
        assert abs(found[name][joint] - expectations[name][joint]) < 3 * s
    spring = np.abs(1 / fit.values()["joint-stiffness"]["k_nm_per_rad"] - 1 / lab.stiffness)[:3]
    assert np.all(spring < 3 * np.array([sd[f"joint-stiffness.k_nm_per_rad[{j}]"] for j in (1, 2, 3)]))
    assert spring[0] < 0.02 / lab.stiffness[0]


def compliance(fit: Fit, q: np.ndarray) -> np.ndarray:
    """(N, n) rad/(N*m) at joint angles, written out from the page."""
    p, k = fit.values()["posture-stiffness"], fit.values()["joint-stiffness"]["k_nm_per_rad"]
    first = p["softer"] * (1 - np.cos(q - p["stiffest_rad"])) / 2
    waves = sum(p[f"cos{m}"] * np.cos(m * q) + p[f"sin{m}"] * np.sin(m * q) for m in (2, 3))
    return np.asarray((1 + first + waves) / k)
