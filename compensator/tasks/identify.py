"""Identify and evaluate, from files to files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator.report.json.evaluation import evaluation_report
from compensator.report.json.fit import fit_report, local_fit_report
from compensator.report.json.text import as_json
from compensator.solve.unlearned_angles import AngleUncertainty, NotLearned
from compensator.tasks.declared_mass import declared_masses, mass_findings
from compensator.tasks.measurements import in_terms_of, load_measurement, load_measurements
from compensator.tasks.outputs import Outputs
from compensator.tasks.page_last import write_with_page
from compensator.tasks.robot_reference import refuse_other_robot, robot_beside
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from compensator.version import version
from stiffness.errors import StiffnessError
from stiffness.identification.evaluate import Evaluation, evaluate, shown_effects
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.local_method.fit import LocalFit
from stiffness.local_method.identify import identify_local
from stiffness.model.counted_twice import KEY
from stiffness.model.model import ComplianceModel, load_model, model_text
from stiffness.session.session import Session


@dataclass(frozen=True, repr=False)
class Identified:
    """A fit, its JSON report, the files that were written, and ``warnings`` about these."""

    fit: Fit | LocalFit
    report: dict[str, Any]
    files: tuple[Path, ...]
    warnings: tuple[str, ...] = ()


@writes("output", "json", "html")
def identify_files(
    sessions: Sequence[Path],
    output: Path,
    *,
    method: str = "global",
    effects: Sequence[str] | None = None,
    prior: Path | None = None,
    json: Path | None = None,
    html: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Identified:
    """Sessions in, a model file out.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    if method == "local" and (effects is not None or prior is not None):
        raise StiffnessError("--method local takes no --effects and no --prior: it fits the joints one by one")
    say("reading the sessions")
    loaded = load_measurements(sessions)
    if method == "local" and any(s.path is not None for s in loaded):
        raise StiffnessError("--method local takes sessions of set-ups, no traces: leave the traces to --method global")
    if method == "local" and html is not None:
        raise StiffnessError("--report shows a global fit; --method local has none: read the notes in --json instead")
    if method == "local":
        return _identify_local(loaded, output, json, strict=strict)
    known = None if prior is None else load_model(prior, loaded[0].robot.n)
    if known is not None:
        refuse_other_robot(loaded[0], known)
        loaded = [in_terms_of(session, known) for session in loaded]
    say("fitting")
    fit = identify(loaded, effects, known)
    report = fit_report(fit)
    refuse_warnings(report, strict)
    model = fitted_model(fit, loaded[0], output, prior)
    texts = [(output, model_text(model)), *([(json, as_json(report))] if json else [])]
    warnings = write_with_page(texts, html, lambda warn: _page(fit, report, warn), strict=strict)
    return Identified(fit, report, tuple(p for p in (output, json, html) if p), warnings)


def _page(fit: Fit, report: dict[str, Any], warn: Callable[[str], None]) -> str:
    from compensator.report.html.fit import fit_page

    return fit_page(fit, report, warn)


def _identify_local(loaded: Sequence[Session], output: Path, json: Path | None, *, strict: bool) -> Identified:
    fit = identify_local(*loaded)
    model = fitted_model(fit, loaded[0], output)
    report = local_fit_report(fit, model)
    refuse_warnings(report, strict)
    texts = [(output, model_text(model)), *([(json, as_json(report))] if json else [])]
    write_with_page(texts, None, lambda warn: "")
    return Identified(fit, report, tuple(path for path, _ in texts))


def fitted_model(fit: Fit | LocalFit, session: Session, output: Path, prior: Path | None = None) -> ComplianceModel:
    """The model of a fit, as the file ``output`` has to hold it.

    Args:
        session: one of those it was fitted to. prior: the model that the fit started from.
    """
    robot = robot_beside(Path(session.source).parent, session.robot_name, output)
    if isinstance(fit, LocalFit):
        return fit.model(robot, {"software": f"toolpath-compensator {version()}"})
    return fit.model(robot, _provenance(fit, prior))


@writes("json")
def evaluate_file(
    session: Path,
    model: Path,
    *,
    register: int | None = None,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> tuple[Evaluation, dict[str, Any]]:
    """How well a model predicts a session.

    Raises:
        StiffnessError, CompensatorError: refused.
    """
    say("reading the session")
    loaded = load_measurement(session)
    result, report = evaluated(loaded, load_model(model, loaded.robot.n), register, say)
    refuse_warnings(report, strict)
    if json:
        with Outputs() as outputs:
            outputs.text(json, as_json(report))
            outputs.commit()
    return result, report


def evaluated(
    session: Session, model: ComplianceModel, register: int | None = None, say: Say = quiet
) -> tuple[Evaluation, dict[str, Any]]:
    """How well a model predicts a session, and its JSON report.

    Raises:
        StiffnessError: the two do not belong together, or nothing can place the tracker.
    """
    session = in_terms_of(session, model)
    refuse_other_robot(session, model)
    _same_kind(session, model.gravity, model.source)
    say("predicting")
    result = evaluate(session, model, register)
    return result, evaluation_report(result, _not_learned(session, model), mass_findings(model, session))


def _not_learned(session: Session, model: ComplianceModel) -> list[NotLearned]:
    """Angles of a session's states that the effects of a model did not learn."""
    unsure = AngleUncertainty(session.robot, shown_effects(model, session), model.values, model.sd)
    q = session.samples.q[session.states.first]
    return unsure.not_learned(q, np.tile(session.tool.position, (len(q), 1)))


def _same_kind(session: Session, gravity: str, source: str) -> None:
    if session.gravity != gravity:
        raise StiffnessError(
            f"{session.source}: gravity = {session.gravity!r}, but the model {source} was made with {gravity!r}: "
            "what its stiffness carries is not the same"
        )


def _approached(sessions: Sequence[Session]) -> bool:
    return any(bool(np.any(s.samples.approach != 0)) for s in sessions)


def _provenance(fit: Fit, prior: Path | None) -> dict[str, Any]:
    sessions = [s.session for s in fit.sessions]
    forces = [float(np.linalg.norm(s.samples.load.wrench[:, :3], axis=1).max()) for s in sessions]
    out: dict[str, Any] = {
        "kind": "static",
        "method": "global",
        "source": [f"{s.source} sha256:{s.sha256['samples'][:16]}" for s in sessions],
        "load_range": f"0 ... {max(forces):.0f} N",
        "preload_side": "both, by approach" if _approached(sessions) else "unknown",
        "session_date": "not in the session format",
        "software": f"toolpath-compensator {version()}",
        "not_identified": fit.not_identified(),
        KEY: declared_masses(sessions),
    }
    if prior is not None:
        out["prior"] = str(prior)
    return out
