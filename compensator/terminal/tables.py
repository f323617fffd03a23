"""What the terminal shows: progress, a table of the numbers, a robot."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from compensator.tasks.compensate import Done
from compensator.tasks.say import Say
from stiffness.model.model import builtin_model
from stiffness.robot.load import builtin_robots, load_robot

if TYPE_CHECKING:  # the libraries of a fit take half a second that compensate and preview do not need
    from compensator.tasks.identify import Identified


@contextmanager
def progress(verbose: bool) -> Iterator[Say]:
    """Says what is being done: a spinner on a terminal, lines with ``verbose``, nothing when piped."""
    console = Console(stderr=True, markup=False)
    if verbose:
        yield lambda text: console.print(text, highlight=False)
    elif console.is_terminal:
        with console.status("starting") as status:
            yield lambda text: status.update(Text(text))
    else:
        yield lambda text: None


def show(done: Done) -> None:
    """Table of the numbers, files, what the result does not know; nothing when piped."""
    console = Console(markup=False)
    if not console.is_terminal:
        return
    report, result = done.report, done.result
    console.print(
        Text(result.path.toolpath.source, "bold"),
        f"on {result.job.arm.robot.name}: {report['n_poses']} poses, {report['n_cut']} cutting, {report['seconds']} s",
    )
    table = Table(title="predicted TCP error, mm")
    for head in ("", "mean", "95 %", "max"):
        table.add_column(head, justify="left" if not head else "right")
    error = report["predicted_error_mm"]
    for name, key in (("uncompensated", "before"), ("program as written", "after")):
        if key == "before" or report["max_correction_mm"] > 0:
            table.add_row(name, *(f"{error[key][s]:.4f}" for s in ("mean", "p95", "max")))
    console.print(table)
    console.print(_sentence(done), highlight=False)
    for finding in done.findings:
        console.print(f"  - {finding}", highlight=False, style="dim")
    if report["not_applied"]:
        console.print(f"  - not applied (other tool or instruments): {', '.join(report['not_applied'])}")
    for file in done.files:
        console.print(f"wrote {file}", highlight=False)


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


def show_fit(done: Identified) -> None:
    """Parameters, residuals and what the data do not determine; nothing when piped."""
    console, report = Console(markup=False), done.report
    if not console.is_terminal:
        return
    table = Table(title=f"{report['n_readings']} readings, effects {', '.join(report['effects'])}")
    for head in ("joint", "stiffness, N*m/rad", "standard deviation"):
        table.add_column(head, justify="right")
    columns = (report["stiffness_nm_per_rad"], report["stiffness_sd_nm_per_rad"])
    for k, (value, sd) in enumerate(zip(*columns, strict=True)):
        table.add_row(str(k + 1), *(("not identified", "") if value is None else (f"{value:.4g}", f"{sd:.2g}")))
    console.print(table)
    for kind, rms in report["rms_mm"].items():
        if rms:
            console.print(
                f"{kind}: {rms['rigid']:.4f} mm rigid, {rms['fitted']:.4f} mm fitted, noise {rms['noise_floor']:.4f} mm"
            )
    if report["outlier_rows"]:
        rows = ", ".join(str(r["row"]) for r in report["outlier_rows"][:20])
        console.print(f"left out, contradicted by all others: {len(report['outlier_rows'])} rows ({rows})")
    for line in (*report["notes"], *report["not_identified"]):
        console.print(f"  - {line}", highlight=False, style="dim")
    for file in done.files:
        console.print(f"wrote {file}", highlight=False)


def show_lines(lines: Sequence[str]) -> None:
    """Plain lines; nothing when piped."""
    console = Console(markup=False)
    for line in lines if console.is_terminal else ():
        console.print(line, highlight=False)


def show_evaluation(report: dict[str, Any]) -> None:
    """One line per kind of evidence; nothing when piped."""
    console = Console(markup=False)
    if not console.is_terminal:
        return
    for kind, score in report.items():
        if score is None:
            console.print(f"{kind}: no such evidence")
            continue
        console.print(
            f"{kind}: rms {score['rms_mm']:.4f} mm per axis (noise {score['noise_floor_mm']:.4f}), "
            f"95 % {score['p95_mm']:.4f} mm, max {score['max_mm']:.4f} mm"
        )


def show_robots() -> None:
    """One line per built-in robot."""
    table = Table(title="built-in robots")
    for head in ("name", "reach of the flange, mm", "stiffness set", "masses"):
        table.add_column(head)
    for name in builtin_robots():
        robot = load_robot(name)
        links = np.concatenate([robot.before[1:, :3, 3], robot.after[:, :3, 3]])
        reach = np.linalg.norm(links, axis=1).sum()
        masses = "yes" if robot.mass is not None else "no"
        if any("mass" in a for a in robot.assumptions):
            masses = "assumed"
        stiffness = "published" if builtin_model(name) else "none"
        table.add_row(name, f"{reach * 1e3:.0f} (links in line)", stiffness, masses)
    Console(width=110, markup=False).print(table)


def show_robot(name: str) -> None:
    """Limits, masses, sources and assumptions of a robot."""
    robot = load_robot(name)
    console = Console(width=110, markup=False)
    console.print(repr(robot), highlight=False)
    table = Table()
    for head in ("joint", "limits, deg", "speed, deg/s", "mass, kg", "centre of mass in its link frame, mm"):
        table.add_column(head)
    for k in range(robot.n):
        table.add_row(
            robot.joint_names[k],
            f"{np.degrees(robot.lower[k]):.1f} ... {np.degrees(robot.upper[k]):.1f}",
            f"{np.degrees(robot.velocity[k]):.0f}" if np.isfinite(robot.velocity[k]) else "unknown",
            "unknown" if robot.mass is None else f"{robot.mass[k]:.1f}",
            "unknown" if robot.com is None else ", ".join(f"{v * 1e3:.0f}" for v in robot.com[k]),
        )
    console.print(table)
    if robot.mass_problem:
        console.print(f"masses: {robot.mass_problem}", highlight=False)
    for text in robot.assumptions:
        console.print(f"assumption: {text}", highlight=False)
    for text in robot.sources:
        console.print(f"source: {text}", highlight=False)
