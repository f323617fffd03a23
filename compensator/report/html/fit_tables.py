"""The tables of the report of a fit. Everything that comes from a file is escaped here."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from compensator.report.html.tables import table
from compensator.report.views.fit import AtJoint, AtReflector
from stiffness.identification.fit import Fit
from stiffness.identification.scores import rms
from stiffness.identification.unknowns import Unknown

Floats = npt.NDArray[np.float64]

NORMAL_95 = 1.959964  # half width of a 95 % interval in standard deviations
LISTED = 200  # rows that are written out
STRONGEST = 8
DASH = "\u2013"  # no value
IN_WORDS = 0.5  # correlations from here on are called large
SHOWN_IN = {"m": ("mm", 1e3), "rad": ("mrad", 1e3)}


def figure(value: float, sd: float) -> str:
    """A number with as many digits as its standard deviation leaves: two of them."""
    if not np.isfinite(value):
        return "∞" if value > 0 else "-∞"
    if not (np.isfinite(sd) and sd > 0):
        return f"{value:.6g}"
    digits = 1 - int(np.floor(np.log10(sd)))
    if digits > 9:
        return f"{value:.4g}"
    return f"{round(value, digits) + 0.0:,.{max(digits, 0)}f}"


def interval(u: Unknown, value: float, sd: float) -> tuple[float, float]:
    """95 % interval of a number as the model file has it, from ``value`` and ``sd`` as the solver sees them.

    Where the solver sees the inverse, that is what is normally distributed: the interval is not symmetric.
    """
    low, high = value - NORMAL_95 * sd, value + NORMAL_95 * sd
    if not u.inverse:
        return low, high
    return 1 / high, 1 / low if low > 0 else float("inf")


def parameters(fit: Fit) -> str:
    """Every fitted number with standard deviation and interval, or why it is none; what was given."""
    reasons = iter(fit.not_identified())
    deviations, values = fit.deviations(), fit.values()
    rows = []
    for u, vector, sd, ok in zip(fit.unknowns.free, fit.parameters, fit.sd, fit.determined(), strict=True):
        unit, factor = SHOWN_IN.get(u.parameter.unit, (u.parameter.unit, 1.0))
        effect, unit = escape(u.effect).replace("-", "\u2011"), escape(unit.replace("*", "·"))
        head = [effect, escape(_meaning(u)), place_of(u), unit]
        if not ok:
            why = escape(next(reasons).rsplit(": ", 1)[-1])
            rows.append([*head, DASH, DASH, DASH, f"<b>not identified</b>: {why}"])
            continue
        value = float(values[u.effect][u.parameter.name][u.index]) * factor
        spread = float(deviations[u.effect][u.parameter.name][u.index]) * factor
        low, high = (v * factor for v in interval(u, float(vector), float(sd)))
        between = f"{figure(low, spread)} … {figure(high, spread)}"
        rows.append([*head, f"<b>{figure(value, spread)}</b>", figure(spread, spread), between, "identified"])
    head = ["effect", "number", "of", "unit", "value", "standard deviation", "95 % interval", ""]
    return table("Fitted numbers", head, rows + _given(fit), right=(4, 5, 6))


def _given(fit: Fit) -> list[list[str]]:
    free = {(u.effect, u.parameter.name) for u in fit.unknowns.free}
    rows = []
    for e in fit.unknowns.effects:
        for p in e.parameters:
            if (e.name, p.name) not in free:
                unit, factor = SHOWN_IN.get(p.unit, (p.unit, 1.0))
                values = np.unique(fit.values()[e.name][p.name] * factor)
                text = ", ".join(f"{v:.6g}" for v in values)
                where = "all joints" if p.size == "joint" else "all"
                unit = escape(unit.replace("*", "·"))
                rows.append([escape(e.name), escape(p.meaning), where, unit, text, DASH, DASH, "given, not fitted"])
    return rows


def place_of(u: Unknown) -> str:
    """Which of the numbers of a parameter."""
    return f"joint\u00a0{u.index + 1}" if u.parameter.size == "joint" else f"number\u00a0{u.index + 1}"


def named(u: Unknown) -> str:
    """A fitted number in words, escaped."""
    return escape(f"{_meaning(u)} of {place_of(u)}")


def _meaning(u: Unknown) -> str:
    return u.parameter.meaning.removesuffix(" per joint")


def overall(rms_mm: dict[str, Any]) -> str:
    """RMS of everything, rigid and fitted."""
    rows = []
    for kind in ("displacement", "absolute"):
        of = rms_mm.get(kind)
        cells = [DASH] * 4 if of is None else [millimetres(of[k]) for k in ("rigid", "fitted", "noise_floor")]
        if of is not None:
            cells.append(f"{of['fitted'] / of['noise_floor']:.2f}" if of["noise_floor"] > 0 else DASH)
        rows.append([kind, *cells])
    head = ["RMS per axis, mm", "rigid", "fitted", "noise floor", "fitted / floor"]
    return table("Residuals of the readings that were used", head, rows, right=range(1, 5))


def millimetres(value: float) -> str:
    """Four significant digits, no exponent down to a nanometre."""
    if value == 0 or not np.isfinite(value):
        return f"{value:g}"
    return f"{value:.{int(np.clip(3 - np.floor(np.log10(abs(value))), 0, 6))}f}"


def reflectors(kind: str, at: list[AtReflector]) -> str:
    """RMS per reflector; the numbers are those of the figure."""
    rows = []
    for k, a in enumerate(at):
        three = [millimetres(v * 1e3) for v in (a.rigid, a.fitted, a.floor)]
        rows.append([f"{k + 1}", escape(a.name), f"{a.link}", f"{a.count:,}", *three])
    head = ["no.", "reflector", "link", "readings", "rigid", "fitted", "noise floor"]
    return table(f"{kind.capitalize()}, RMS per axis, mm", head, rows, right=range(2, 7))


def joints(at: list[AtJoint]) -> str:
    """How much of the displacements that load a joint is left along its motion."""
    rows = []
    for j, a in enumerate(at):
        cells = [DASH] * 3
        if len(a.torque):
            cells = [f"{np.abs(a.torque).max():,.0f}", *(millimetres(rms(v) * 1e3) for v in (a.rigid, a.fitted))]
        rows.append([f"{j + 1}", f"{len(a.torque):,}", *cells])
    head = ["joint", "displacements that load it", "largest torque, N·m", "rigid, RMS mm", "fitted, RMS mm"]
    return table("Residual displacement along the motion of each joint", head, rows, right=range(5))


def design(fit: Fit, condition: float) -> str:
    """Condition number and observability indices of the design."""
    values = singular(fit)[0]
    count, smallest, largest = fit.solution.count, values[0], values[-1]
    rows = [
        ["condition number: largest over smallest singular value", f"{condition:.4g}"],
        ["O1: geometric mean of the singular values / √readings", _index(values, count)],
        ["O2: smallest / largest singular value", f"{smallest / largest:.4g}"],
        ["O3: smallest singular value", f"{smallest:.4g}"],
        ["O4: smallest² / largest singular value", f"{smallest**2 / largest:.4g}"],
        ["numbers read", f"{count:,}"],
        ["degrees of freedom left", f"{fit.solution.freedom:,.0f}"],
        ["spread of the residuals / that of the instruments, where it widens", f"{fit.solution.misfit:.3f}"],
    ]
    return table("Design, every number scaled to its typical size", None, rows, right=[1])


def _index(values: Floats, count: int) -> str:
    mean = float(np.exp(np.mean(np.log(np.maximum(values, 1e-300)))))
    return f"{mean / np.sqrt(max(count, 1)):.4g}"


def singular(fit: Fit) -> tuple[Floats, Floats]:
    """Singular values (P,) of the scaled design, ascending, and their directions (P, P) as columns."""
    n, scale = len(fit.unknowns), fit.unknowns.scale
    squares, directions = np.linalg.eigh(fit.solution.information[:n, :n] * np.outer(scale, scale))
    return np.sqrt(np.maximum(squares, squares[-1] * 1e-32)), directions


def correlation(fit: Fit) -> Floats:
    """(P, P) of the robot's numbers."""
    n = len(fit.unknowns)
    covariance = fit.solution.covariance[:n, :n]
    sd = np.sqrt(np.diag(covariance))
    # of the numbers as the model file has them: an inverse turns the sign
    sign = np.where(fit.unknowns.inverse, -1.0, 1.0)
    return np.asarray(covariance / np.outer(sd, sd) * np.outer(sign, sign))


def weakest(fit: Fit) -> str:
    """The combination of numbers that the data say least of, in words."""
    direction = singular(fit)[1][:, 0]
    share = direction**2
    top = [int(k) for k in np.argsort(-share, kind="stable")[:4] if share[k] > 0.05]
    parts = ", ".join(f"{named(fit.unknowns.free[k])} ({100 * share[k]:.0f} %)" for k in top)
    return f"<p>The combination that the readings say least of is made of: {parts}.</p>"


def largest_correlations(fit: Fit, matrix: Floats) -> str:
    """Pairs of numbers that the data hardly tell apart, strongest first."""
    rows, columns = np.triu_indices(len(matrix), 1)
    size = np.abs(matrix[rows, columns])
    order = [int(k) for k in np.argsort(-np.round(size, 9), kind="stable") if size[k] >= IN_WORDS]
    if not order:
        top = f" (the largest is {size.max():.2f})" if len(size) else ""
        return f"<p>No two numbers are correlated by {IN_WORDS} or more{top}.</p>"
    free = fit.unknowns.free
    items = "".join(
        f"<li>{matrix[rows[k], columns[k]]:+.3f}: {named(free[rows[k]])} and {named(free[columns[k]])}</li>"
        for k in order[:STRONGEST]
    )
    more = f"<p>… and {len(order) - STRONGEST:,} more pairs.</p>" if len(order) > STRONGEST else ""
    return f"<p>Correlations of {IN_WORDS} or more, largest first:</p>\n<ul>{items}</ul>{more}"


def outliers(fit: Fit) -> str:
    """Rows that were left out."""
    rows = []
    for e in fit.sessions:
        s = e.samples
        for k in np.flatnonzero(~e.used):
            name = e.session.reflectors[int(s.reflector[k])].name
            cells = [f"{s.line[k]}", f"{s.setup[k]}", f"{s.state[k]}", f"{s.repeat[k]}", escape(name)]
            rows.append([escape(e.session.source), *cells])
    if not rows:
        return "<p>No row was left out: none is contradicted by the others.</p>"
    text = f"<p>{len(rows):,} rows, contradicted by all others, were left out of the fit and of every figure here.</p>"
    more = len(rows) - LISTED
    tail = f"<p>… and {more:,} more, all of them in the JSON report.</p>" if more > 0 else ""
    head = ["session", "line of samples.csv", "set-up", "state", "repeat", "reflector"]
    return text + table("", head, rows[:LISTED], right=range(1, 5)) + tail


def inputs(fit: Fit) -> str:
    """Sessions."""
    rows = []
    for e in fit.sessions:
        s = e.session
        place = "in the base" if s.registered else f"tracker placed {len(np.unique(s.samples.block))} times by the fit"
        counts = [f"{len(np.unique(s.samples.setup))}", f"{len(s.states)}", f"{len(s):,}", f"{int(e.used.sum()):,}"]
        rows.append([escape(s.source), *counts, s.gravity, place, f"{s.sha256['samples'][:16]}"])
    head = ["session", "set-ups", "states", "readings", "used", "gravity", "positions", "samples.csv, sha256"]
    return table("", head, rows, right=range(1, 5))
