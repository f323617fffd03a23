"""What a deflection is made of: the share of every cause, and their interaction, which is left over."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from stiffness.statics.predictor import Predictor

Floats = npt.NDArray[np.float64]


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
    """Shares of the deflection at commands; see ``ShareFinder.of``."""
    return ShareFinder(predictor).of(q, wrench, actual)


class ShareFinder:
    """Finds the shares of the deflection of one arm.

    Args:
        predictor: of the arm.
    """

    def __init__(self, predictor: Predictor) -> None:
        self.predictor = predictor
        self._calm = predictor.without(memory=True) if predictor.statics.n_state else predictor
        self._light = self._calm.without(weight=True, heat=True)
        self._warm = self._calm.without(weight=True) if predictor.temperature else self._light
        self._heavy = self._calm.without(heat=True) if predictor.temperature else self._calm

    def __repr__(self) -> str:
        return f"ShareFinder({self.predictor!r})"

    def of(self, q: Floats, wrench: Floats, actual: Floats) -> DeflectionShares:
        """Shares of the deflection at commands.

        Args:
            q: (N, n) rad. wrench: (N, 6), as in ``Predictor.forward``.
            actual: (N, 3) m, the TCP that the predictor predicts there.

        Raises:
            EquilibriumError: the arm is too soft for a load.
        """
        none, predictor, light = np.zeros(6), self.predictor, self._light
        nominal = predictor.nominal(q).origin
        rest = _at(light, q, none) if any(e.unloaded for e in light.effects) else nominal
        gravity, process = _at(self._heavy, q, none) - rest, _at(light, q, wrench) - rest
        nothing = np.broadcast_to(0.0, rest.shape)  # a million poses of zeros are 24 MB
        temperature = _at(self._warm, q, none) - rest if predictor.temperature else nothing
        loaded = _at(self._calm, q, wrench) if predictor.statics.n_state else actual
        offsets = nothing if rest is nominal else rest - nominal
        return DeflectionShares(
            gravity=gravity,
            process=process,
            joint_state=nothing if loaded is actual else actual - loaded,
            offsets=offsets,
            temperature=temperature,
            interaction=loaded - nominal - offsets - gravity - process - temperature,
        )


def _at(arm: Predictor, q: Floats, load: Floats) -> Floats:
    """(N, 3) m where the TCP stands under a wrench (N, 6) or (6,)."""
    return arm.forward(q, load, np.zeros(0)).position
