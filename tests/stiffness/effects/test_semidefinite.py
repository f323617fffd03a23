"""The nearest matrix without negative directions, by the precision of its entries."""

from __future__ import annotations

import numpy as np
import pytest

from stiffness.effects import BY_NAME
from stiffness.effects.semidefinite import nearest_semidefinite

BELOW = np.tril_indices(6, -1)


def wanted(seed: int) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(6, 6))
    return np.asarray(root + root.T)


@pytest.mark.parametrize("seed", range(8))
def test_with_equal_precision_it_is_that_of_higham(seed: int) -> None:
    """Frobenius norm: an entry below the diagonal counts twice; eigenvalues below zero become zero."""
    w = wanted(seed)
    values, vectors = np.linalg.eigh(w)
    assert values[0] < -0.5
    higham = (vectors * np.maximum(values, 0)) @ vectors.T
    found = nearest_semidefinite(w, np.diag([1.0] * 6 + [2.0] * 15))
    assert found == pytest.approx(higham, abs=2e-3)


@pytest.mark.parametrize("seed", range(8))
def test_no_allowed_matrix_is_nearer(seed: int) -> None:
    """Optimality over the cone (Boyd & Vandenberghe 5.9): the gradient has no negative direction and none in C."""
    rng, w = np.random.default_rng(seed + 50), wanted(seed)
    root = rng.normal(size=(40, 21)) * 10 ** rng.uniform(-1, 1, 21)
    precision = root.T @ root
    found = nearest_semidefinite(w, precision)
    off = precision @ np.concatenate([np.diag(found - w), (found - w)[BELOW]])
    gradient = np.diag(off[:6])
    gradient[BELOW] = off[6:] / 2
    gradient = gradient + gradient.T - np.diag(np.diag(gradient))
    size = np.abs(gradient).max()
    assert np.linalg.eigvalsh(gradient).min() > -1e-6 * size
    assert np.abs(gradient @ found).max() < 1e-3 * size * np.abs(found).max()
    assert np.linalg.eigvalsh(found).min() > -1e-12
    assert size > 1


@pytest.mark.parametrize("name", ["base-compliance", "tool-compliance"])
def test_what_is_known_well_stays_where_it_is(name: str) -> None:
    """A tilt known to a per mille beside a coupling that is hardly known: the coupling gives way."""
    spring = BY_NAME[name]
    assert spring.nearest is not None
    p = {"linear_m_per_n": np.full(3, 1e-8), "angular_rad_per_nm": np.full(3, 1e-6), "coupling": np.zeros(15)}
    p["coupling"][6] = 3e-7  # row ry, column x: no tilt of 1e-6 and shift of 1e-8 allow more than 1e-7
    sd = np.concatenate([np.full(3, 1e-11), np.full(3, 1e-9), np.full(15, 1e-7)])
    assert "semi-definite" in spring.check(p)
    by_size, by_data = spring.nearest(p), spring.nearest(p, np.diag(sd**-2))
    assert by_size["angular_rad_per_nm"][1] > 1.1e-6
    assert spring.check(by_data) == ""
    assert by_data["angular_rad_per_nm"] == pytest.approx(np.full(3, 1e-6), rel=2e-3)
    assert by_data["linear_m_per_n"] == pytest.approx(np.full(3, 1e-8), rel=2e-3)
    assert by_data["coupling"][6] == pytest.approx(1e-7, rel=2e-3)


def test_coupled_joints_give_way_where_they_are_hardly_known() -> None:
    coupling = BY_NAME["joint-coupling"]
    assert coupling.nearest is not None
    p = {"coupling": np.zeros(15)}
    p["coupling"][[0, 1, 2]] = 0.9, 0.9, -0.9  # (2,1), (3,1), (3,2): not all at once
    sd = np.full(15, 1e-3)
    sd[2] = 0.5
    found = coupling.nearest(p, np.diag(sd**-2))["coupling"]
    assert coupling.check({"coupling": found}) == ""
    assert found[:2] == pytest.approx([0.9, 0.9], abs=1e-3)
    assert found[2] == pytest.approx(0.9**2 - (1 - 0.9**2), abs=5e-3)  # the smallest that these two allow
