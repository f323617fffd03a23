"""What `trace` found, for scripts."""

from __future__ import annotations

from typing import Any

import numpy as np

from compensator.devices.order import FREE, TraceOrder
from compensator.devices.readings import BALLBAR, SURFACE
from compensator.devices.samples import SampleTable


def trace_report(device: str, samples: SampleTable, order: TraceOrder, *, read: int, to_mm: float) -> dict[str, Any]:
    """Without its findings; ``read``: readings in the file, ``to_mm``: mm in its unit of length."""
    columns = samples.columns
    return {
        "device": device,
        "kind": samples.kind,
        "n_read": read,
        "n_samples": len(samples),
        "n_runs": samples.runs,
        "mm_per_unit": to_mm,
        "registered": None if samples.kind == BALLBAR else order.frame != FREE,
        "columns": list(columns),
        "duration_s": round(float(np.ptp(columns["time"])), 6) if "time" in columns else None,
        "deviation_mm": _deviation(columns["deviation"]) if samples.kind == SURFACE else None,
    }


def _deviation(values: np.ndarray) -> dict[str, float]:
    size = np.abs(values)
    rms = float(np.sqrt(np.mean(values**2)))
    found = {"mean": float(values.mean()), "rms": rms, "p95": float(np.percentile(size, 95)), "max": float(size.max())}
    return {key: round(value, 9) for key, value in found.items()}
