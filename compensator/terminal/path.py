"""What the terminal shows of a compensated or previewed path."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from compensator.report.words.cut import band_lines, cut_lines
from compensator.report.words.numbers import deflection_mm
from compensator.report.words.shares import SHARES, direction_words
from compensator.tasks.compensate import Done
from compensator.terminal.screen import asked_for_all, print_lines, print_written, screen, table

SEEN = 5e-4  # mm: a smaller share would be a row of zeros


def show_path(done: Done) -> None:
    """Tables of the numbers, and files."""
    console, report, result = screen(), done.report, done.result
    if console is None:
        return
    console.print(
        Text(result.path.toolpath.source, "bold"),
        f"on {result.job.arm.robot.name}: {report['n_poses']} poses, {report['n_cut']} cutting, {report['seconds']} s",
    )
    errors = table("", "mean", "95 %", "max", right=range(1, 4), title="predicted TCP error, mm")
    error = report["predicted_error_mm"]
    errors.add_row("uncompensated", *_sizes(error["before"]))
    if "uncoupled" in error:
        errors.add_row("  with the force of the nominal path", *_sizes(error["uncoupled"]), style="dim")
    for name, share in report["deflection_mm"].items():
        if share["max"] >= SEEN:
            errors.add_row(f"  {SHARES[name]}", *_sizes(share), style="dim")
    if result.is_corrected:
        errors.add_row("program as written", *_sizes(error["after"]))
    console.print(errors)
    _print_facts(console, done)
    print_written(console, done.files)


def _sizes(of: dict[str, float]) -> list[str]:
    return [deflection_mm(of[s]) for s in ("mean", "p95", "max")]


def _print_facts(console: Console, done: Done) -> None:
    r = done.report
    turned: dict[str, int] = {}
    for t in r["reversals"]:
        turned[t["where"]] = turned.get(t["where"], 0) + 1
    where = ", ".join(f"{name} {count}x" for name, count in turned.items()) or "none"
    if turned and not asked_for_all():
        where = f"{sum(turned.values())} in {len(turned)} joints"
    text = f"tool looks along {direction_words(r)} in base axes; reversals: {where}"
    if done.result.is_corrected:
        text = f"largest correction {deflection_mm(r['max_correction_mm'])} mm; {text}"
        text += f"; poses put in at flank changes: {r['inserted_poses']}"
    console.print(text, highlight=False)
    print_lines(console, [*cut_lines(done.result, r), *band_lines(r)])
