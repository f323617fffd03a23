"""The tables of the HTML report. Everything that comes from a file is escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np

from compensator.solve.compensation import Compensation

LISTED = 12  # turnarounds that are written out per joint
Numbers = dict[str, Any]


def compensated(c: Compensation) -> bool:
    """False for what ``preview`` shows: no round of the solve was run."""
    return c.iterations > 0


def millimetres(value: float) -> str:
    """A length in mm: four decimals, two digits where that would be nothing, down to 1 nm."""
    if value == 0 or value >= 1e-3:
        return f"{value:.4f}"
    if value < 1e-6:
        return "< 0.000001"
    digits = 1 - int(np.floor(np.log10(value)))
    return f"{value:.{min(digits, 6)}f}"


def errors(numbers: Numbers, done: bool) -> str:
    """Before and after."""
    kinds = [("uncompensated", "before"), ("program as written", "after")][: 2 if done else 1]
    error = numbers["predicted_error_mm"]
    rows = [[name, *(millimetres(error[key][s]) for s in ("mean", "p95", "max"))] for name, key in kinds]
    head = ["mm, over cutting poses", "mean", "95 %", "max"]
    return table("Predicted TCP error", head, rows, right=range(1, 4))


def facts(numbers: Numbers, done: bool) -> str:
    """Counts."""
    unknown = numbers["unknown_state"]
    rows = [["poses", f"{numbers['n_poses']:,}"], ["of these cutting", f"{numbers['n_cut']:,}"]]
    if done:
        rows += [
            ["of these put in at flank changes", f"{numbers['inserted_poses']:,}"],
            ["largest correction", f"{millimetres(numbers['max_correction_mm'])} mm"],
            ["rounds of state and correction", f"{numbers['solve']['iterations_max']}"],
            ["poses without a solution", f"{numbers['solve']['unconverged']}"],
        ]
    rows += [
        ["joint reversals", f"{len(numbers['reversals']):,}"],
        ["torque sign changes", f"{len(numbers['torque_sign_changes']):,}"],
        ["cutting poses with unknown flanks", f"{unknown['n_cut']:,}"],
    ]
    if unknown["n_cut"]:
        rows.append(["largest spread that this leaves", f"{millimetres(unknown['max_spread_mm'])} mm"])
    return table("The path", None, rows, right=[1])


def joints(c: Compensation) -> str:
    """Per joint: limits, range used, correction, torque, each with its source line."""
    q, robot, torque = np.degrees(c.command.q), c.job.arm.robot, c.command.torque
    low, high = np.degrees(robot.lower), np.degrees(robot.upper)
    shift = np.degrees(c.command.q - c.path.q)
    room = np.minimum(q - low, high - q)
    head = ["joint", "name", "limits, deg", "commanded, deg", "nearest to a limit, deg"]
    head.append("largest torque, N·m")
    rows = []
    for j in range(robot.n):
        row = [
            f"{j + 1}",
            escape(robot.joint_names[j]),
            f"{low[j]:.1f} … {high[j]:.1f}",
            f"{q[:, j].min():.2f} … {q[:, j].max():.2f}",
            _at(c, int(np.argmin(room[:, j])), f"{room[:, j].min():.2f}"),
            _largest(c, torque[:, j], 0),
        ]
        rows.append([*row, _largest(c, shift[:, j], 5)] if compensated(c) else row)
    if compensated(c):
        head.append("largest correction, deg")
    caption = "Angles, torques of gravity and process, and corrections, with their source line"
    return table(caption, head, rows, right=range(2, len(head)))


def _largest(c: Compensation, values: Any, digits: int) -> str:
    k = int(np.argmax(np.abs(values)))
    return _at(c, k, f"{round(float(values[k]), digits) + 0.0:.{digits}f}")


def _at(c: Compensation, pose: int, text: str) -> str:
    return f"{text} (line {c.path.toolpath.line[pose]})"


def turnarounds(c: Compensation, numbers: Numbers) -> str:
    """Where joints reverse and torques change sign; long lists are cut."""
    rows = []
    for j in range(c.job.arm.robot.n):
        cells = [f"{j + 1}"]
        for found in (numbers["reversals"], numbers["torque_sign_changes"]):
            mine = [t for t in found if t["where"] == f"joint-{j + 1}"]
            cells += [f"{len(mine):,}", _places(mine)]
        rows.append(cells)
    head = ["joint", "reversals", "at", "torque sign changes", "at"]
    caption = "Where joints turn around and torques change sign: source line (pose)"
    return table(caption, head, rows, right=(1, 3))


def _places(found: Sequence[Numbers]) -> str:
    text = ", ".join(f"{t['source_line']} ({t['pose']})" for t in found[:LISTED])
    more = len(found) - LISTED
    return text + (f" … and {more:,} more, all of them in the JSON summary" if more > 0 else "")


def inputs(c: Compensation) -> str:
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
    return table("", None, [[name, escape(text)] for name, text in rows], right=())


def table(caption: str, head: list[str] | None, rows: list[list[str]], *, right: Iterable[int]) -> str:
    """Cells are HTML already; the columns ``right`` hold figures and are set flush right."""
    figures = set(right)
    out = f"<caption>{caption}</caption>" if caption else ""
    lines = [("th", head)] if head else []
    for tag, cells in [*lines, *(("td", row) for row in rows)]:
        marked = (f"<{tag}{' class=n' * (k in figures)}>{cell}</{tag}>" for k, cell in enumerate(cells))
        out += f"<tr>{''.join(marked)}</tr>"
    return f'<div class="wide"><table>{out}</table></div>'
