"""Diagnose, from files to files."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from compensator.report.json.diagnosis import diagnosis_report
from compensator.report.json.text import as_json
from compensator.tasks.declared_mass import declared_masses
from compensator.tasks.measurements import in_terms_of, load_measurements
from compensator.tasks.page_last import write_with_page
from compensator.tasks.robot_reference import refuse_other_robot, robot_beside
from compensator.tasks.run_files import writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from compensator.version import version
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.result import Diagnosis
from stiffness.model.counted_twice import KEY
from stiffness.model.model import ComplianceModel, load_model, model_text
from stiffness.session.session import Session


@dataclass(frozen=True, repr=False)
class Diagnosed:
    """A diagnosis, its JSON report, the files that were written, and ``warnings`` about these."""

    diagnosis: Diagnosis
    report: dict[str, Any]
    files: tuple[Path, ...]
    warnings: tuple[str, ...] = ()


@writes("output", "json", "html")
def diagnose_files(
    sessions: Sequence[Path],
    model: Path,
    output: Path | None = None,
    *,
    json: Path | None = None,
    html: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Diagnosed:
    """Sessions and a model in, a verdict and a refined model out.

    Args:
        output: the refined model, written whatever the verdict; where nothing was added and nothing has changed, it
            is ``model`` itself.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    say("reading the sessions")
    loaded = load_measurements(sessions)
    known = load_model(model, loaded[0].robot.n)
    loaded = [in_terms_of(session, known) for session in loaded]
    for session in loaded:
        refuse_other_robot(session, known)
    found = diagnose(loaded, known, say)
    report = diagnosis_report(found)
    refuse_warnings(report, strict)
    texts: list[tuple[Path, str]] = []
    if output:
        texts.append((output, refined_text(found, known, loaded, output)))
    if json:
        texts.append((json, as_json(report)))
    say("writing" if html is None else "writing, and drawing the report")
    warnings = write_with_page(texts, html, lambda warn: _page(found, known, report, warn), strict=strict)
    files = (*(target for target, _ in texts), *([html] if html else []))
    return Diagnosed(found, report, files, warnings)


def _page(found: Diagnosis, model: ComplianceModel, report: dict[str, Any], warn: Callable[[str], None]) -> str:
    from compensator.report.html.diagnosis import diagnosis_page

    return diagnosis_page(found, model, report, warn)


def refined_text(found: Diagnosis, model: ComplianceModel, sessions: Sequence[Session], output: Path) -> str:
    """The model file to write at ``output``."""
    robot = robot_beside(Path(model.source).parent, model.robot, output)
    if not (found.added or found.removed or found.changed):
        if robot == model.robot:
            return Path(model.source).read_text(encoding="utf-8")
        return model_text(replace(model, robot=robot))
    told = {**found.model.provenance, KEY: declared_masses(sessions), "diagnosis": _provenance(found, model, sessions)}
    return model_text(replace(found.model, robot=robot, provenance=told))


def _provenance(found: Diagnosis, model: ComplianceModel, sessions: Sequence[Session]) -> dict[str, Any]:
    digest = hashlib.sha256(Path(model.source).read_bytes()).hexdigest()
    return {
        "verdict": found.verdict,
        "added": [f"{a.effect} in {', '.join(a.where)}" for a in found.added],
        "removed": [f"{r.effect} in {', '.join(r.where)}" for r in found.removed],
        "changed": [f"{c.effect}.{c.parameter} of {', '.join(c.where)}" for c in found.changed],
        "model": f"{model.source} sha256:{digest[:16]}",
        "source": [f"{s.source} sha256:{s.sha256['samples'][:16]}" for s in sessions],
        "software": f"toolpath-compensator {version()}",
    }
