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
    for s in fit.sessions:
        offset = s.observations.weighting.offset
        for block in s.blocks():
            out.append(block.residual[np.diag(block.factor) < 0.5 * offset] if offset else block.residual)
    return np.concatenate(out) if out else np.empty(0)
