"""What a deflection is made of: the share of every cause, and their interaction, which is left over."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from stiffness.statics.predictor import Predictor

Floats = npt.NDArray[np.float64]

_BLOCK = 65536  # poses at a time, so that memory stays small


@dataclass(frozen=True, repr=False)
class DeflectionShares:
    """Shares of the deflection of the TCP, (N, 3) m each, base axes; they add up to it.

    Attributes:
        gravity: weight of arm and tool alone, and the springs that hold it; less what the controller takes off.
        process: the wrench alone.
        joint_state: what gaps, softer flanks and windup add to all others together.
        offsets: what is there without load, at the model's reference temperature.
        temperature: what the difference to it adds to the offsets.
        interaction: what is left over: loads bend an arm that others have bent already.
    """

    gravity: Floats
    process: Floats
    joint_state: Floats
    offsets: Floats
    temperature: Floats
    interaction: Floats

    def __repr__(self) -> str:
        return f"DeflectionShares({len(self.gravity)} poses)"

    @property
    def total(self) -> Floats:
        """(N, 3) m."""
        return np.asarray(sum(getattr(self, f.name) for f in fields(self)))


def shares_of(predictor: Predictor, q: Floats, wrench: Floats, actual: Floats) -> DeflectionShares:
    """Shares of the deflection at commands.

    Args:
        q: (N, n) rad. wrench: (N, 6), as in ``Predictor.forward``.
        actual: (N, 3) m, the TCP that it predicts there.

    Raises:
        EquilibriumError: the arm is too soft for a load.
    """
    calm = predictor.without(memory=True) if predictor.statics.n_state else predictor
    light = calm.without(weight=True, heat=True)
    warm = calm.without(weight=True) if predictor.temperature else light
    heavy = calm.without(heat=True) if predictor.temperature else calm
    none, no_state = np.zeros(6), np.zeros(0)

    def at(arm: Predictor, load: Floats) -> Floats:
        out = np.empty((len(q), 3))
        for first in range(0, len(q), _BLOCK):
            b = slice(first, first + _BLOCK)
            out[b] = arm.forward(q[b], load if load.ndim == 1 else load[b], no_state).position
        return out

    nominal = predictor.nominal(q).origin
    rest = at(light, none) if any(e.unloaded for e in light.effects) else nominal
    gravity, process = at(heavy, none) - rest, at(light, wrench) - rest
    temperature = at(warm, none) - rest if predictor.temperature else np.zeros_like(rest)
    loaded = at(calm, wrench) if predictor.statics.n_state else actual
    offsets = rest - nominal
    return DeflectionShares(
        gravity=gravity,
        process=process,
        joint_state=actual - loaded,
        offsets=offsets,
        temperature=temperature,
        interaction=loaded - nominal - offsets - gravity - process - temperature,
    )
