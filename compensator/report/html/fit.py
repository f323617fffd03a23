"""The page of ``identify``: what its template shows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from compensator.report.analysis.by_joint import JointResiduals, joint_residuals
from compensator.report.analysis.by_reflector import KINDS, reflector_residuals
from compensator.report.analysis.precision import correlation
from compensator.report.analysis.predicted import predicted_sessions
from compensator.report.analysis.standardised import standardised
from compensator.report.figures.drawing import Warn, drawn, silent
from compensator.report.figures.fit import correlation_figure, joints_figure, normal_figure, reflectors_figure
from compensator.report.figures.layout import Figure
from compensator.report.html import fit_tables as tables
from compensator.report.html.arm_scene import drawn_scene, meaning, of_fit
from compensator.report.html.page import page
from compensator.report.html.trace_tables import traced
from compensator.report.json.text import Report
from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import residual_mm
from stiffness.effects import CATALOGUE
from stiffness.identification.fit import Fit

Floats = npt.NDArray[np.float64]

FAR = 3  # standard deviations: beyond lie BEYOND of all values of a normal distribution
BEYOND = 0.0027
MODELS = {"before": "a rigid arm", "after": "this model"}


def fit_page(fit: Fit, report: Report, warn: Warn = silent) -> str:
    """The report of a global fit.

    Args:
        report: the JSON report of the same fit, as ``fit_report`` makes it.
        warn: is told of figures that could not be drawn.
    """
    sessions = predicted_sessions(fit)
    joints, z, correlations = joint_residuals(fit, sessions), standardised(fit), correlation(fit)
    kinds = {kind: found for kind in KINDS if (found := reflector_residuals(sessions, kind))}
    failed: list[str] = []
    makers: dict[str, Callable[[], Figure]] = {
        **({"reflectors": lambda: reflectors_figure(kinds)} if kinds else {}),
        **(_joint_figures(joints) if any(len(j.torque) for j in joints) else {}),
        "normal": lambda: normal_figure(z),
        "correlations": lambda: correlation_figure(fit, correlations),
    }
    figures = drawn(makers, failed.append)
    readings = of_fit(sessions)
    scene = drawn_scene(readings, fit.sessions[0].session.robot, failed.append)
    for sentence in failed:
        warn(sentence)
    geometric, others = _not_identified(report)
    return page(
        "fit",
        f"Identified stiffness: {fit.sessions[0].session.robot.name}",
        figures,
        scene=scene,
        scene_words={**MODELS, "enlarged": "residuals", "joints": ""},
        meaning=meaning(readings, refined=True, models=(MODELS["before"], MODELS["after"])),
        findings=[*finding_sentences(report), *failed],
        readings=_readings(report),
        stiffnesses={"identified": sum(report["identifiable"]), "all": len(report["identifiable"])},
        rms=_rms(report),
        not_identified=others,
        shared=len(geometric),
        misfit=f"{fit.solution.misfit:.2f}" if fit.solution.misfit > 1 else "",
        overall=tables.overall(report["rms_mm"]),
        parameters=tables.parameters(fit),
        reflectors=[tables.reflectors(kind, at) for kind, at in kinds.items()],
        joints=tables.joints(joints),
        standardised=_standardised(z),
        design=tables.design(fit),
        weakest=tables.weakest(fit),
        correlated=tables.correlated(fit, correlations),
        trackers=tables.trackers(fit) if report["tracker_poses"] else None,
        placed=tables.placed(fit) if report["reflectors"] else None,
        traces=traced(report),
        outliers=tables.outliers(fit),
        notes=report["notes"],
        inputs=tables.inputs(fit),
    )


def _joint_figures(joints: list[JointResiduals]) -> dict[str, Callable[[], Figure]]:
    return {"joints": lambda: joints_figure(joints), "joints-after": lambda: joints_figure(joints, enlarged=True)}


def _readings(report: Report) -> dict[str, str]:
    left_out = len(report["outlier_rows"])
    return {"count": f"{report['n_readings']:,}", "left_out": f"{left_out:,}" if left_out else ""}


def _rms(report: Report) -> dict[str, str] | None:
    """RMS of displacements, else of positions; None where there is neither."""
    words = {"displacement": "displacements", "absolute": "positions", "path": "readings along the path"}
    kind = next((k for k in words if report["rms_mm"].get(k)), None)
    if kind is None:
        return None
    return {"what": words[kind], **{k: residual_mm(v) for k, v in report["rms_mm"][kind].items()}}


def _not_identified(report: Report) -> tuple[list[str], list[str]]:
    """Numbers that are not identified: those of constant offsets, of which as a rule only sums are, and the others."""
    names = [f"({e.name})" for e in CATALOGUE if e.joint and e.place and not e.thermal]
    texts: list[str] = report["not_identified"]
    geometric = [text for text in texts if any(name in text for name in names)]
    return geometric, [text for text in texts if text not in geometric]


def _standardised(z: Floats) -> dict[str, str]:
    spread = float(np.sqrt(np.mean(z**2))) if len(z) else 0.0
    return {
        "count": f"{len(z):,}",
        "rms": f"{spread:.3f}",
        "beyond": f"{int(np.sum(np.abs(z) > FAR)):,}",
        "expected": f"{BEYOND * len(z):.1f}",
    }
