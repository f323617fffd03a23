"""The tables of the page of a diagnosis."""

from __future__ import annotations

import numpy as np

from compensator.report.html.table import DASH, Cell, OutlierRows, PageTable, Strong, outlier_rows
from compensator.report.json.text import Report
from compensator.report.words.diagnosis import WRITTEN, followed_words, place_words
from compensator.report.words.numbers import joined, parameter_words, residual_mm, rounded, shown_unit
from stiffness.diagnosis.result import AddedEffect, Diagnosis, MovedParameter
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session

LISTED = 200  # rows that are written out
ALIKE = 3  # names that are written out


def scores(report: Report) -> PageTable:
    """RMS on readings that took no part."""
    rows = []
    for kind, r in report["rms_mm"].items():
        if r is None:
            rows.append([kind, *[DASH] * 5])
            continue
        keys = ("before", "refitted", "after", "noise_floor")
        ratio = f"{r['after'] / r['noise_floor']:.2f}" if r["noise_floor"] > 0 else DASH
        rows.append([kind, *(residual_mm(r[k]) for k in keys), ratio])
    head = ["RMS per axis, mm", "model at hand", "its numbers fitted anew", "refined", "noise floor", "refined / floor"]
    return PageTable(rows, head, right=range(1, 6), caption="On readings that took no part")


def split(report: Report) -> PageTable:
    """What the error before is made of."""
    rows = [
        [kind, *(residual_mm(s[k]) for k in ("noise", "parameters", "structure", "left"))] if s else [kind, *[DASH] * 4]
        for kind, s in report["split_mm"].items()
    ]
    head = ["RMS per axis, mm", "noise", "parameters", "structure", "left after"]
    return PageTable(rows, head, right=range(1, 5))


def added_numbers(d: Diagnosis) -> PageTable:
    """Every number of what was added."""
    rows = [row for a in d.added for name in a.parameters for row in _numbers(a, name)]
    head = ["effect", "number", "of", "unit", "value", "standard deviation"]
    return PageTable(rows, head, right=(4, 5), caption="What was added")


def _numbers(a: AddedEffect, name: str) -> list[list[Cell]]:
    """The rows of one parameter: one number each, or one for all where there are too many."""
    values, sd, unit = a.parameters[name]
    shown, factor = shown_unit(unit)
    what = [a.effect, parameter_words(name)]
    alone = joined(a.where)
    if len(values) > max(WRITTEN, len(a.where)):
        text = f"{len(values)} numbers, in the refined model"
        return [[*what, alone, "", text, ""]] if np.any(values) else []
    spots = [f"{alone}, number {k + 1}" for k in range(len(values))] if len(values) > 1 else [alone]
    spots = list(a.where) if len(values) == len(a.where) else spots
    rows: list[list[Cell]] = []
    for spot, v, s in zip(spots, values * factor, sd * factor, strict=True):
        value, spread = (rounded(v, s), rounded(s, s)) if s > 0 else (f"{v:.4g}", "searched, not fitted")
        rows.append([*what, spot, shown, Strong(value), spread])
    return rows


def candidates(d: Diagnosis) -> PageTable:
    """The ranking, with what is alike."""
    rows = []
    for k, c in enumerate(c for c in d.candidates if c.where):
        cells = [f"{k + 1}", c.effect, joined(c.where), residual_mm(c.heldout_rms * 1e3)]
        more = len(c.confused_with) - ALIKE
        alike = [*c.confused_with[:ALIKE], *([f"{more} more"] if more > 0 else [])]
        rows.append([*cells, joined(alike) or DASH])
    head = ["no.", "effect, by itself", "where it pays", "RMS on set-ups left out, mm", "as good, within chance"]
    return PageTable(rows, head, right=(0, 3))


def attribution(d: Diagnosis) -> PageTable:
    """Where the structure sits and what it follows."""
    rows = [
        [place_words(s.what), f"{100 * s.fraction:.0f} %", followed_words(s.follows) or DASH]
        for s in d.residual_sources
    ]
    return PageTable(rows, ["place or column", "share of the structure", "follows"], right=[1])


def next_setups(report: Report) -> PageTable:
    """What to measure."""
    rows = []
    for k, s in enumerate(report["next_setups"]):
        q = ", ".join(f"{v:.1f}" for v in s["q_deg"])
        wrench = ", ".join(f"{v:.0f}" for v in s["wrench_n_nm"])
        rows.append([f"{k + 1}", q, wrench, joined(s["reflectors"]), s["why"]])
    head = [
        "no.",
        "joint angles, deg",
        "wrench on the robot at the TCP, base axes, N and N·m",
        "watch reflector",
        "why",
    ]
    return PageTable(rows, head, right=[0])


def changed(found: tuple[MovedParameter, ...]) -> PageTable:
    """Numbers that have moved."""
    rows = []
    for c in found:
        unit, factor = shown_unit(c.unit)
        numbers = [rounded(v * factor, c.sd * factor) for v in (c.before, c.after)]
        share = f"{100 * (c.after / c.before - 1):+.1f} %" if c.before else DASH
        names = [c.effect, parameter_words(c.parameter), joined(c.where), unit]
        rows.append([*names, *numbers, rounded(c.sd * factor, c.sd * factor), share])
    head = ["effect", "number", "of", "unit", "in the model", "now", "standard deviation", "change"]
    return PageTable(rows, head, right=range(4, 8))


def outliers(d: Diagnosis) -> OutlierRows:
    """Rows that were left out."""
    rows = [[name, f"{line}"] for name, line in d.outliers]
    return outlier_rows(rows, LISTED, ["session", "line of samples.csv"], right=[1])


def reflectors(sessions: list[Session]) -> PageTable:
    """Numbers of the reflectors in the map."""
    rows = [
        [s.source if len(sessions) > 1 else "", f"{k + 1}", r.name, f"{r.link}"]
        for s in sessions
        for k, r in enumerate(s.reflectors)
    ]
    start = 0 if len(sessions) > 1 else 1
    head = ["session", "no.", "reflector", "on link"]
    return PageTable([row[start:] for row in rows], head[start:], right=(1 - start, 3 - start))


def inputs(d: Diagnosis) -> PageTable:
    """Sessions."""
    rows = []
    for e, held in zip(d.base.sessions, d.held, strict=True):
        s = e.session
        counts = [f"{len(set(s.samples.setup.tolist()))}", f"{len(held)}", f"{len(s):,}"]
        rows.append([s.source, *counts, s.gravity, s.sha256["samples"][:16]])
    head = ["session", "set-ups", "that took no part", "readings", "gravity", "samples.csv, sha256"]
    return PageTable(rows, head, right=range(1, 4))


def model_at_hand(model: ComplianceModel) -> PageTable:
    """The model's file, its effects, and where it comes from."""
    rows = [["model", f"{model.source}: {', '.join(model.values)}"]]
    for key, value in sorted(model.provenance.items()):
        if isinstance(value, str | int | float):
            rows.append([f"{key}", f"{value}"])
        elif isinstance(value, list):
            rows.append([f"{key}", "; ".join(str(v) for v in value) or DASH])
    return PageTable(rows, caption="The model at hand")
