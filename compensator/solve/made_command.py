"""MadeCommand: commands of a path, without the angles that the path has anyway."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from stiffness.poses import Poses
from stiffness.statics.prediction import Command
from toolpaths.columns import made_from

Floats = npt.NDArray[np.float64]


class MadeCommand(Command):
    """As Command; ``q`` and ``actual`` are given, or what makes them where they are asked for."""

    _q: Floats | Callable[[], Floats]
    _actual: Floats | Callable[[], Floats]

    def __init__(
        self,
        *,
        q: Floats | Callable[[], Floats],
        actual: Floats | Callable[[], Floats],
        torque: Floats,
        nominal: Callable[[Floats], Poses],
        error: Floats,
        extra: Floats,
        steps: int,
    ) -> None:
        self.__dict__.update(
            _q=q, _actual=actual, torque=torque, nominal=nominal, error=error, extra=extra, steps=steps
        )

    @property
    def q(self) -> Floats:
        """(N, n) rad to command."""
        return self._q() if callable(self._q) else self._q

    @property
    def actual(self) -> Floats:
        """(N, n) rad where the joints then stand."""
        return self._actual() if callable(self._actual) else self._actual

    def sharing(self, nominal: Floats) -> MadeCommand:
        """The same, of whose actual angles those are kept that are not the ``nominal`` ones (N, n) of the path."""
        return MadeCommand(
            q=self._q, actual=made_from(lambda: nominal, self.actual), torque=self.torque, nominal=self.nominal,
            error=self.error, extra=self.extra, steps=self.steps,
        )  # fmt: skip
