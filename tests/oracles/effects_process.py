"""Effects of the process, in plain numpy: a cut that pushes harder, a cutter that is smaller."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.oracles.oracle import Numbers, Oracle

Floats = npt.NDArray[np.float64]


def _harder(said: Floats, to_path: Floats, p: Numbers) -> Floats:
    """Component by component along the three unit vectors of the path."""
    out = np.zeros(6)
    for direction, change in zip(to_path, p["change"], strict=True):
        out[:3] += (1 + change) * (said[:3] @ direction) * direction
        out[3:] += (1 + change) * (said[3:] @ direction) * direction
    return out


PROCESS: dict[str, Oracle] = {
    "cutting-force": Oracle(
        process_wrench=_harder, nothing={"change": 0.0}, sample=lambda rng: {"change": rng.normal(size=3) * 0.2 + 0.3}
    ),
    "cutter-size": Oracle(
        surface_reading=lambda deviation, p: deviation + float(p["radius_m"][0]),
        nothing={"radius_m": 0.0},
        sample=lambda rng: {"radius_m": rng.normal(size=1) * 2e-5},
    ),
}
