"""The HTML report: one file that opens without a network, the same bytes for the same result.

Everything that comes from a file is escaped, and the page's own content security policy forbids it to
fetch anything.
"""

from __future__ import annotations

import json
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt
from plotly.offline import get_plotlyjs

from compensator.report.figures.curves import along_figure, flanks_figure, joints_figure
from compensator.report.figures.path import path_figure
from compensator.report.figures.thinning import LIMIT, Figure
from compensator.report.html import tables
from compensator.report.html.tables import compensated, millimetres
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_along

Floats = npt.NDArray[np.float64]

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:"
)
_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2126; background: #fff; }
body { max-width: 1240px; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .5rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .4rem; }
p, li { margin: .4rem 0; max-width: 66rem; overflow-wrap: anywhere; }
li { margin: .1rem 0; }
.lead { font-size: 1.12rem; }
.quiet { color: #5a646d; }
.warn { border-left: 4px solid #d55e00; padding-left: .8rem; }
.pair { display: flex; flex-wrap: wrap; gap: 0 5rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: .6rem 0 1rem; }
caption { text-align: left; font-weight: 600; padding-bottom: .2rem; white-space: nowrap; }
th, td { padding: .25rem 1.1rem .25rem 0; text-align: left; vertical-align: top; }
th, td { border-bottom: 1px solid #e3e6e9; }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
"""
# Both views of the path turn together.
_SCRIPT = """
const figures = JSON.parse(document.getElementById("figures").textContent);
const config = {responsive: true, displaylogo: false, plotlyServerURL: ""};
for (const [id, f] of Object.entries(figures)) Plotly.newPlot(id, f.data, f.layout, config);
const path = document.getElementById("path");
let turning = false;
if (figures.path.layout.scene2) path.on("plotly_relayout", change => {
  const camera = change["scene.camera"] || change["scene2.camera"];
  if (!camera || turning) return;
  turning = true;
  Plotly.relayout(path, {"scene.camera": camera, "scene2.camera": camera}).then(() => { turning = false; });
});
"""


def page(result: Compensation, numbers: dict[str, Any], after: Floats | None = None) -> str:
    """The report of ``compensate``, or of ``preview`` where the result is not compensated.

    Args:
        numbers: the JSON summary of the run; its ``seconds`` are not shown.
        after: (N,) m, error of every pose with the program as written; without it that of the exact commands.
    """
    done = compensated(result)
    left = _left(result, after) if done else None
    figures = _figures(result, left)
    title = "Compensated toolpath: " if done else "Predicted deflection, not compensated: "
    title += escape(result.path.toolpath.source)
    body = [
        f"<h1>{title}</h1>",
        _headline(result, numbers, left),
        f'<div class="pair">{tables.errors(numbers, done)}{tables.facts(numbers, done)}</div>',
        *_warnings(numbers),
        *_path_section(result, done),
        *_curve_sections(figures, done),
        "<h2>Joints</h2>",
        tables.joints(result),
        tables.turnarounds(result, numbers),
        "<h2>What this was computed from</h2>",
        tables.inputs(result),
    ]
    return "\n".join([page_head(title), *body, *page_scripts(figures), "</body>", "</html>", ""])


def _left(c: Compensation, after: Floats | None) -> Floats:
    """(N,) mm: what is left with the commands."""
    if after is None:
        prediction, _ = equilibrium_along(
            c.job.arm, c.job.placement.start, c.path.toolpath, q=c.command.q, wrench=c.wrench
        )
        after = np.linalg.norm(prediction.position - c.target.origin, axis=1)
    return np.asarray(after * 1e3)


def page_head(title: str) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>"
    )


def page_scripts(figures: dict[str, Figure]) -> list[str]:
    data = json.dumps(figures, separators=(",", ":"), allow_nan=False)
    for sign in "&<>":
        data = data.replace(sign, f"\\u{ord(sign):04x}")
    return [
        f'<script type="application/json" id="figures">{data}</script>',
        f"<script>{get_plotlyjs()}</script>",
        f"<script>{_SCRIPT}</script>",
    ]


def _headline(c: Compensation, numbers: dict[str, Any], left: Floats | None) -> str:
    error = numbers["predicted_error_mm"]
    before, after = ({k: millimetres(v) for k, v in error[key].items()} for key in ("before", "after"))
    text = (
        f"Commanded as it stands in the file, {escape(c.job.arm.robot.name)} misses the path by "
        f"<b>{before['mean']} mm</b> on average and by up to <b>{before['max']} mm</b> "
        f"({_worst(c, np.linalg.norm(c.error_before, axis=1))}), as the model predicts it."
    )
    if left is None:
        return f'<p class="lead">{text} Nothing is corrected here.</p>'
    size = np.linalg.norm(c.correction, axis=1)
    return (
        f'<p class="lead">{text} With the program as written <b>{after["mean"]} mm</b> on average and '
        f"<b>{after['max']} mm</b> at most ({_worst(c, left)}) are left. The largest correction is "
        f"<b>{millimetres(numbers['max_correction_mm'])} mm</b> ({_place(c, int(np.argmax(size)))}).</p>"
    )


def _worst(c: Compensation, size: Floats) -> str:
    """Where the largest value of the cutting poses is."""
    cut = np.flatnonzero(c.cutting)
    return _place(c, int(cut[np.argmax(size[cut])]))


def _place(c: Compensation, pose: int) -> str:
    return f"line {c.path.toolpath.line[pose]}, pose {pose}"


def _warnings(numbers: dict[str, Any]) -> list[str]:
    out = []
    unknown = numbers["unknown_state"]
    if unknown["n_cut"]:
        out.append(
            f'<p class="warn">At {unknown["n_cut"]:,} cutting poses it is not known on which flank every '
            f"joint rests: that is up to {millimetres(unknown['max_spread_mm'])} mm at the TCP, from one "
            "extreme to the other. [start] joints in the cell or a longer approach settle it.</p>"
        )
    if numbers["not_applied"]:
        names = escape(", ".join(numbers["not_applied"]))
        out.append(f'<p class="warn">In the model but not applied (other tool, or instruments): {names}.</p>')
    if numbers["notes"]:
        items = "".join(f"<li>{escape(note)}</li>" for note in numbers["notes"])
        out.append(f"<h2>Assumptions and limits</h2>\n<ul>{items}</ul>")
    return out


def _figures(c: Compensation, left: Floats | None) -> dict[str, Figure]:
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    views = [("not compensated", before)] if left is None else [("before", before), ("after", left)]
    flanks = flanks_figure(c)
    return {
        "path": path_figure(c, views),
        "along": along_figure(c, before, left),
        "joints": joints_figure(c),
        **({} if flanks is None else {"flanks": flanks}),
    }


def _path_section(c: Compensation, done: bool) -> list[str]:
    text = "Colour: distance of the TCP from where it has to be when the nominal poses are commanded"
    text += " (before) and with the program as written (after). " if done else ". "
    if done:
        text += (
            "Both views have one colour range, from 0 to the largest error, so that a colour means the same "
            "in both; a button gives each its own. "
        )
    text += "Thin grey lines: rapids. Axes are equal; drag to turn, scroll to zoom."
    out = [
        "<h2>The path in the work object</h2>",
        f"<p>{text}</p>",
        '<div id="path" style="height:620px"></div>',
    ]
    if len(c) > LIMIT:
        out.append(
            f'<p class="quiet">The path has {len(c):,} poses. Every curve is thinned to at most {LIMIT:,} '
            "points; the smallest and the largest value of every stretch are kept.</p>"
        )
    return out


def _curve_sections(figures: dict[str, Figure], done: bool) -> list[str]:
    correction = " Correction: the command minus the nominal pose; along rapids next to a cut it fades out."
    out = [
        "<h2>Deflection along the path</h2>",
        "<p>Cutting poses only. Distance: of the TCP from where it has to be. Deflection: actual minus "
        f"commanded, in the axes of the robot's base.{correction if done else ''}</p>",
        '<div id="along"></div>',
        "<h2>Joint angles against their limits</h2>",
        "<p>0 % is the lower limit of each joint, 100 % the upper one; the last 5 % are shaded.</p>",
        '<div id="joints"></div>',
    ]
    if "flanks" in figures:
        out += [
            "<h2>Flanks</h2>",
            "<p>A lane per joint. backlash: where the joint stands in its gap, from its lowest to its "
            "highest angle. preload-softening: the direction of the last rotation, up is positive. Grey: "
            "not known. A joint without a gap has no line.</p>",
            '<div id="flanks"></div>',
        ]
    return out
