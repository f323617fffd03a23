"""The figure of a part that was measured: deviations as arrows on it, as they were read and as models predict them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.report.figures.layout import AFTER, BEFORE, FONT, INK, Figure, heading, number
from compensator.report.figures.thinning import numbers
from stiffness.identification.session_fit import SessionFit

Floats = npt.NDArray[np.float64]

MOST = 1500  # arrows of a panel
LONGEST = 0.12  # of the size of the part: the longest arrow but for one in twenty
PART = "#b9c4cd"


def has_surface(fits: Sequence[SessionFit]) -> bool:
    """Whether there is something to draw."""
    return any(f.session.path is not None and f.session.path.kind == "surface" for f in fits)


def enlarged_by(fits: Sequence[SessionFit]) -> float:
    """How many times arrows are longer than deviations: 1, 2 or 5 times a power of ten."""
    point, _, values = _of(fits, fits)
    size = max(float(np.ptp(point, axis=0).max()), 1e-3)
    wanted = LONGEST * size / max(float(np.percentile(np.abs(values[0]), 95)), 1e-9)
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * max(f for f in (1.0, 2.0, 5.0) if f * power <= wanted * 1.000001))


def part_figure(fits: Sequence[SessionFit], before: Sequence[SessionFit], *, refined: bool) -> Figure:
    """Beside each other: measured, predicted by the model at hand and, where it is ``refined``, by that one."""
    point, normal, values = _of(fits, before)
    scale = enlarged_by(fits)
    some = np.unique(np.linspace(0, len(point) - 1, min(MOST, len(point))).astype(int))
    panels = [("measured", INK), ("predicted: the model at hand", BEFORE), ("predicted: the refined model", AFTER)]
    panels = panels if refined else panels[:2]
    tips = [point + scale * v[:, None] * normal for v in values]
    low, high = (f(np.vstack([point, *tips]), axis=0) for f in (np.min, np.max))
    span = np.maximum(high - low, 0.05 * float((high - low).max()))
    layout: Figure = {
        "font": FONT, "height": 420, "margin": {"l": 0, "r": 0, "t": 40, "b": 0}, "showlegend": False,
        "annotations": [],
    }  # fmt: skip
    data: list[Figure] = []
    for k, (name, colour) in enumerate(panels):
        across = [k / len(panels) + 0.005, (k + 1) / len(panels) - 0.005]
        lines = np.full((3 * len(some), 3), np.nan)
        lines[0::3], lines[1::3] = point[some], tips[k][some]
        data += [
            {**_line(point, PART, 2), "scene": f"scene{number(k)}"},
            {**_line(lines, colour, 3), "scene": f"scene{number(k)}"},
        ]
        layout[f"scene{number(k)}"] = {
            "domain": {"x": across, "y": [0, 1]}, "aspectmode": "manual",
            "aspectratio": {a: float(s / span.max()) * 1.3 for a, s in zip("xyz", span, strict=True)},
            "camera": {"eye": {"x": -0.4, "y": -0.9, "z": 1.4}},
            **{f"{a}axis": {"title": {"text": f"{a}, m"}, "range": [float(m - s / 2), float(m + s / 2)]}
               for a, m, s in zip("xyz", (low + high) / 2, 1.05 * span, strict=True)},
        }  # fmt: skip
        layout["annotations"].append(heading(name, sum(across) / 2, above=True))
    return {"data": data, "layout": layout}


def _of(fits: Sequence[SessionFit], before: Sequence[SessionFit]) -> tuple[Floats, Floats, list[Floats]]:
    """Points (N, 3) m and normals (N, 3) in the base; deviations (N,) m read, and predicted before and after."""
    pairs = [(f, b) for f, b in zip(fits, before, strict=True) if has_surface([f])]
    paths = [f.session.path for f, _ in pairs if f.session.path is not None]
    read, old, new = (
        np.concatenate(v)
        for v in zip(
            *(
                (f.samples.position[:, 0], b.predicted.position[:, 0], f.predicted.position[:, 0])
                for f, b in pairs
            ),
            strict=True,
        )
    )
    return np.concatenate([p.point for p in paths]), np.concatenate([p.normal for p in paths]), [read, old, new]


def _line(at: Floats, colour: str, width: int) -> Figure:
    return {
        "type": "scatter3d", "mode": "lines", **{a: numbers(c, 6) for a, c in zip("xyz", at.T, strict=True)},
        "hoverinfo": "skip", "line": {"width": width, "color": colour},
    }  # fmt: skip
