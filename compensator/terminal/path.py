"""What the terminal shows of a compensated or previewed path."""

from __future__ import annotations

from rich.text import Text

from compensator.tasks.compensate import Done
from compensator.terminal.screen import print_notes, print_written, screen, table


def show_path(done: Done) -> None:
    """Table of the numbers, files, what the result does not know."""
    console, report, result = screen(), done.report, done.result
    if console is None:
        return
    console.print(
        Text(result.path.toolpath.source, "bold"),
        f"on {result.job.arm.robot.name}: {report['n_poses']} poses, {report['n_cut']} cutting, {report['seconds']} s",
    )
    errors = table("", "mean", "95 %", "max", right=range(1, 4), title="predicted TCP error, mm")
    error = report["predicted_error_mm"]
    for name, key in (("uncompensated", "before"), ("program as written", "after")):
        if key == "before" or report["max_correction_mm"] > 0:
            errors.add_row(name, *(f"{error[key][s]:.4f}" for s in ("mean", "p95", "max")))
    console.print(errors)
    console.print(_sentence(done), highlight=False)
    print_notes(console, map(str, done.findings))
    if report["not_applied"]:
        console.print(f"  - not applied (other tool or instruments): {', '.join(report['not_applied'])}")
    print_written(console, done.files)


def _sentence(done: Done) -> str:
    r = done.report
    turned: dict[str, int] = {}
    for t in r["reversals"]:
        turned[t["where"]] = turned.get(t["where"], 0) + 1
    where = ", ".join(f"{name} {count}x" for name, count in turned.items()) or "none"
    text = f"largest correction {r['max_correction_mm']:.3f} mm; reversals: {where}; poses put in at flank changes: "
    text += str(r["inserted_poses"])
    if r["unknown_state"]["n_cut"]:
        u = r["unknown_state"]
        text += (
            f"\njoint flanks unknown at {u['n_cut']} cutting poses: up to {u['max_spread_mm']:.3f} mm either way; "
            "give [start] joints or a longer approach"
        )
    return text
