"""Effects of the instruments, in plain numpy: a tracker that creeps, a force sensor that shows something else."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.integrate import quad

from tests.oracles.oracle import Numbers, Oracle

Floats = npt.NDArray[np.float64]


def _crept(position: Floats, time: float, p: Numbers) -> Floats:
    """The velocity of every point, dying away, integrated from the start."""
    velocity = p["linear_m_per_s"] + np.cross(p["angular_rad_per_s"], position)
    travelled, _ = quad(lambda t: np.exp(-t / p["settling_s"][0]), 0, time, epsabs=0, epsrel=1e-13, limit=200)
    return np.asarray(position + velocity * travelled)


def _creep(rng: np.random.Generator) -> dict[str, Floats]:
    return {
        "linear_m_per_s": rng.normal(size=3) * 3e-8,
        "angular_rad_per_s": rng.normal(size=3) * 2e-8,
        "settling_s": np.exp(rng.uniform(np.log(300), np.log(1e7), 1)),
    }


def _acting(shown: Floats, to_tool: Floats, p: Numbers) -> Floats:
    """What acts, by matrices of the sensor: rows of its force and moment axes in the axes of what is shown."""
    axes = to_tool if p["in_tool_axes"][0] == 1 else np.eye(3)
    e = p["misalignment_rad"]
    askew = np.array([[1, -e[2], e[1]], [e[2], 1, -e[0]], [-e[1], e[0], 1]])
    both = np.kron(np.eye(2), axes)
    gain = np.diag(1 + p["scale"]) @ np.kron(np.eye(2), askew)
    return np.asarray(both.T @ (gain @ both @ shown - np.r_[p["force_n"], p["moment_nm"]]))


def _sensor(rng: np.random.Generator) -> dict[str, Floats]:
    return {
        "force_n": rng.normal(size=3) * 8,
        "moment_nm": rng.normal(size=3) * 2,
        "scale": rng.normal(size=6) * 0.03,
        "misalignment_rad": rng.normal(size=3) * 0.03,
        "in_tool_axes": rng.integers(0, 2, 1).astype(float),
    }


INSTRUMENTS: dict[str, Oracle] = {
    "tracker-drift": Oracle(
        position_reading=_crept, nothing={"linear_m_per_s": 0.0, "angular_rad_per_s": 0.0}, sample=_creep
    ),
    "force-sensor-bias": Oracle(
        wrench_reading=_acting,
        nothing={"force_n": 0.0, "moment_nm": 0.0, "scale": 0.0, "misalignment_rad": 0.0},
        sample=_sensor,
    ),
}
