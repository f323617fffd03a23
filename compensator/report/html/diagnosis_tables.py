"""The tables of the report of a diagnosis. Everything that comes from a file is escaped here."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from compensator.report.html.fit_tables import DASH, LISTED, figure, millimetres
from compensator.report.html.tables import table
from compensator.report.words.diagnosis import WRITTEN, bare, follows_words, in_words, joined, shown_unit
from stiffness.diagnosis.result import Changed, Diagnosis
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

ALIKE = 3  # names that are written out
Report = dict[str, Any]


def scores(report: Report) -> str:
    """RMS on readings that took no part."""
    rows = []
    for kind, r in report["rms_mm"].items():
        if r is None:
            rows.append([kind, *[DASH] * 5])
            continue
        keys = ("before", "refitted", "after", "noise_floor")
        ratio = f"{r['after'] / r['noise_floor']:.2f}" if r["noise_floor"] > 0 else DASH
        rows.append([kind, *(millimetres(r[k]) for k in keys), ratio])
    head = ["RMS per axis, mm", "model at hand", "its numbers fitted anew", "refined", "noise floor", "refined / floor"]
    return table("On readings that took no part", head, rows, right=range(1, 6))


def split(report: Report) -> str:
    """What the error before is made of."""
    rows = [
        [kind, *(millimetres(s[k]) for k in ("noise", "parameters", "structure", "left"))] if s else [kind, *[DASH] * 4]
        for kind, s in report["split_mm"].items()
    ]
    head = ["RMS per axis, mm", "noise", "parameters", "structure", "left after"]
    return table("", head, rows, right=range(1, 5))


def additions(d: Diagnosis) -> str:
    """Every number of what was added."""
    rows = []
    for a in d.added:
        for name, (values, sd, unit) in a.parameters.items():
            shown, factor = shown_unit(unit)
            if len(values) > max(WRITTEN, len(a.where)):
                if np.any(values):
                    where, text = escape(joined(a.where)), f"{len(values)} numbers, in the refined model"
                    rows.append([escape(a.effect), escape(bare(name)), where, "", text, ""])
                continue
            alone = joined(a.where)
            spots = [f"{alone}, number {k + 1}" for k in range(len(values))] if len(values) > 1 else [alone]
            spots = list(a.where) if len(values) == len(a.where) else spots
            for k, (v, s) in enumerate(zip(values * factor, sd * factor, strict=True)):
                spread = figure(s, s) if s > 0 else "searched, not fitted"
                value = figure(v, s) if s > 0 else f"{v:.4g}"
                cells = [escape(a.effect), escape(bare(name)), escape(spots[k]), escape(shown)]
                rows.append([*cells, f"<b>{value}</b>", spread])
    head = ["effect", "number", "of", "unit", "value", "standard deviation"]
    return table("What was added", head, rows, right=(4, 5))


def candidates(d: Diagnosis) -> str:
    """The ranking, with what is alike."""
    rows = []
    for k, c in enumerate(c for c in d.candidates if c.where):
        cells = [f"{k + 1}", escape(c.effect), escape(joined(c.where)), millimetres(c.heldout_rms * 1e3)]
        more = len(c.confused_with) - ALIKE
        alike = [*c.confused_with[:ALIKE], *([f"{more} more"] if more > 0 else [])]
        rows.append([*cells, escape(joined(alike)) or DASH])
    head = ["no.", "effect, by itself", "where it pays", "RMS on set-ups left out, mm", "as good, within chance"]
    return table("", head, rows, right=(0, 3))


def attribution(d: Diagnosis) -> str:
    """Where the structure sits and what it follows."""
    rows = [
        [escape(in_words(s.what)), f"{100 * s.share:.0f} %", escape(follows_words(s.follows)) or DASH]
        for s in d.points_at
    ]
    return table("", ["place or column", "share of the structure", "follows"], rows, right=[1])


def next_setups(report: Report) -> str:
    """What to measure."""
    rows = []
    for k, s in enumerate(report["next_setups"]):
        q = ", ".join(f"{v:.1f}" for v in s["q_deg"])
        wrench = ", ".join(f"{v:.0f}" for v in s["wrench_n_nm"])
        rows.append([f"{k + 1}", q, wrench, escape(joined(s["reflectors"])), escape(s["why"])])
    head = [
        "no.",
        "joint angles, deg",
        "wrench on the robot at the TCP, base axes, N and N·m",
        "watch reflector",
        "why",
    ]
    return table("", head, rows, right=[0])


def changed(found: tuple[Changed, ...]) -> str:
    """Numbers that have moved."""
    rows = []
    for c in found:
        unit, factor = shown_unit(c.unit)
        numbers = [figure(v * factor, c.sd * factor) for v in (c.before, c.after)]
        share = f"{100 * (c.after / c.before - 1):+.1f} %" if c.before else DASH
        names = [escape(c.effect), escape(bare(c.parameter)), escape(joined(c.where)), escape(unit)]
        rows.append([*names, *numbers, figure(c.sd * factor, c.sd * factor), share])
    head = ["effect", "number", "of", "unit", "in the model", "now", "standard deviation", "change"]
    return table("", head, rows, right=range(4, 8))


def outliers(d: Diagnosis) -> str:
    """Rows that were left out."""
    if not d.outliers:
        return "<p>No row was left out: none is contradicted by the others.</p>"
    rows = [[escape(name), f"{line}"] for name, line in d.outliers[:LISTED]]
    more = len(d.outliers) - LISTED
    tail = f"<p>… and {more:,} more, all of them in the JSON report.</p>" if more > 0 else ""
    text = f"<p>{len(d.outliers):,} rows, contradicted by all others, count for nothing here.</p>"
    return text + table("", ["session", "line of samples.csv"], rows, right=[1]) + tail


def reflectors(sessions: list[Session]) -> str:
    """Numbers of the reflectors in the map."""
    rows = [
        [escape(s.source) if len(sessions) > 1 else "", f"{k + 1}", escape(r.name), f"{r.link}"]
        for s in sessions
        for k, r in enumerate(s.reflectors)
    ]
    start = 0 if len(sessions) > 1 else 1
    head = ["session", "no.", "reflector", "on link"]
    return table("", head[start:], [row[start:] for row in rows], right=(1 - start, 3 - start))


def inputs(d: Diagnosis, model: ComplianceModel) -> str:
    """Sessions and model."""
    rows = []
    for e, held in zip(d.base.sessions, d.held, strict=True):
        s = e.session
        counts = [f"{len(set(s.samples.setup.tolist()))}", f"{len(held)}", f"{len(s):,}"]
        rows.append([escape(s.source), *counts, s.gravity, s.sha256["samples"][:16]])
    head = ["session", "set-ups", "that took no part", "readings", "gravity", "samples.csv, sha256"]
    told = [["model", escape(f"{model.source}: {', '.join(model.values)}")]]
    for key, value in sorted(model.provenance.items()):
        if isinstance(value, str | int | float):
            told.append([escape(f"{key}"), escape(f"{value}")])
        elif isinstance(value, list):
            told.append([escape(f"{key}"), escape("; ".join(str(v) for v in value)) or DASH])
    return table("", head, rows, right=range(1, 4)) + table("The model at hand", None, told, right=())
