"""Joint laws against what makers and textbooks draw, and what files written before mean."""

from __future__ import annotations

import tomllib
from pathlib import Path

import casadi as ca
import numpy as np
import numpy.typing as npt
import pytest
import tomli_w

from stiffness.effects import BY_NAME
from stiffness.effects.effect import JointInput
from stiffness.errors import StiffnessError
from stiffness.model.model import load_model
from tests.plant.joints import Pieces

Floats = npt.NDArray[np.float64]
K = 5e5  # N*m/rad


def law(name: str, torque: float, angle: float, values: dict[str, float]) -> float:
    """rad that an effect adds in one joint."""
    joint, n = BY_NAME[name].joint, ca.SX.zeros(1)
    assert joint is not None
    given = JointInput(n + torque, n + torque / K, n + 1 / K, n + angle, n, ca.SX(0))
    return float(ca.evalf(joint(given, {k: ca.SX(v) for k, v in values.items()})))


@pytest.mark.parametrize("ratio", [1.5, 2.4, 5.0])
def test_sharp_hardening_is_the_makers_three_pieces(ratio: float) -> None:
    first, second = 120.0, 120.0 * ratio
    k1, k2 = 2e5, 3.2e5
    values = {
        "windup_rad": first * (1 / k1 - 1 / k2),
        "knee_nm": first,
        "further_rad": second * (1 / k2 - 1 / K),
        "knee_ratio": ratio,
        "sharpness": 1.0,
    }
    pieces = Pieces(np.array([[k1, k2, K]]), np.array([[first, second]]))
    whole = values["windup_rad"] + values["further_rad"]
    for torque in np.linspace(-1000, 1000, 161):
        expected = float(pieces(np.array([torque]), np.zeros(1))[0])
        off = abs(torque / K + law("joint-hardening", torque, 0.0, values) - expected)
        corner = min(abs(abs(torque) / t - 1) for t in (first, second)) < 0.1
        assert off < (0.02 if corner else 0.005) * whole
    slope = law("joint-hardening", 1.0, 0.0, values) + 1 / K
    assert slope == pytest.approx(1 / k1, rel=1e-3)


def test_hardening_of_a_file_without_the_new_numbers_is_two_tanh(tmp_path: Path) -> None:
    old = {"windup_rad": [3e-4] * 6, "knee_nm": [150.0] * 6, "further_rad": [2e-4] * 6}
    values = loaded(tmp_path, "joint-hardening", old)
    for torque in (-700.0, -90.0, 40.0, 260.0, 2000.0):
        got = law("joint-hardening", torque, 0.0, {k: float(v[2]) for k, v in values.items()})
        assert got == pytest.approx(3e-4 * np.tanh(torque / 150) + 2e-4 * np.tanh(torque / 600), rel=1e-12)


def test_friction_of_a_file_without_the_new_numbers_is_one_operator(tmp_path: Path) -> None:
    values = loaded(tmp_path, "joint-friction", {"friction_nm": [30.0] * 6, "held": [0.7] * 6})
    memory = BY_NAME["joint-friction"].memory
    assert memory is not None
    assert np.array_equal(memory.bounds(values), np.r_[np.full(6, 30.0), np.zeros(18)])
    torque = np.array([[0.0], [10.0], [80.0]]) * np.ones(6)
    clamp = memory.rule(np.zeros_like(torque), torque, values, np.full(6, K))
    np.testing.assert_allclose(clamp.shift[:, :6], -0.7 * np.diff(torque, axis=0, prepend=0.0))
    assert not np.any(clamp.shift[:, 6:])


def test_posture_stiffness_keeps_the_compliance_positive(tmp_path: Path) -> None:
    """Bounds one by one allow 1 - 0.99 of two harmonics, not of four."""
    effect = BY_NAME["posture-stiffness"]
    old = {"softer": [0.0] * 6, "stiffest_rad": [0.0] * 6, "cos2": [0.7] * 6, "sin2": [0.7] * 6}
    values = loaded(tmp_path, "posture-stiffness", old)
    assert effect.check(values) == ""
    angles = np.linspace(-np.pi, np.pi, 721)
    least = min(1 + law("posture-stiffness", K, a, {k: float(v[0]) for k, v in values.items()}) for a in angles)
    assert least == pytest.approx(1 - np.hypot(0.7, 0.7), abs=1e-4)
    more = {**values, "cos3": np.array([0.0, 0, 0, 0.4, 0, 0]), "softer": np.full(6, 0.2)}
    said = effect.check(more)
    assert said.startswith("joint 4 would have -0.3") and "make them smaller" in said
    with pytest.raises(StiffnessError, match="joint 4 would have"):
        loaded(tmp_path, "posture-stiffness", {k: v.tolist() for k, v in more.items()})
    assert effect.nearest is not None
    allowed = effect.nearest(more)
    assert effect.check(allowed) == ""
    kept = [k for k in range(6) if k != 3]
    assert all(np.array_equal(allowed[name][kept], more[name][kept]) for name in more)
    assert allowed["softer"][3] == 0.2
    shrunk = np.array([allowed[name][3] / more[name][3] for name in ("cos2", "sin2", "cos3")])
    assert np.ptp(shrunk) < 1e-12 and 0.5 < shrunk[0] < 1
    compliance = [1 + law("posture-stiffness", K, a, {k: float(v[3]) for k, v in allowed.items()}) for a in angles]
    assert 0 < min(compliance) < 0.003


def loaded(folder: Path, name: str, numbers: dict[str, list[float]]) -> dict[str, Floats]:
    """Values of an effect as read from a model file."""
    path = folder / "model.toml"
    effects = {"joint-stiffness": {"k_nm_per_rad": [K] * 6}, name: numbers}
    path.write_text(tomli_w.dumps({"schema": "model/1", "robot": "ur10", "effects": effects}))
    assert tomllib.loads(path.read_text())["effects"][name].keys() == numbers.keys()
    return {k: np.array(v) for k, v in load_model(path).values[name].items()}
