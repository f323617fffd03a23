"""Ailments that no catalogue has. `where`: the joint that moves first, then what it follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from .ailment import Ailment, only
from .ailments_joint import with_law
from .arm import Arm
from .wear import Situation, Wear

Done = tuple[Wear, Mapping[str, float]]


def _turning(
    k: int, further: tuple[str, ...], law: str, unit: str, angle: Callable[[Situation, float], float]
) -> Ailment:
    """Joint k turns by s x angle(situation, its stiffness)."""

    def apply(wear: Wear, arm: Arm, s: float) -> Done:
        stiff = float(wear.stiffness[k - 1])
        worn = with_law(wear, lambda at: only(arm.n, k, s * angle(at, stiff)))
        return worn, {f"amplitude joint-{k} {unit}": s}

    return Ailment("unknown", (f"joint-{k}", *further), law, apply)


def crossed(k: int = 3, other: int = 2) -> Ailment:
    """A joint that is softer where another joint stands elsewhere."""
    law = f"joint {k} turns by s torque_{k} sin(2 q_{other}) / K"
    return _turning(
        k, (f"joint-{other}",), law, "1", lambda at, K: at.torque[k - 1] * np.sin(2 * at.angle[other - 1]) / K
    )


def brake(k: int = 2) -> Ailment:
    """A brake that pulls its joint aside when it closes."""
    law = f"joint {k} turns by s x 0.1 mrad while column brake is 1"
    return _turning(k, ("column:brake",), law, "1e-4 rad", lambda at, K: 1e-4 * at.moment.columns.get("brake", 0.0))


def spindle(k: int = 5) -> Ailment:
    """A spindle whose heat bends the wrist, in proportion to the speed squared."""
    law = f"joint {k} turns by s x 0.1 mrad (spindle / 12000 rpm)^2"
    return _turning(
        k,
        ("column:spindle",),
        law,
        "1e-4 rad",
        lambda at, K: 1e-4 * (at.moment.columns.get("spindle", 0.0) / 12000) ** 2,
    )


def ripple(k: int = 3, order: int = 3) -> Ailment:
    """A gear or encoder that errs periodically."""
    law = f"joint {k} turns by s x 0.1 mrad sin({order} q_{k} + 0.4)"
    return _turning(k, (), law, "1e-4 rad", lambda at, K: 1e-4 * np.sin(order * at.command[k - 1] + 0.4))


def hose(k: int = 4) -> Ailment:
    """A hose that drags at the wrist: it pulls back by the sum of two angles, and by the way they last turned."""

    def angle(at: Situation, K: float) -> float:
        twist = at.angle[k - 1] + at.angle[k]
        pull = np.tanh(twist / 0.8) + 0.4 * np.sign(at.direction[k - 1] + at.direction[k])
        return float(-1e-4 * pull)

    law = f"torque s x 0.1 mrad K on joint {k}, against tanh((q_{k}+q_{k + 1})/0.8) and against the last rotation"
    return _turning(k, (f"joint-{k + 1}",), law, "1e-4 rad", angle)


def tiring(k: int = 3, hours: float = 2.5) -> Ailment:
    """A joint that softens as the day goes on."""
    law = f"joint {k} turns by s torque / K x (time / {hours:g} h)"
    return _turning(k, ("time",), law, "1", lambda at, K: at.torque[k - 1] / K * at.moment.time / (3600 * hours))


UNKNOWN: Mapping[str, Callable[[], Ailment]] = {
    "crossed": crossed,
    "brake": brake,
    "spindle": spindle,
    "ripple": ripple,
    "hose": hose,
    "tiring": tiring,
}
