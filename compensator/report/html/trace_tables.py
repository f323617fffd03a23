"""The tables of traces on a page: the measurement itself, the circles of a ball-bar, the stretches of a part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from compensator.report.html.table import DASH, PageTable
from compensator.report.json.text import MM, Report
from compensator.report.words.numbers import residual_mm
from compensator.report.words.trace import circle_words, placed_words
from stiffness.identification.session_fit import SessionFit

Floats = npt.NDArray[np.float64]

LISTED = 60  # turning points


def traced(report: Report) -> dict[str, PageTable]:
    """The tables of what a report has; {} where there is no trace."""
    if "traces" not in report:
        return {}
    out = {"measured": measured(report)}
    return {**out, "circles": circles(report), "reversals": reversals(report)} if "iso230_4" in report else out


def measured(report: Report) -> PageTable:
    """Every trace: its kind, how many readings took part, and what was estimated of the measurement."""
    rows = [
        [t["trace"], t["kind"] + (", dry" if t["dry"] else ""), f"{t['n_used']:,} of {t['n_samples']:,}",
         placed_words(t) or "nothing", " ".join(t["notes"])]
        for t in report["traces"]
    ]  # fmt: skip
    return PageTable(rows, ["trace", "kind", "readings used", "estimated of the measurement", "notes"])


def circles(report: Report) -> PageTable:
    """ISO 230-4, measured and predicted by the model at hand and by the one that stands at the end."""
    rows = []
    for c in report["iso230_4"]:
        by = c["predicted"]
        shown = (("measured", c), ("model at hand", by["before"]), ("refined model", by["after"]))
        for k, (who, n) in enumerate(shown):
            F = n["radial_error"]
            numbers = [
                n["circular_error"]["clockwise"], n["circular_error"]["counter_clockwise"],
                n["bidirectional_circular_error"], n["mean_bidirectional_radial_error"], F["max"], F["min"],
            ]  # fmt: skip
            rows.append(["" if k else circle_words(c), who, *(DASH if v is None else residual_mm(v) for v in numbers)])
    head = ["circle", "", "G clockwise", "G counter-clockwise", "G(b) bidirectional", "M mean", "F max", "F min"]
    return PageTable(rows, head, right=range(2, 8), caption="Circular, bidirectional and radial errors, mm (ISO 230-4)")


def reversals(report: Report) -> PageTable:
    """Where joints turn, and what that does to the radius; the largest first."""
    found = [(abs(r["step_mm"]), circle_words(c), r) for c in report["iso230_4"] for r in c["reversals"]]
    rows = [
        [r["joint"], f"{r['joint_deg']:.1f}", where, f"{r['at_deg']:.0f}", f"{1e3 * r['step_mm']:.1f}",
         f"{1e3 * r['predicted_mm']:.1f}"]
        for _, where, r in sorted(found, key=lambda f: -f[0])[:LISTED]
    ]  # fmt: skip
    head = ["joint", "its angle, deg", "circle", "at, deg", "step measured, um", "step predicted, um"]
    most = f": the {LISTED} largest of {len(found):,}" if len(found) > LISTED else ""
    caption = f"Reversals of joints, and the step of the radius there{most}"
    return PageTable(rows, head, right=(1, 3, 4, 5), caption=caption)


def stretches(fits: Sequence[SessionFit], before: Sequence[SessionFit]) -> PageTable:
    """Deviations of parts, stretch by stretch of the path: measured, and what models leave of them."""
    rows = []
    for fit, old in zip(fits, before, strict=True):
        path = fit.session.path
        if path is None or path.kind != "surface":
            continue
        read = fit.samples.position[:, 0]
        left = [s.samples.position[:, 0] - s.predicted.position[:, 0] for s in (old, fit)]
        for k in np.unique(path.stretch):
            mine = (path.stretch == k) & fit.used
            if mine.any():
                ends = f"{MM * path.length[mine].min():.0f} to {MM * path.length[mine].max():.0f}"
                some = [residual_mm(MM * float(np.sqrt(np.mean(v[mine] ** 2)))) for v in (read, *left)]
                rows.append([fit.session.source, ends, f"{mine.sum()}", f"{MM * read[mine].mean():.4f}", *some])
    head = ["trace", "along the path, mm", "points", "mean deviation, mm", "RMS measured, mm",
            "left by the model at hand", "by the refined model"]  # fmt: skip
    return PageTable(rows, head, right=range(1, 7), caption="Deviations of the part, stretch by stretch")
