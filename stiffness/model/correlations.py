"""Correlations between the numbers of a model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Correlations:
    """``names`` (``effect.parameter[joint]``) and the ``matrix`` (P, P) of their correlations."""

    names: tuple[str, ...]
    matrix: Floats

    @classmethod
    def of(cls, names: tuple[str, ...], covariance: Floats) -> Correlations:
        """From a covariance matrix, rounded to what a reader can use."""
        sd = np.sqrt(np.diag(covariance))
        matrix = np.round(covariance / np.outer(sd, sd), 6)
        np.fill_diagonal(matrix, 1.0)
        return cls(names, matrix)

    def table(self) -> dict[str, Any]:
        """As in the file."""
        return {"names": list(self.names), "matrix": self.matrix.tolist()}
