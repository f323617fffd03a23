"""Results of a Predictor: the poses of a commanded path, the commands of a wanted one, and start values for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

TOLERANCE = 1e-11  # m and rad, of a solved pose; two digits below what is promised


@dataclass(frozen=True, repr=False)
class Prediction:
    """Where a commanded path really goes: TCP ``rotation`` (N, 3, 3) and ``position`` (N, 3) in the base,
    ``torque`` (N, n) of gravity and environment, ``residual`` (N,) of the equilibrium."""

    rotation: Floats
    position: Floats
    torque: Floats
    residual: Floats


@dataclass(frozen=True, repr=False)
class StartValues:
    """Where a solve begins: (N, n) command, (N, n) actual angles, (N, k) further elastic coordinates."""

    q: Floats
    actual: Floats
    extra: Floats


COLUMNS = ("q", "actual", "torque", "rotation", "position", "error", "extra")  # of a Command, a row per pose


@dataclass(frozen=True, repr=False)
class Command:
    """Commands for wanted TCP poses.

    Attributes:
        q: (N, n) rad to command.
        actual: (N, n) rad where the joints then stand.
        torque: (N, n) N*m.
        rotation, position: nominal TCP pose of the command, base: what a program prints.
        error: (N,) m and rad, what is left.
        extra: (N, k) elastic coordinates beyond the joints, and those of the sag.
        steps: Newton steps needed.
    """

    q: Floats
    actual: Floats
    torque: Floats
    rotation: Floats
    position: Floats
    error: Floats
    extra: Floats
    steps: int

    def replaced(self, rows: npt.NDArray[np.intp], part: Command) -> Command:
        """The same with other solutions at some poses."""
        arrays = {name: getattr(self, name).copy() for name in COLUMNS}
        for name, array in arrays.items():
            array[rows] = getattr(part, name)
        return Command(**arrays, steps=max(self.steps, part.steps))

    @property
    def converged(self) -> npt.NDArray[np.bool_]:
        """Where the deflected pose equals the wanted one to TOLERANCE."""
        return np.asarray(self.error <= TOLERANCE)
