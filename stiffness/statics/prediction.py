"""Results of a Predictor: the poses of a commanded path, the commands of a wanted one, and start values for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stiffness.poses import Poses

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

    def replaced(self, rows: npt.NDArray[np.intp], part: Prediction) -> Prediction:
        """The same with other equilibria at some poses."""
        return Prediction(**_replaced(self, PREDICTED, rows, part))



@dataclass(frozen=True, repr=False)
class StartValues:
    """Where a solve begins: (N, n) command, (N, n) actual angles, (N, k) further elastic coordinates."""

    q: Floats
    actual: Floats
    extra: Floats


PREDICTED = ("rotation", "position", "torque", "residual")  # columns of a Prediction, a row per pose
COLUMNS = ("q", "actual", "torque", "error", "extra")  # of a Command, a row per pose


@dataclass(frozen=True, repr=False)
class Command:
    """Commands for wanted TCP poses.

    Attributes:
        q: (N, n) rad to command.
        actual: (N, n) rad where the joints then stand.
        torque: (N, n) N*m.
        nominal: commands of all poses (N, n) rad -> nominal TCP poses (N), base.
        error: (N,) m and rad, what is left.
        extra: (N, k) elastic coordinates beyond the joints, and those of the sag.
        steps: Newton steps needed.
    """

    q: Floats
    actual: Floats
    torque: Floats
    nominal: Callable[[Floats], Poses]
    error: Floats
    extra: Floats
    steps: int

    @property
    def printed(self) -> Poses:
        """(N) nominal TCP poses of the commands, base: what a program prints."""
        return self.nominal(self.q)

    @property
    def rotation(self) -> Floats:
        """(N, 3, 3) of ``printed``."""
        return self.printed.rotation

    @property
    def position(self) -> Floats:
        """(N, 3) m of ``printed``."""
        return self.printed.origin

    def replaced(self, rows: npt.NDArray[np.intp], part: Command) -> Command:
        """The same with other solutions at some poses."""
        return Command(**_replaced(self, COLUMNS, rows, part), nominal=self.nominal, steps=max(self.steps, part.steps))

    @property
    def converged(self) -> npt.NDArray[np.bool_]:
        """Where the deflected pose equals the wanted one to TOLERANCE."""
        return np.asarray(self.error <= TOLERANCE)


def _replaced(whole: object, names: Sequence[str], rows: npt.NDArray[np.intp], part: object) -> dict[str, Floats]:
    arrays = {name: getattr(whole, name).copy() for name in names}
    for name, array in arrays.items():
        array[rows] = getattr(part, name)
    return arrays


class PathColumns:
    """Some columns of the predictions or commands of a path, put together piece by piece: no piece is kept.

    Args:
        rows: of the path. names: of the columns.
    """

    def __init__(self, rows: int, names: Sequence[str]) -> None:
        self.rows, self.names = rows, tuple(names)
        self._whole: dict[str, Floats] = {}

    def __repr__(self) -> str:
        return f"PathColumns({self.rows} rows, {', '.join(self.names)})"

    def put(self, rows: npt.NDArray[np.intp], piece: Prediction | Command) -> None:
        """The rows of a piece, which follow each other."""
        for name in self.names:
            values = getattr(piece, name)
            if len(rows) == self.rows:
                self._whole[name] = values
            elif len(rows):
                whole = self._whole.setdefault(name, np.empty((self.rows, *values.shape[1:])))
                whole[rows[0] : rows[-1] + 1] = values

    @property
    def whole(self) -> Mapping[str, Floats]:
        """Name -> (N, ...) of all pieces."""
        return self._whole
