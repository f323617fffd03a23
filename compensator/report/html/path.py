"""The page of ``compensate`` and ``preview``: what its template shows."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from compensator.process.milling.milling_load import MillingLoad
from compensator.report.figures.curves import along_figure, flanks_figure, joints_figure
from compensator.report.figures.cut import cut_along_figure, cut_figure
from compensator.report.figures.layout import Figure
from compensator.report.figures.path import path_figure
from compensator.report.figures.thinning import LIMIT
from compensator.report.html import path_tables as tables
from compensator.report.html.page import page
from compensator.report.json.text import Report
from compensator.report.scene.scene import path_scene
from compensator.report.words.cut import band_lines, cut_lines
from compensator.report.words.findings import finding_sentences, note_sentences
from compensator.report.words.numbers import deflection_mm
from compensator.report.words.three_numbers import three_numbers
from compensator.solve.assessment import Assessment
from compensator.solve.compensation import Compensation
from compensator.solve.joint_state import equilibrium_along
from stiffness.effects import CATALOGUE
from toolpaths.finding import ERROR, WARNING

Floats = npt.NDArray[np.float64]


def path_page(
    c: Compensation,
    report: Report,
    after: Floats | None = None,
    *,
    judged: Assessment | None = None,
    texts: Mapping[int, str] | None = None,
) -> str:
    """The report of ``compensate``, or of ``preview`` where the result is not compensated.

    Args:
        report: the JSON report of the run; its ``seconds`` are not shown.
        after: (N,) m, error of every pose with the program as written; without it that of the exact commands.
        judged: how sure the result is. texts: line of the toolpath -> what stands there.
    """
    corrected = c.is_corrected
    before = np.linalg.norm(c.error_before, axis=1) * 1e3
    left = _left(c, after) if corrected else None
    plain = c.uncompensated
    nominal = np.linalg.norm(plain.error_before, axis=1)
    title = "Compensated toolpath" if corrected else "Predicted deflection, not compensated"
    return page(
        "path",
        f"{title}: {c.path.toolpath.source}",
        _figures(c, before, left),
        scene=path_scene(c, report, None if left is None else left / 1e3, judged=judged, texts=texts),
        numbers=three_numbers(report, corrected),
        poses=f"{len(c):,}",
        robot=c.job.arm.robot.name,
        corrected=corrected,
        before=_errors(plain, report, "before", nominal),
        after=None if left is None else _errors(c, report, "after", left),
        correction=_largest_correction(c, report),
        findings=finding_sentences(report, (ERROR, WARNING)),
        notes=note_sentences(report),
        lanes=_lanes(),
        thinned={"poses": f"{len(c):,}", "points": f"{LIMIT:,}"} if len(c) > LIMIT else None,
        errors=tables.errors(report, corrected),
        shares=tables.shares(report),
        facts=tables.facts(report, corrected),
        cut=[*cut_lines(c, report), *band_lines(report)],
        joints=tables.joints(c),
        turnarounds=tables.turnarounds(c, report),
        inputs=tables.inputs(c),
    )


def _left(c: Compensation, after: Floats | None) -> Floats:
    """(N,) mm: what is left with the commands."""
    if after is None:
        prediction, _ = equilibrium_along(
            c.job.arm, c.job.placement.start, c.path.toolpath, q=c.command.q, wrench=c.wrench
        )
        after = np.linalg.norm(prediction.position - c.target.origin, axis=1)
    return np.asarray(after * 1e3)


def _figures(c: Compensation, before: Floats, left: Floats | None) -> dict[str, Figure]:
    scenes = [("not compensated", before)] if left is None else [("before", before), ("after", left)]
    flanks = flanks_figure(c)
    milled = {}
    if isinstance(c.load, MillingLoad):
        milled = {"cut": cut_figure(c, c.load), "cut_along": cut_along_figure(c, c.load)}
    return {
        "path": path_figure(c, scenes),
        **milled,
        "along": along_figure(c, before, left),
        "joints": joints_figure(c),
        **({} if flanks is None else {"flanks": flanks}),
    }


def _errors(c: Compensation, report: Report, key: str, size: Floats) -> dict[str, str]:
    """Mean and largest predicted error in mm, and where the largest of the cutting poses is."""
    cut = np.flatnonzero(c.cutting)
    error = {name: deflection_mm(report["predicted_error_mm"][key][name]) for name in ("mean", "p95", "max")}
    return {**error, "worst": _place(c, int(cut[np.argmax(size[cut])]))}


def _largest_correction(c: Compensation, report: Report) -> dict[str, str]:
    size = np.linalg.norm(c.correction, axis=1)
    return {"size": deflection_mm(report["max_correction_mm"]), "at": _place(c, int(np.argmax(size)))}


def _place(c: Compensation, pose: int) -> str:
    return f"{c.path.toolpath.line_words(pose)}, pose {pose}"


def _lanes() -> list[dict[str, str]]:
    """What the curves of remembered states mean, effect by effect."""
    memories = {e.name: e.memory.meaning for e in CATALOGUE if e.memory and e.memory.meaning}
    return [{"name": name, "meaning": memories[name]} for name in sorted(memories)]
