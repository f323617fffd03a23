"""The tables of the page of a path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator.report.html.table import PageTable
from compensator.report.json.text import Report
from compensator.report.words.numbers import deflection_mm
from compensator.report.words.shares import SHARES, direction_words
from compensator.solve.compensation import Compensation

LISTED = 12  # turnarounds that are written out per joint


def errors(report: Report, corrected: bool) -> PageTable:
    """Before and after."""
    kinds = [("uncompensated", "before"), ("program as written", "after")][: 2 if corrected else 1]
    error = report["predicted_error_mm"]
    if "uncoupled" in error:
        kinds.append(("with the force of the nominal path", "uncoupled"))
    rows = [[name, *(deflection_mm(error[key][s]) for s in ("mean", "p95", "max"))] for name, key in kinds]
    head = ["mm, over cutting poses", "mean", "95 %", "max"]
    return PageTable(rows, head, right=range(1, 4), caption="Predicted TCP error")


def shares(report: Report) -> PageTable:
    """What the deflection is made of."""
    of = {SHARES[name]: share for name, share in report["deflection_mm"].items()}
    whole = np.sum([share["mean_xyz"] for share in of.values()], axis=0)
    of["together"] = {**report["predicted_error_mm"]["before"], "mean_xyz": whole}
    rows = []
    for name, share in of.items():
        mean = ", ".join(f"{v + 0.0:.3f}" for v in np.round(share["mean_xyz"], 3))
        rows.append([name, *(deflection_mm(share[s]) for s in ("mean", "p95", "max")), mean])
    head = ["mm, over cutting poses", "mean", "95 %", "max", "mean vector x, y, z"]
    caption = "What it is made of, uncompensated: vectors add up, sizes do not"
    return PageTable(rows, head, right=range(1, 5), caption=caption)


def facts(report: Report, corrected: bool) -> PageTable:
    """Counts."""
    unknown = report["unknown_state"]
    rows = [["poses", f"{report['n_poses']:,}"], ["of these cutting", f"{report['n_cut']:,}"]]
    if corrected:
        rows += [
            ["of these put in at flank changes", f"{report['inserted_poses']:,}"],
            ["largest correction", f"{deflection_mm(report['max_correction_mm'])} mm"],
            ["rounds of state and correction", f"{report['solve']['iterations_max']}"],
            ["poses without a solution", f"{report['solve']['unconverged']}"],
        ]
    rows += [
        ["tool looks along, base axes", direction_words(report)],
        ["joint reversals", f"{len(report['reversals']):,}"],
        ["torque sign changes", f"{len(report['torque_sign_changes']):,}"],
        ["cutting poses with unknown flanks", f"{unknown['n_cut']:,}"],
    ]
    if unknown["n_cut"]:
        rows.append(["largest spread that this leaves", f"{deflection_mm(unknown['max_spread_mm'])} mm"])
    return PageTable(rows, right=[1], caption="The path")


def joints(c: Compensation) -> PageTable:
    """Per joint: limits, range used, correction, torque, each with its source line."""
    q, robot, torque = np.degrees(c.command.q), c.job.arm.robot, c.command.torque
    low, high = np.degrees(robot.lower), np.degrees(robot.upper)
    shift = np.degrees(c.command.q - c.path.q)
    room = np.minimum(q - low, high - q)
    head = ["joint", "name", "limits, deg", "commanded, deg", "nearest to a limit, deg", "largest torque, N·m"]
    rows = []
    for j in range(robot.n):
        row = [
            f"{j + 1}",
            robot.joint_names[j],
            f"{low[j]:.1f} … {high[j]:.1f}",
            f"{q[:, j].min():.2f} … {q[:, j].max():.2f}",
            _at(c, int(np.argmin(room[:, j])), f"{room[:, j].min():.2f}"),
            _largest(c, torque[:, j], 0),
        ]
        rows.append([*row, _largest(c, shift[:, j], 5)] if c.is_corrected else row)
    if c.is_corrected:
        head.append("largest correction, deg")
    caption = "Angles, torques of gravity and process, and corrections, with their source line"
    return PageTable(rows, head, right=range(2, len(head)), caption=caption)


def _largest(c: Compensation, values: Any, digits: int) -> str:
    k = int(np.argmax(np.abs(values)))
    return _at(c, k, f"{round(float(values[k]), digits) + 0.0:.{digits}f}")


def _at(c: Compensation, pose: int, text: str) -> str:
    return f"{text} ({c.path.toolpath.line_words(pose)})"


def turnarounds(c: Compensation, report: Report) -> PageTable:
    """Where joints reverse and torques change sign; long lists are cut."""
    rows = []
    for j in range(c.job.arm.robot.n):
        cells = [f"{j + 1}"]
        for found in (report["reversals"], report["torque_sign_changes"]):
            mine = [t for t in found if t["where"] == f"joint-{j + 1}"]
            cells += [f"{len(mine):,}", _places(mine)]
        rows.append(cells)
    head = ["joint", "reversals", "at", "torque sign changes", "at"]
    caption = "Where joints turn around and torques change sign: source line (pose)"
    return PageTable(rows, head, right=(1, 3), caption=caption)


def _places(found: Sequence[Report]) -> str:
    text = ", ".join(f"{t['source_line']} ({t['pose']})" for t in found[:LISTED])
    more = len(found) - LISTED
    return text + (f" … and {more:,} more, all of them in the JSON summary" if more > 0 else "")


def inputs(c: Compensation) -> PageTable:
    """What the result was computed from."""
    job = c.job
    tools = []
    for tool in job.placement.tools.by_number.values():
        where = ", ".join(f"{v * 1e3:g}" for v in tool.position)
        tools.append(f"{tool.name}: TCP [{where}] mm from the flange, {tool.mass:g} kg")
    rows = [
        ["toolpath", c.path.toolpath.source],
        ["cell", job.placement.source],
        ["robot", job.arm.robot.name],
        ["model", f"{job.arm.model.source}: {', '.join(e.name for e in job.arm.effects)}"],
        ["gravity", job.placement.conditions.sag or job.arm.model.gravity],
        ["tool", "; ".join(tools)],
        ["process wrench", job.placement.process.description()],
    ]
    return PageTable(rows)
