"""What the terminal shows of a fit, and of the evaluation of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from compensator.report.words.trace import trace_sentences
from compensator.terminal.screen import print_notes, print_written, screen, table

if TYPE_CHECKING:  # the libraries of a fit take half a second to import
    from compensator.tasks.identify import Identified


def show_fit(done: Identified) -> None:
    """Parameters, residuals and what the data do not determine."""
    console, report = screen(), done.report
    if console is None:
        return
    title = f"{report['n_readings']} readings, effects {', '.join(report['effects'])}"
    stiffness = table("joint", "stiffness, N*m/rad", "standard deviation", right=range(3), title=title)
    columns = (report["stiffness_nm_per_rad"], report["stiffness_sd_nm_per_rad"])
    for k, (value, sd) in enumerate(zip(*columns, strict=True)):
        stiffness.add_row(str(k + 1), *stiffness_cells(value, sd))
    console.print(stiffness)
    for kind, rms in report["rms_mm"].items():
        if rms:
            console.print(
                f"{kind}: {rms['rigid']:.4f} mm rigid, {rms['fitted']:.4f} mm fitted, noise {rms['noise_floor']:.4f} mm"
            )
    for sentence in trace_sentences(report):
        console.print(sentence)
    if report["outlier_rows"]:
        rows = ", ".join(str(r["row"]) for r in report["outlier_rows"][:20])
        console.print(f"left out, contradicted by all others: {len(report['outlier_rows'])} rows ({rows})")
    print_notes(console, (*report["notes"], *report["not_identified"]))
    print_written(console, done.files)


def stiffness_cells(value: float | None, sd: float | None) -> tuple[str, str]:
    """A stiffness and its standard deviation, or that it is not identified."""
    return ("not identified", "") if value is None else (f"{value:.4g}", f"{sd:.2g}")


def show_evaluation(report: dict[str, Any]) -> None:
    """One line per kind of reading."""
    console = screen()
    if console is None:
        return
    for kind in ("displacement", "absolute", "path"):
        score = report[kind]
        if score is None:
            if kind != "path":
                console.print(f"{kind}: no such evidence")
            continue
        console.print(
            f"{kind}: rms {score['rms_mm']:.4f} mm per axis (noise {score['noise_floor_mm']:.4f}), "
            f"95 % {score['p95_mm']:.4f} mm, max {score['max_mm']:.4f} mm"
        )
        if wrong := report.get("outlier_rows"):
            every = report["with_outliers"][kind]
            console.print(f"  with {len(wrong)} wrong rows: rms {every['rms_mm']:.4f} mm, max {every['max_mm']:.4f} mm")
    for sentence in trace_sentences(report):
        console.print(sentence)
