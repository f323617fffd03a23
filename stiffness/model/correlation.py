"""Correlations of a model's parameters, as they stand in a model file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stiffness.errors import ModelError

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


def read_correlations(name: str, table: Any, known: Mapping[str, int]) -> Correlations | None:
    """The [correlations] of a model file; ``known``: effect.parameter -> how many numbers it has.

    Raises:
        ModelError: names the key and what was expected.
    """
    if table is None:
        return None
    if not isinstance(table, dict) or set(table) != {"names", "matrix"}:
        raise ModelError(f"{name}: correlations: expected the keys names and matrix")
    names = table["names"]
    if not isinstance(names, list) or not all(isinstance(n, str) for n in names) or len(set(names)) != len(names):
        raise ModelError(f"{name}: correlations.names: expected names as joint-stiffness.k_nm_per_rad[1], once each")
    for n in names:
        parameter, _, index = n.removesuffix("]").partition("[")
        if not (index.isdigit() and 1 <= int(index) <= known.get(parameter, 0)):
            raise ModelError(f"{name}: correlations.names: {n!r} is no number of this model")
    try:
        matrix = np.array(table["matrix"], dtype=float)
    except (TypeError, ValueError) as e:
        raise ModelError(f"{name}: correlations.matrix: expected rows of numbers: {e}") from e
    proper = matrix.shape == (len(names), len(names)) and np.all(np.isfinite(matrix))
    if not (proper and np.array_equal(matrix, matrix.T) and np.all(abs(matrix) <= 1) and np.all(np.diag(matrix) == 1)):
        raise ModelError(
            f"{name}: correlations.matrix: expected {len(names)} x {len(names)} numbers, symmetric, between -1 and 1, "
            "with 1 on the diagonal"
        )
    matrix.setflags(write=False)
    return Correlations(tuple(names), matrix)
