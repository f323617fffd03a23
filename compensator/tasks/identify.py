"""Identify and evaluate, from files to files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compensator.report.json.path import as_json
from compensator.tasks.outputs import Outputs
from compensator.tasks.robot_reference import robot_beside
from compensator.tasks.say import Say, quiet
from compensator.version import version
from stiffness.effects import BASE
from stiffness.errors import StiffnessError
from stiffness.identification import scores
from stiffness.identification.evaluate import Evaluation, evaluate, predicted_rigid
from stiffness.identification.fit import Fit
from stiffness.identification.identify import identify
from stiffness.identification.scores import Score
from stiffness.local_method.fit import LocalFit
from stiffness.local_method.identify import identify_local
from stiffness.local_method.text import local_text
from stiffness.model.model import ComplianceModel, load_model, model_text
from stiffness.session.session import Session, load_session

MM = 1e3


@dataclass(frozen=True, repr=False)
class Identified:
    """A fit, its JSON report, and the files that were written."""

    fit: Fit | LocalFit
    report: dict[str, Any]
    files: tuple[Path, ...]


def identify_files(
    sessions: Sequence[Path],
    output: Path,
    *,
    method: str = "global",
    effects: Sequence[str] | None = None,
    prior: Path | None = None,
    json: Path | None = None,
    html: Path | None = None,
    say: Say = quiet,
) -> Identified:
    """Sessions in, a model file out.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    if method == "local" and (effects is not None or prior is not None):
        raise StiffnessError("--method local takes no --effects and no --prior: it fits the joints one by one")
    say("reading the sessions")
    loaded = [load_session(path) for path in sessions]
    if method == "local" and html is not None:
        raise StiffnessError("--report shows a global fit; --method local has none: read the notes in --json instead")
    if method == "local":
        return _identify_local(loaded, output, json)
    known = None if prior is None else load_model(prior, loaded[0].robot.n)
    say("fitting")
    fit = identify(loaded, effects, known)
    report = identify_report(fit)
    robot = robot_beside(Path(loaded[0].source).parent, loaded[0].robot_name, output)
    model = fit.model(robot, _provenance(fit, prior))
    page = None if html is None else (html, _page(fit, report))
    return Identified(fit, report, _written(model=model, output=output, report=report, json=json, page=page))


def _page(fit: Fit, report: dict[str, Any]) -> str:
    from compensator.report.html.fit import fit_page

    return fit_page(fit, report)


def _written(
    model: ComplianceModel,
    output: Path,
    report: dict[str, Any],
    json: Path | None,
    page: tuple[Path, str] | None = None,
) -> tuple[Path, ...]:
    with Outputs() as outputs:
        outputs.text(output, model_text(model))
        if json:
            outputs.text(json, as_json(report))
        if page:
            outputs.text(*page)
        outputs.commit()
    return tuple(p for p in (output, json, page and page[0]) if p)


def _identify_local(loaded: Sequence[Session], output: Path, json: Path | None) -> Identified:
    fit = identify_local(*loaded)
    robot = robot_beside(Path(loaded[0].source).parent, loaded[0].robot_name, output)
    model = fit.model(robot, {"software": f"toolpath-compensator {version()}"})
    known = fit.identified
    report: dict[str, Any] = {
        "effects": list(model.values),
        "stiffness_nm_per_rad": [float(v) if ok else None for v, ok in zip(fit.stiffness, known, strict=True)],
        "stiffness_sd_nm_per_rad": [float(v) if ok else None for v, ok in zip(fit.sd, known, strict=True)],
        "identifiable": [bool(ok) for ok in known],
        "rms_mm": {"displacement": None, "absolute": None},
        "n_readings": sum(len(s.samples) for s in loaded),
        "outlier_rows": [],
        "not_identified": [],
        "notes": local_text(fit).splitlines(),
    }
    return Identified(fit, report, _written(model, output, report, json))


def evaluate_file(
    session: Path, model: Path, *, register: int | None = None, json: Path | None = None, say: Say = quiet
) -> tuple[Evaluation, dict[str, Any]]:
    """How well a model predicts a session.

    Raises:
        StiffnessError, CompensatorError: refused.
    """
    say("reading the session")
    loaded = load_session(session)
    values = load_model(model, loaded.robot.n)
    _same_kind(loaded, values.gravity, values.source)
    say("predicting")
    result = evaluate(loaded, values, register)
    report = {"displacement": _as_dict(result.displacement), "absolute": _as_dict(result.absolute)}
    if json:
        with Outputs() as outputs:
            outputs.text(json, as_json(report))
            outputs.commit()
    return result, report


def _same_kind(session: Session, gravity: str, source: str) -> None:
    if session.gravity != gravity:
        raise StiffnessError(
            f"{session.source}: gravity = {session.gravity!r}, but the model {source} was made with {gravity!r}: "
            "what its stiffness carries is not the same"
        )


def identify_report(fit: Fit) -> dict[str, Any]:
    """The JSON report of ``identify``."""
    n = fit.unknowns.joints
    known = np.ones(n, dtype=bool)
    for u, ok in zip(fit.unknowns.free, fit.determined(), strict=True):
        if u.effect == BASE.name:
            known[u.index] = ok
    k = fit.values()[BASE.name]["k_nm_per_rad"]
    sd = fit.deviations()[BASE.name]["k_nm_per_rad"]
    return {
        "effects": [e.name for e in fit.unknowns.effects],
        "stiffness_nm_per_rad": [float(v) if ok else None for v, ok in zip(k, known, strict=True)],
        "stiffness_sd_nm_per_rad": [float(v) if ok else None for v, ok in zip(sd, known, strict=True)],
        "identifiable": [bool(ok) for ok in known],
        "rms_mm": _rms(fit),
        "n_readings": int(sum(len(s.samples) for s in fit.sessions)),
        "outlier_rows": [{"session": name, "row": row} for name, row in fit.outlier_rows()],
        "condition_number": fit.condition_number(),
        "observability": fit.observability(),
        "not_identified": fit.not_identified(),
        "notes": list(fit.notes),
    }


def _rms(fit: Fit) -> dict[str, Any]:
    out: dict[str, Any] = {}
    rigid = [predicted_rigid(s.session, s.used).predicted for s in fit.sessions]
    for name, score in (("displacement", scores.displacement), ("absolute", scores.absolute)):
        fitted = scores.pooled([score(s.session, s.predicted, s.used, s.used) for s in fit.sessions])
        before = scores.pooled(
            [score(s.session, seen, s.used, s.used) for s, seen in zip(fit.sessions, rigid, strict=True)]
        )
        out[name] = (
            None
            if fitted is None or before is None
            else {"rigid": before.rms * MM, "fitted": fitted.rms * MM, "noise_floor": fitted.noise_floor * MM}
        )
    return out


def _as_dict(score: Score | None) -> dict[str, Any] | None:
    if score is None:
        return None
    return {
        "rms_mm": score.rms * MM,
        "p95_mm": score.p95 * MM,
        "max_mm": score.largest * MM,
        "noise_floor_mm": score.noise_floor * MM,
        "by_reflector": {name: value * MM for name, value in score.by_reflector.items()},
    }


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
    }
    if prior is not None:
        out["prior"] = str(prior)
    return out
