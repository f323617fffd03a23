"""The tables of the page of a fit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.by_joint import JointResiduals
from compensator.report.analysis.by_reflector import ReflectorResiduals
from compensator.report.analysis.precision import interval
from compensator.report.html.table import DASH, Cell, OutlierRows, PageTable, Strong, outlier_rows
from compensator.report.words.numbers import residual_mm, rounded, shown_unit, with_sd
from stiffness.identification.fit import Fit
from stiffness.identification.placed_station import placed_reflectors, placed_trackers
from stiffness.identification.scores import rms
from stiffness.identification.unknowns import Unknown

Floats = npt.NDArray[np.float64]

LISTED = 200  # rows that are written out
STRONGEST = 8
UNSEEN = "angles that no reading has"  # why a number of a table is not identified; Fit lists tables behind all others
NO_BREAK_HYPHEN = "\u2011"
LARGE = 0.5  # correlations from here on are called large


def parameters(fit: Fit) -> PageTable:
    """Every fitted number with standard deviation and interval, or why it is none; what was given."""
    reasons = iter(fit.not_identified())
    deviations, values = fit.deviations(), fit.values()
    rows: list[list[Cell]] = []
    for u, vector, sd, ok in zip(fit.unknowns.free, fit.parameters, fit.sd, fit.determined(), strict=True):
        unit, factor = shown_unit(u.parameter.unit, rates=False)
        head = [u.effect.replace("-", NO_BREAK_HYPHEN), _meaning(u), place_of(u), unit]
        if not ok:
            why = UNSEEN if u.parameter.each > 1 else next(reasons).rsplit(": ", 1)[-1]
            rows.append([*head, DASH, DASH, DASH, Strong("not identified", f": {why}")])
            continue
        value = float(values[u.effect][u.parameter.name][u.index]) * factor
        spread = float(deviations[u.effect][u.parameter.name][u.index]) * factor
        low, high = (v * factor for v in interval(u, float(vector), float(sd)))
        between = f"{rounded(low, spread)} … {rounded(high, spread)}"
        rows.append([*head, Strong(rounded(value, spread)), rounded(spread, spread), between, "identified"])
    head = ["effect", "number", "of", "unit", "value", "standard deviation", "95 % interval", ""]
    return PageTable(rows + _given(fit), head, right=(4, 5, 6), caption="Fitted numbers")


def _given(fit: Fit) -> list[list[Cell]]:
    free = {(u.effect, u.parameter.name) for u in fit.unknowns.free}
    rows: list[list[Cell]] = []
    for e in fit.unknowns.effects:
        for p in e.parameters:
            if (e.name, p.name) not in free:
                unit, factor = shown_unit(p.unit, rates=False)
                values = np.unique(fit.values()[e.name][p.name] * factor)
                text = ", ".join(f"{v:.6g}" for v in values)
                where = "all joints" if p.size == "joint" else "all"
                rows.append([e.name, p.meaning, where, unit, text, DASH, DASH, "given, not fitted"])
    return rows


def place_of(u: Unknown) -> str:
    """Which of the numbers of a parameter."""
    return f"joint\u00a0{u.index + 1}" if u.parameter.size == "joint" else f"number\u00a0{u.index + 1}"


def named(u: Unknown) -> str:
    """A fitted number in words."""
    return f"{_meaning(u)} of {place_of(u)}"


def _meaning(u: Unknown) -> str:
    return u.parameter.meaning.removesuffix(" per joint")


def overall(rms_mm: dict[str, Any]) -> PageTable:
    """RMS of everything, rigid and fitted."""
    rows = []
    for kind in ("displacement", "absolute", "path"):
        of = rms_mm.get(kind)
        cells = [DASH] * 4 if of is None else [residual_mm(of[k]) for k in ("rigid", "fitted", "noise_floor")]
        if of is not None:
            cells.append(f"{of['fitted'] / of['noise_floor']:.2f}" if of["noise_floor"] > 0 else DASH)
        rows.append([kind, *cells])
    head = ["RMS per axis, mm", "rigid", "fitted", "noise floor", "fitted / floor"]
    return PageTable(rows, head, right=range(1, 5), caption="Residuals of the readings that were used")


def reflectors(kind: str, at: list[ReflectorResiduals]) -> PageTable:
    """RMS per reflector; the numbers are those of the figure."""
    rows = []
    for k, a in enumerate(at):
        three = [residual_mm(v * 1e3) for v in (a.rigid, a.fitted, a.floor)]
        rows.append([f"{k + 1}", a.name, f"{a.link}", f"{a.count:,}", *three])
    head = ["no.", "reflector", "link", "readings", "rigid", "fitted", "noise floor"]
    return PageTable(rows, head, right=range(2, 7), caption=f"{kind.capitalize()}, RMS per axis, mm")


def joints(at: list[JointResiduals]) -> PageTable:
    """How much of the displacements that load a joint is left along its motion."""
    rows = []
    for j, a in enumerate(at):
        cells = [DASH] * 3
        if len(a.torque):
            cells = [f"{np.abs(a.torque).max():,.0f}", *(residual_mm(rms(v) * 1e3) for v in (a.rigid, a.fitted))]
        rows.append([f"{j + 1}", f"{len(a.torque):,}", *cells])
    head = ["joint", "displacements that load it", "largest torque, N·m", "rigid, RMS mm", "fitted, RMS mm"]
    caption = "Residual displacement along the motion of each joint"
    return PageTable(rows, head, right=range(5), caption=caption)


def design(fit: Fit) -> PageTable:
    """Condition number and observability indices of the design."""
    of, condition = fit.observability(), fit.condition_number()
    rows = [
        ["directions that the readings determine", f"{of['determined']} of {len(fit.unknowns)}"],
        ["condition number: largest over smallest singular value", DASH if condition is None else f"{condition:.4g}"],
        ["O1: geometric mean of the singular values / √readings", f"{of['o1']:.4g}"],
        ["O2: smallest / largest singular value", f"{of['o2']:.4g}"],
        ["O3: smallest singular value / √readings", f"{of['o3']:.4g}"],
        ["O4: smallest² / largest singular value / √readings", f"{of['o4']:.4g}"],
        ["numbers read", f"{fit.solution.count:,}"],
        ["degrees of freedom left", f"{fit.solution.freedom:,.0f}"],
        ["spread of the residuals / that of the instruments, where it widens", f"{fit.solution.misfit:.3f}"],
    ]
    caption = "Design, every number scaled to its typical size, in the directions that are determined"
    return PageTable(rows, right=[1], caption=caption)


def weakest(fit: Fit) -> list[str]:
    """The combination of numbers that the readings determine least of those that they determine, as its largest
    parts; none where they determine nothing."""
    directions = fit.gauge.singular[1]
    if not directions.shape[1]:
        return []
    share = directions[:, 0] ** 2
    top = [int(k) for k in np.argsort(-share, kind="stable")[:4] if share[k] > 0.05]
    return [f"{named(fit.unknowns.free[k])} ({100 * share[k]:.0f} %)" for k in top]


def trackers(fit: Fit) -> PageTable:
    """Tracker poses as the fit has them."""
    rows = []
    for t in placed_trackers(fit):
        place = [f"{with_sd(v * 1e3, s * 1e3)}" for v, s in zip(t.origin, t.origin_sd, strict=True)]
        turn = [f"{with_sd(np.degrees(v), np.degrees(s))}" for v, s in zip(t.rpy, t.rotation_sd, strict=True)]
        rows.append([t.session, f"{t.block}", *place, *turn])
    head = ["session", "block", "x, mm", "y, mm", "z, mm", "roll, deg", "pitch, deg", "yaw, deg"]
    return PageTable(rows, head, right=range(1, 8), caption="Tracker in the base, with standard deviations")


def placed(fit: Fit) -> PageTable:
    """Reflectors whose places the fit has estimated."""
    rows = [
        [r.session, r.name, f"{r.link}", *(with_sd(v * 1e3, s * 1e3) for v, s in zip(r.position, r.sd, strict=True))]
        for r in placed_reflectors(fit)
    ]
    head = ["session", "reflector", "link", "x, mm", "y, mm", "z, mm"]
    return PageTable(rows, head, right=range(2, 6), caption="Reflectors in their links, with standard deviations")


@dataclass(frozen=True)
class Correlated:
    """Pairs of numbers with a correlation of ``least`` or more, strongest first, and how many more there are ("" for
    none); ``largest`` of all correlations, where it is below."""

    least: str
    pairs: list[str]
    more: str
    largest: str


def correlated(fit: Fit, matrix: Floats) -> Correlated:
    """Pairs of numbers that the readings hardly tell apart, from their correlations (P, P)."""
    rows, columns = np.triu_indices(len(matrix), 1)
    size = np.abs(matrix[rows, columns])
    order = [int(k) for k in np.argsort(-np.round(size, 9), kind="stable") if size[k] >= LARGE]
    free = fit.unknowns.free
    pairs = [
        f"{matrix[rows[k], columns[k]]:+.3f}: {named(free[rows[k]])} and {named(free[columns[k]])}"
        for k in order[:STRONGEST]
    ]
    more = f"{len(order) - STRONGEST:,}" if len(order) > STRONGEST else ""
    return Correlated(f"{LARGE}", pairs, more, f"{size.max():.2f}" if len(size) and not order else "")


def outliers(fit: Fit) -> OutlierRows:
    """Rows that were left out."""
    rows = []
    for e in fit.sessions:
        s = e.samples
        for k in np.flatnonzero(~e.used):
            name = e.session.reflectors[int(s.reflector[k])].name
            rows.append([e.session.source, f"{s.line[k]}", f"{s.setup[k]}", f"{s.state[k]}", f"{s.repeat[k]}", name])
    head = ["session", "line of samples.csv", "set-up", "state", "repeat", "reflector"]
    return outlier_rows(rows, LISTED, head, right=range(1, 5))


def inputs(fit: Fit) -> PageTable:
    """Sessions."""
    rows = []
    for e in fit.sessions:
        s = e.session
        place = "in the base" if s.registered else f"tracker placed {len(np.unique(s.samples.block))} times by the fit"
        counts = [f"{len(np.unique(s.samples.setup))}", f"{len(s.states)}", f"{len(s):,}", f"{int(e.used.sum()):,}"]
        rows.append([s.source, *counts, s.gravity, place, f"{s.sha256['samples'][:16]}"])
    head = ["session", "set-ups", "states", "readings", "used", "gravity", "positions", "samples.csv, sha256"]
    return PageTable(rows, head, right=range(1, 5))
