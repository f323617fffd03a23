"""A diagnosis in words, as plain text: what the terminal shows, and the sentences of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensator.report.words.numbers import LENGTHS, joined, parameter_words, residual_mm, rounded, shown_unit, with_sd
from compensator.report.words.trace import trace_sentences
from stiffness.diagnosis.attribution import ResidualSource
from stiffness.diagnosis.result import AddedEffect, Diagnosis, MovedParameter, RemovedEffect
from stiffness.effects import BY_NAME

WRITTEN = 6  # numbers of an addition that a line has room for
LISTED = 3
PLACES = 2
CONSTANT = "always the same"
NEAR = 1.1  # times the noise
KINDS = {"displacement": "displacements under load", "absolute": "positions", "path": "readings along the path"}
Report = dict[str, Any]


def diagnosis_lines(d: Diagnosis, report: Report) -> list[str]:
    """About ten lines that tell the whole story."""
    lines = [verdict_sentence(d)]
    lines += [
        f"{KINDS[kind]}, RMS per axis: {split_sentence(report, kind)}" for kind in KINDS if report["split_mm"][kind]
    ]
    lines += [f"added: {added_sentence(a)}" for a in d.added]
    lines += [f"removed: {removed_sentence(r)}" for r in d.removed]
    lines += [f"changed: {changed_sentence(c)}" for c in d.changed[:LISTED]]
    if len(d.changed) > LISTED:
        lines.append(f"changed: and {len(d.changed) - LISTED} more numbers")
    lines.append(f"on readings that took no part: {before_after(report)}")
    if d.added or d.verdict == "unexplained":
        lines.append(confusion_sentence(d))
    lines.append(place_sentence(d))
    lines += trace_sentences(report)
    lines += [f"trace next: {text}" for text in d.next_traces]
    if d.next_setups:
        lines.append(f"measure next: {next_sentence(report)}")
    lines.append(caution(d, report))
    return [*lines, *(f"  - {note}" for note in d.notes)]


def verdict_sentence(d: Diagnosis) -> str:
    """The verdict, one sentence."""
    names = joined([f"{a.effect} in {joined(a.where)}" for a in d.added])
    gone = joined([f"{r.effect} in {joined(r.where)}" for r in d.removed])
    if d.verdict == "explained":
        misfit = d.fit.solution.misfit
        left = "nothing is left but noise" if misfit < NEAR else f"what is left is {misfit:.2f} times the noise"
        lacks = [f"the model lacks {names}"] if names else []
        return f"Explained: {joined([*lacks, *([f'needs no {gone}'] if gone else [])])}; then {left}."
    if d.verdict == "parameters-changed":
        return f"Parameters changed: no effect is missing, but {_moved(d.changed)} moved since the model was made."
    if d.verdict == "adequate" and d.known_better:
        return "Adequate: no effect is missing, and no number has moved beyond what the model leaves open."
    if d.verdict == "adequate":
        return "Adequate: what the model leaves is what noise leaves."
    if d.verdict == "insufficient-data":
        return "Insufficient data: these readings cannot tell whether the model lacks anything."
    also = f" beside {names}, which was added" if names else ""
    return f"Unexplained: there is structure that no known effect explains{also}{_sits(d.residual_sources)}."


def removed_sentence(r: RemovedEffect) -> str:
    """An effect of the model that is not there, one sentence."""
    return f"{r.effect} in {joined(r.where)}: {r.why}"


def _sits(points: Sequence[ResidualSource]) -> str:
    """The place with the largest share, and what it follows: a column with a larger share, else its own features."""
    place = next((s for s in points if s.is_place), None)
    column = next((s for s in points if not s.is_place), None)
    if place is None:
        return f"; it follows {place_words(column.what)}" if column else ""
    leads = column is not None and column.fraction > place.fraction
    follows = place_words(column.what) if column is not None and leads else followed_words(place.follows, 1)
    return f"; it sits at {place.what}" + (f" and follows {follows}" if follows else "")


def followed_words(follows: str, most: int = 2) -> str:
    """What a share follows."""
    varying = [f for f in follows.split("; ") if f != CONSTANT]
    return joined(varying[:most]) or "nothing that varies"


def _moved(changed: Sequence[MovedParameter]) -> str:
    names = list(dict.fromkeys(f"{c.effect} of {joined(c.where)}" for c in changed))
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    verb = "has" if len(names) == 1 else "have"
    return f"{', '.join(names[:LISTED])}{more} {verb}"


def place_words(what: str) -> str:
    """A place or a column of the session in words."""
    if what.startswith("column:"):
        name = what.removeprefix("column:")
        if name[:1] == "q" and name[1:].isdigit():
            return f"the angle of joint {name[1:]}"
        if name.startswith("approach"):
            return f"the approach of joint {name.removeprefix('approach')}"
        return "the order of loads" if name == "state" else f"the column {name}"
    return {"process": "the programmed force", "arc-length": "the length of the path"}.get(what, what)


def split_sentence(report: Report, kind: str) -> str:
    """Noise, parameters, structure of one kind of evidence."""
    s = {k: f"{residual_mm(v)} mm" for k, v in report["split_mm"][kind].items()}
    chance = ", no more than chance" if report["verdict"] in ("adequate", "parameters-changed") else ""
    return (
        f"noise {s['noise']}, the model's own parameters {s['parameters']}, structure that it does not know "
        f"{s['structure']}{chance}"
    )


def added_sentence(a: AddedEffect) -> str:
    """Where, how large, how much of the residual goes with it."""
    text = f"{a.effect} in {joined(a.where)}: {added_numbers(a)}"
    return f"{text}; it takes {100 * a.explains:.0f} % of what was above the noise" if a.explains > 0 else text


def added_numbers(a: AddedEffect) -> str:
    """The numbers of an addition, as many as a line has room for."""
    told, left = [], 0
    for name, (values, sd, unit) in a.parameters.items():
        if unit == "1" and not np.any(sd):  # chosen, not fitted: the table has it
            continue
        what, (shown, factor) = parameter_words(name), shown_unit(unit)
        if len(values) > WRITTEN and unit in LENGTHS:  # a table
            told.append(f"{what} up to {np.abs(values).max() * factor:.3g} {shown} ({len(values)} numbers)")
            continue
        if len(values) > WRITTEN or not np.any(values):
            left += len(values) * bool(np.any(values))
            continue
        numbers = [with_sd(v * factor, s * factor) for v, s in zip(values, sd, strict=True)]
        told.append(f"{what} {', '.join(numbers)}{'' if shown == '1' else ' ' + shown}")
    return "; ".join(told) + (f"; {left} further numbers" if left else "")


def changed_sentence(c: MovedParameter) -> str:
    """From, to."""
    unit, factor = shown_unit(c.unit)
    tail = "" if unit == "1" else f" {unit}"
    before, after = rounded(c.before * factor, c.sd * factor), with_sd(c.after * factor, c.sd * factor)
    return f"{c.effect} of {joined(c.where)}, {parameter_words(c.parameter)}: {before} -> {after}{tail}"


def before_after(report: Report) -> str:
    """Both kinds of evidence."""
    parts = []
    for kind, words in KINDS.items():
        rms = report["rms_mm"][kind]
        if rms:
            m = {k: residual_mm(v) for k, v in rms.items()}
            parts.append(f"{words} {m['before']} -> {m['after']} mm (noise alone: {m['noise_floor']})")
    return "; ".join(parts) or "none"


def confusion_sentence(d: Diagnosis) -> str:
    """Effects that these readings cannot distinguish."""
    alike = [f"{a.effect} from {joined(a.confused_with, 'or')}" for a in d.added if a.confused_with]
    if alike:
        return f"not told apart by these readings: {'; '.join(alike)}"
    if d.added:
        return "no other effect of the catalogue explains these readings as well"
    there = [c for c in d.candidates if c.where]
    if not there:
        return "no effect of the catalogue makes any of it better"
    best = f"{there[0].effect} in {joined(there[0].where[:LISTED])}"
    return f"nearest in the catalogue, but not the explanation: {best}"


def place_sentence(d: Diagnosis) -> str:
    """Where the rest sits, or where what was found had been."""
    if not d.residual_sources:
        return "no place and no column carries any structure: the rest is noise"
    told = ", ".join(share_words(s) for s in d.residual_sources[:PLACES])
    before = "the rest sits at" if d.verdict == "unexplained" else "before, the structure sat at"
    return f"{before} {told}"


def share_words(s: ResidualSource) -> str:
    """A place, its share, and what it follows."""
    follows = f", follows {followed_words(s.follows)}" if s.follows else ""
    return f"{place_words(s.what)} ({100 * s.fraction:.0f} %{follows})"


def next_sentence(report: Report) -> str:
    """The first set-up, and how many more."""
    first, *more = report["next_setups"]
    q = ", ".join(f"{v:.0f}" for v in first["q_deg"])
    force = ", ".join(f"{v:.0f}" for v in first["wrench_n_nm"][:3])
    text = f"joints at ({q}) deg, force ({force}) N, reflector {joined(first['reflectors'])}: {first['why']}"
    return f"{text}; {len(more)} more in the report" if more else text


def caution(d: Diagnosis, report: Report) -> str:
    """What is not modelled, or not certain."""
    told = []
    if d.verdict == "unexplained":
        told.append("what is left is in no model: a path compensated with it keeps that error")
    if report["not_applied"]:
        told.append(f"of another tool, so not judged: {joined(report['not_applied'])}")
    instruments = [a.effect for a in d.added if BY_NAME[a.effect].scope == "instruments"]
    if instruments:
        told.append(f"{joined(instruments)} concerns the instruments and is never applied to a path")
    if d.outliers:
        told.append(f"{len(d.outliers)} readings are contradicted by all others and count for nothing")
    if not d.added and d.verdict in ("adequate", "parameters-changed"):
        told.append("effects that these postures, loads and reflectors do not show cannot be excluded")
    for score in d.known_better[:1]:
        told.append(
            f"the model's numbers, which leave {residual_mm(1e3 * score.before.rms)} mm where "
            f"{residual_mm(1e3 * score.refitted.rms)} mm would do, no more than their standard deviations allow: "
            "identify --prior takes them from these readings"
        )
    told = told or ["what was added holds where these readings were taken: beyond their loads and angles it is a guess"]
    return f"not certain: {'; '.join(told)}"

