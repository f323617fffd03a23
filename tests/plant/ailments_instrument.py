"""What can be wrong with the instruments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .ailment import Ailment
from .arm import Arm
from .instruments import Crooked, Wandering
from .wear import Wear

Done = tuple[Wear, Mapping[str, float]]
DAY = 8000.0  # s


def tracker(settling: float = np.inf) -> Ailment:
    """The measuring frame creeps and turns at constant rates, or settles."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        if wear.tracker is not None:
            raise ValueError("one cell has one tracker")
        speed, rate = np.array([6.0, -4.0, 3.0]) * 1e-5 * s / DAY, np.array([0.5, 0.3, 1.5]) * 1e-5 * s / DAY
        about = np.array([3.0, -1.0, 0.2])
        values = {f"v{c} tracker m/s": v for c, v in zip("xyz", speed.tolist(), strict=True)}
        values |= {f"w{c} tracker rad/s": v for c, v in zip("xyz", rate.tolist(), strict=True)}
        return replace(wear, tracker=Wandering(speed, rate, about, settling)), values

    how = "in proportion to time" if np.isinf(settling) else f"settling with {settling:g} s"
    law = f"shown points creep and turn about the tracker's stand, {how}"
    return Ailment("tracker-drift", ("tracker",), law, apply)


def sensor(kind: str = "zero") -> Ailment:
    """A force sensor with a zero shift, or with scale errors and a turned mount."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        if wear.sensor is not None:
            raise ValueError("one cell has one force sensor")
        unit = s * float(wear.stiffness[1]) * 1e-5  # N
        if kind == "zero":
            zero = unit * np.array([1.0, -0.6, 0.8, 0.1, 0.15, -0.1])
            values = {f"zero {c} force-sensor": v for c, v in zip(_NAMES, zero.tolist(), strict=True)}
            return replace(wear, sensor=Crooked(zero=zero)), values
        scale, tilt = 0.02 * s * np.array([1.0, -0.7, 0.5, 1.0, 0.6, -0.8]), 0.02 * s * np.array([0.6, -1.0, 0.8])
        values = {f"scale {c} force-sensor 1": v for c, v in zip(_NAMES, scale.tolist(), strict=True)}
        values |= {f"tilt {c} force-sensor rad": v for c, v in zip("xyz", tilt.tolist(), strict=True)}
        return replace(wear, sensor=Crooked(scale=scale, tilt=tilt)), values

    law = {"zero": "shown = acting + constants in tool axes", "scale": "shown = (1 + e) x turned wrench, tool axes"}
    return Ailment("force-sensor-bias", ("force-sensor",), law[kind], apply)


_NAMES = ("fx", "fy", "fz", "mx", "my", "mz")
