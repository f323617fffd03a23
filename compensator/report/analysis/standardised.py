"""Standardised residuals of a fit: where the model holds they are normally distributed with standard deviation 1."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]


def standardised(fit: Fit) -> Floats:
    """Residuals made independent of each other and divided by the noise that the instruments state.

    The number that carries the free offset of a reflector in its set-up is no residual: it is left out.
    """
    out = []
    at = len(fit.unknowns)
    for k, e in enumerate(fit.evidence):
        columns = slice(at, at + e.station.size)
        for block in e.blocks(fit.parameters, fit.station(k), fit.offset, columns=columns, width=columns.stop):
            out.append(block.residual[np.diag(block.factor) < 0.5 * fit.offset] if fit.offset else block.residual)
        at = columns.stop
    return np.concatenate(out) if out else np.empty(0)
