"""The JSON report of ``cutting``."""

from __future__ import annotations

import numpy as np

from compensator.process.milling.force_fit import ForceFit
from compensator.process.milling.material import NAMES, SI
from compensator.report.json.text import Report

QUANTILE = 1.959964  # of the normal distribution: 95 % lie within


def cutting_report(fit: ForceFit) -> Report:
    """Coefficients in N/mm2 and N/mm with standard deviations and 95 % intervals; null where not determined."""
    values, sd = fit.coefficients / SI, fit.sd / SI
    known = np.isfinite(values)
    return {
        "coefficients": {n: _number(v, k) for n, v, k in zip(NAMES, values, known, strict=True)},
        "sd": {n: _number(v, k) for n, v, k in zip(NAMES, sd, known, strict=True)},
        "interval95": {
            n: [float(v - QUANTILE * s), float(v + QUANTILE * s)] if k else None
            for n, v, s, k in zip(NAMES, values, sd, known, strict=True)
        },
        "undetermined": [{"name": name, "why": why} for name, why in fit.undetermined.items()],
        "condition": fit.condition,
        "rms_n": fit.rms.get("N"),
        "rms_w": fit.rms.get("W"),
        "n_readings": fit.count,
    }


def _number(value: float, known: bool) -> float | None:
    return float(value) if known else None
