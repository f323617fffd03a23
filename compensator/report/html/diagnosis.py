"""The page of ``diagnose``: what its template shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from compensator.report.analysis.added_pattern import added_patterns
from compensator.report.analysis.remainder import remainder
from compensator.report.analysis.session_residuals import SessionResiduals, session_residuals
from compensator.report.analysis.setup_residuals import largest_setups
from compensator.report.figures.ball_bar import ballbar_figure, has_ballbar
from compensator.report.figures.diagnosis import pattern_figure, ranking_figure, split_figure
from compensator.report.figures.drawing import Warn, drawn, silent
from compensator.report.figures.layout import Figure
from compensator.report.figures.part_arrows import enlarged_by, has_surface, part_figure
from compensator.report.figures.residual_map import enlargement, map_figure
from compensator.report.html import diagnosis_tables as tables
from compensator.report.html.arm_scene import drawn_scene, meaning, of_diagnosis
from compensator.report.html.page import page
from compensator.report.html.trace_tables import stretches, traced
from compensator.report.json.text import Report
from compensator.report.words import diagnosis as words
from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import joined, residual_mm
from stiffness.diagnosis.result import AddedEffect, Diagnosis
from stiffness.model.model import ComplianceModel

MODELS = {"before": "the model at hand", "after": "the refined model"}
SETUPS = 12  # in the menu of the map


@dataclass(frozen=True)
class AddedEffectWords:
    """An effect that was added, in words: the places it is in, the effects that these readings cannot distinguish from
    it ("" for none), and the ids of its figures."""

    effect: str
    where: str
    sentence: str
    alike: str
    figures: tuple[str, ...]


def diagnosis_page(d: Diagnosis, model: ComplianceModel, report: Report, warn: Warn = silent) -> str:
    """The report of a diagnosis.

    Args:
        model: the model at hand.
        report: the JSON report of the same diagnosis, as ``diagnosis_report`` makes it.
        warn: is told of figures that could not be drawn.
    """
    residuals = session_residuals(d, model)
    setups = largest_setups(residuals, SETUPS)
    refined = bool(d.added or d.removed or d.changed)
    failed: list[str] = []
    evidence = _evidence(d, residuals, failed.append)
    circles, part = has_ballbar(d.fit.sessions), has_surface(d.fit.sessions)
    titles = ["the model at hand", "the refined model"] if refined else ["the model at hand"]
    makers: dict[str, Callable[[], Figure]] = {
        "map": lambda: map_figure(setups, titles),
        "split": lambda: split_figure(report),
        **({"ballbar": lambda: ballbar_figure(d.fit.sessions, d.base.sessions)} if circles else {}),
        **({"part": lambda: part_figure(d.fit.sessions, d.base.sessions, refined=refined)} if part else {}),
        **({"ranking": lambda: ranking_figure(d)} if any(c.where for c in d.candidates) else {}),
    }
    figures = {
        **drawn(makers, failed.append),
        **{name: figure for group in evidence for name, figure in group.items()},
        **_remainder(d, residuals, failed.append),
    }
    readings, sessions = of_diagnosis(residuals), [e.session for e in d.fit.sessions]
    scene = drawn_scene(readings, sessions[0].robot, failed.append, refined=refined)
    for sentence in failed:
        warn(sentence)
    verdict, _, verdict_is = words.verdict_sentence(d).partition(": ")
    return page(
        "diagnosis",
        f"Diagnosis: {sessions[0].robot.name}",
        figures,
        scene=scene,
        scene_words={**MODELS, "enlarged": "residuals", "joints": ""},
        meaning=meaning(readings, refined=refined, models=(MODELS["before"], MODELS["after"])),
        verdict=verdict,
        verdict_is=verdict_is,
        additions=[_addition(a, tuple(shown)) for a, shown in zip(d.added, evidence, strict=True)],
        removals=[words.removed_sentence(r) for r in d.removed],
        changes=[_arrows(words.changed_sentence(c)) for c in d.changed[: words.LISTED]],
        before_after=_arrows(words.before_after(report)),
        findings=[*finding_sentences(report), *failed],
        caution=_capital(words.caution(d, report)),
        notes=d.notes,
        refined=refined,
        circles=circles,
        traces=_traces(d, report),
        map={
            "enlarged": f"{enlargement(setups):,.0f}" if setups else "1",
            "setups": len(setups),
            "reflectors": tables.reflectors(sessions),
        },
        split=tables.split(report),
        scores=tables.scores(report),
        candidates=_candidates(d),
        added_numbers=tables.added_numbers(d),
        told_apart=_told_apart(d),
        points_at=tables.attribution(d),
        when_attributed=_when_attributed(d),
        next_setups=tables.next_setups(report),
        changed=tables.changed(d.changed),
        outliers=tables.outliers(d),
        inputs=tables.inputs(d),
        model=tables.model_at_hand(model),
        misfit=residual_mm(d.fit.solution.misfit),
    )


def _traces(d: Diagnosis, report: Report) -> dict[str, Any]:
    """Tables of traces, and how many times the arrows on a part are enlarged; {} where there is no trace."""
    fits = d.fit.sessions
    if not has_surface(fits):
        return {**traced(report)}
    return {**traced(report), "stretches": stretches(fits, d.base.sessions), "enlarged": f"{enlarged_by(fits):,.0f}"}


def _arrows(text: str) -> str:
    return text.replace(" -> ", "\u00a0→\u00a0")


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _evidence(d: Diagnosis, residuals: tuple[SessionResiduals, ...], warn: Warn) -> list[dict[str, Figure]]:
    """Of every addition its figures by their id."""
    out = []
    for k, a in enumerate(d.added):
        made: dict[str, Figure] = {}

        def first(a: AddedEffect = a, k: int = k, made: dict[str, Figure] = made) -> Figure:
            figures = [pattern_figure(p) for p in added_patterns(d, residuals, a)]
            made |= {f"pattern-{k + 1}-{i + 1}": f for i, f in enumerate(figures) if i}
            return figures[0]

        out.append({**drawn({f"pattern-{k + 1}": first}, warn), **made})
    return out


def _remainder(d: Diagnosis, residuals: tuple[SessionResiduals, ...], warn: Warn) -> dict[str, Figure]:
    if d.verdict != "unexplained":
        return {}
    found: list[Figure] = []

    def make() -> Figure:
        rest = remainder(d, residuals)
        found.append({} if rest is None else pattern_figure(rest))
        return found[0]

    shown = drawn({"remainder": make}, warn)
    return {} if found and not found[0] else shown


def _addition(a: AddedEffect, figures: tuple[str, ...]) -> AddedEffectWords:
    return AddedEffectWords(
        effect=a.effect,
        where=joined(a.where),
        sentence=words.added_sentence(a),
        alike=joined(a.confused_with, "or"),
        figures=figures,
    )


def _candidates(d: Diagnosis) -> dict[str, Any]:
    useless = [c.effect for c in d.candidates if not c.where]
    return {"compared": bool(d.candidates), "helpful": tables.candidates(d), "useless": joined(useless)}


def _told_apart(d: Diagnosis) -> str:
    """For the page where no addition can be confused with another effect."""
    asked = d.added or d.verdict == "unexplained"
    return _capital(words.confusion_sentence(d) if asked else "nothing was added")


def _when_attributed(d: Diagnosis) -> str:
    if d.verdict != "unexplained":
        return "before anything was added"
    found = d.added or d.removed or d.changed
    return "with what was found in the model" if found else "with the model's numbers fitted anew"
