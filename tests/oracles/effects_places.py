"""Effects of links, base and tool, in plain numpy: offsets, six-dimensional springs, hinges, growth, masses."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.oracles.oracle import Numbers, Oracle, Place

Floats = npt.NDArray[np.float64]


def compliance(p: Numbers) -> Floats:
    """(6, 6): diagonal, then row by row below it."""
    c = np.zeros((6, 6))
    entries = iter(p["coupling"])
    for row in range(6):
        for column in range(row):
            c[row, column] = c[column, row] = next(entries)
    for i in range(3):
        c[i, i], c[3 + i, 3 + i] = p["linear_m_per_n"][i], p["angular_rad_per_nm"][i]
    return c


def _bracket(rng: np.random.Generator) -> dict[str, Floats]:
    a = rng.normal(size=(6, 6))
    s = np.diag(np.sqrt([1e-7, 2e-7, 3e-8, 1e-6, 2e-6, 5e-7]))
    c = s @ a @ a.T @ s
    below = np.array([c[i, j] for i in range(6) for j in range(i)])
    return {"linear_m_per_n": np.diag(c)[:3].copy(), "angular_rad_per_nm": np.diag(c)[3:].copy(), "coupling": below}


def _displaced(given: Place, p: Numbers) -> Floats:
    k = given.place - 1
    return np.array([p[a][k] for a in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")])


def hinge(angular: Floats, at: Floats) -> Floats:
    """(6, 6) of a joint at ``at`` (3,) that yields by ``angular`` (3,) rad/(N*m): shifted by a congruence.

    The motion of the origin is that of a body that turns about ``at``; the moment about ``at`` is its transpose.
    """
    turns = np.array([np.r_[np.cross(axis, -at), axis] for axis in np.eye(3)]).T  # (6, 3): velocity of the origin
    return np.asarray(turns @ np.diag(angular) @ turns.T)


def _bent(given: Place, p: Numbers) -> Floats:
    k = given.place - 1
    share = p["at"][k]
    angular = np.array([p[f"r{axis}_rad_per_nm"][k] for axis in "xyz"])
    return np.asarray(hinge(angular, (1 - share) * given.inner + share * given.outer) @ given.wrench)


def _grown(given: Place, p: Numbers) -> Floats:
    """How much farther the end is from the joint once every length is multiplied."""
    length = given.outer - given.inner
    longer = (1 + p["expansion_per_k"][given.place] * given.temperature) * length
    return np.r_[longer - length, np.zeros(3)]


_NO_SPRING = {"linear_m_per_n": 0.0, "angular_rad_per_nm": 0.0, "coupling": 0.0}

PLACES: dict[str, Oracle] = {
    "kinematic-offset": Oracle(
        joint=lambda given, p: p["zero_rad"],
        place=_displaced,
        nothing=dict.fromkeys(("zero_rad", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"), 0.0),
        without_load=True,
    ),
    "payload": Oracle(
        mass=lambda joints, p: [(joints, float(p["mass_kg"][0]), p["com_m"])], nothing={"mass_kg": 0.0}
    ),
    "base-compliance": Oracle(
        place=lambda given, p: compliance(p) @ given.wrench, nothing=_NO_SPRING, sample=_bracket
    ),
    "link-compliance": Oracle(place=_bent, nothing={f"r{a}_rad_per_nm": 0.0 for a in "xyz"}),
    "tool-compliance": Oracle(
        place=lambda given, p: compliance(p) @ given.wrench, nothing=_NO_SPRING, sample=_bracket
    ),
    "thermal-drift": Oracle(
        joint=lambda given, p: (20.0 + given.temperature) * p["zero_rad_per_k"] - 20.0 * p["zero_rad_per_k"],
        place=_grown,
        nothing={"expansion_per_k": 0.0, "zero_rad_per_k": 0.0},
        without_load=True,
        still=(3, 4, 5),
    ),
}
