"""The HTML report of ``identify``: one file that opens without a network, the same bytes for the same fit."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.figures.fit import correlation_figure, joints_figure, normal_figure, reflectors_figure
from compensator.report.figures.thinning import Figure
from compensator.report.html import fit_tables as tables
from compensator.report.html.path import page_head, page_scripts
from compensator.report.views.fit import KINDS, AtJoint, AtReflector, joints, looked_at, reflectors, standardised
from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]

_SCRIPT = """
const figures = JSON.parse(document.getElementById("figures").textContent);
const config = {responsive: true, displaylogo: false, plotlyServerURL: ""};
for (const [id, f] of Object.entries(figures)) Plotly.newPlot(id, f.data, f.layout, config);
"""


def fit_page(fit: Fit, report: dict[str, Any]) -> str:
    """The report of a global fit.

    Args:
        report: the JSON report of the same fit, as ``identify_report`` makes it.
    """
    seen = looked_at(fit)
    at_joints, z, correlation = joints(fit, seen), standardised(fit), tables.correlation(fit)
    kinds = {name: found for name, judge in KINDS if (found := reflectors(seen, judge))}
    figures: dict[str, Figure] = {
        **({"reflectors": reflectors_figure(kinds)} if kinds else {}),
        **(_joint_figures(at_joints) if any(len(a.torque) for a in at_joints) else {}),
        "normal": normal_figure(z),
        "correlations": correlation_figure(fit, correlation),
    }
    title = f"Identified stiffness: {escape(fit.sessions[0].session.robot.name)}"
    body = [
        f"<h1>{title}</h1>",
        _headline(report),
        *_warnings(fit, report),
        tables.overall(report["rms_mm"]),
        "<h2>Parameters</h2>",
        "<p>An interval holds the true value in 95 of 100 such sessions, if what is wrong with the readings is the "
        "noise that the session states. Of a stiffness it is an interval of its inverse, so it is not symmetric.</p>",
        tables.parameters(fit),
        *_reflectors(kinds),
        *_joints(figures, tables.joints(at_joints)),
        *_normal(fit, z),
        *_design(fit, report, correlation),
        "<h2>Rows left out</h2>",
        tables.outliers(fit),
        *_notes(report),
        "<h2>What this was computed from</h2>",
        tables.inputs(fit),
    ]
    # the frame's own script turns the 3D views of a path; there is none here
    scripts = [*page_scripts(figures)[:-1], f"<script>{_SCRIPT}</script>"]
    return "\n".join([page_head(title), *body, *scripts, "</body>", "</html>", ""])


def _headline(report: dict[str, Any]) -> str:
    known = report["identifiable"]
    out = len(report["outlier_rows"])
    text = f"From {report['n_readings']:,} readings{f', {out:,} of them left out,' if out else ''} "
    text += f"<b>{sum(known)} of {len(known)}</b> joint stiffnesses are identified. "
    kind = next((k for k in ("displacement", "absolute") if report["rms_mm"].get(k)), None)
    if kind is not None:
        rms = {k: tables.millimetres(v) for k, v in report["rms_mm"][kind].items()}
        what = "displacements" if kind == "displacement" else "positions"
        text += (
            f"A rigid arm misses the measured {what} by <b>{rms['rigid']} mm</b> (RMS per axis), the fit by "
            f"<b>{rms['fitted']} mm</b>; noise alone would leave {rms['noise_floor']} mm."
        )
    return f'<p class="lead">{text}</p>'


def _warnings(fit: Fit, report: dict[str, Any]) -> list[str]:
    out = []
    # of kinematic offsets only sums are determined, as a rule: the table has them one by one
    stiff = [text for text in report["not_identified"] if "(kinematic-offset)" not in text]
    if stiff:
        items = "".join(f"<li>{escape(text)}</li>" for text in stiff)
        text = "<p>Not identified, so no value is given; a path that loads such a joint is refused:</p>"
        out.append(f'<div class="warn">{text}<ul>{items}</ul></div>')
    shared = len(report["not_identified"]) - len(stiff)
    if shared:
        out.append(
            f'<p class="quiet">{shared} kinematic offsets are not identified one by one: a joint zero and the twist of '
            "the link before it, for one, are the same motion, and only their sum is known.</p>"
        )
    if fit.solution.misfit > 1:
        out.append(
            f'<p class="warn">The residuals are {fit.solution.misfit:.2f} times as large as the instruments explain: '
            "something is not in the model, or the stated noise is too small. All standard deviations are widened by "
            "this factor.</p>"
        )
    return out


def _reflectors(kinds: dict[str, list[AtReflector]]) -> list[str]:
    if not kinds:
        return []
    return [
        "<h2>Residuals per reflector</h2>",
        "<p>Before: what a rigid arm leaves, its tracker and rough reflectors placed by the same readings. After: what "
        "the fit leaves; the black line is what the noise of tracker and force sensor alone would leave. The two sides "
        "have different scales.</p>",
        '<div class="pair">' + "".join(tables.reflectors(kind, at) for kind, at in kinds.items()) + "</div>",
        '<div id="reflectors"></div>',
    ]


def _joint_figures(at: list[AtJoint]) -> dict[str, Figure]:
    return {"joints": joints_figure(at), "joints-after": joints_figure(at, enlarged=True)}


def _joints(figures: dict[str, Figure], rows: str) -> list[str]:
    out = ["<h2>Residuals per joint</h2>"]
    if "joints" not in figures:
        return [*out, "<p>The sessions have no displacement: no loaded reading has an unloaded one beside it.</p>"]
    return [
        *out,
        "<p>A point is one measured displacement: its residual along the way that its reflector goes when the joint "
        "gives in to a positive torque, over the change of the load's torque about the joint. A rigid arm leaves the "
        "slope of a soft joint, and the motion of the other joints; after the fit neither slope nor bend may be "
        "left.</p>",
        rows,
        '<div id="joints"></div>',
        "<p>After the fit alone, enlarged:</p>",
        '<div id="joints-after"></div>',
    ]


def _normal(fit: Fit, z: Floats) -> list[str]:
    spread = float(np.sqrt(np.mean(z**2))) if len(z) else 0.0
    beyond = int(np.sum(np.abs(z) > 3))
    return [
        "<h2>Are the residuals noise?</h2>",
        f"<p>{len(z):,} residuals, made independent of each other and divided by the noise that the instruments "
        f"state: their RMS is {spread:.3f} (1 where the noise is all there is, a little less for the numbers that were "
        f"fitted), and {beyond:,} are beyond three standard deviations (expected: {0.0027 * len(z):.1f}). Orange: what "
        "a normal distribution gives. The outermost bars hold all that lies further out.</p>",
        '<div id="normal"></div>',
    ]


def _design(fit: Fit, report: dict[str, Any], correlation: Floats) -> list[str]:
    return [
        "<h2>Quality of the design</h2>",
        "<p>How well the set-ups, loads and reflectors tell the numbers apart, whatever was read. Large indices O1 to "
        "O4 and a small condition number are good.</p>",
        tables.design(fit, float(report["condition_number"])),
        tables.weakest(fit),
        tables.largest_correlations(fit, correlation),
        '<div class="wide"><div id="correlations"></div></div>',
    ]


def _notes(report: dict[str, Any]) -> list[str]:
    if not report["notes"]:
        return []
    return ["<h2>Notes</h2>", "<ul>" + "".join(f"<li>{escape(note)}</li>" for note in report["notes"]) + "</ul>"]
