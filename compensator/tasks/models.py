"""What `clamped` and `datasheet` do, from files to a model file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.report.json.findings import findings_report, notes
from compensator.report.json.made_model import clamped_report, datasheet_report
from compensator.report.json.text import as_json
from compensator.tasks.outputs import Outputs
from compensator.tasks.robot_reference import robot_beside
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from compensator.version import version
from stiffness.model.clamped import ABOVE, SCALE_SD, JointFit, clamped_model, fit_clamped
from stiffness.model.clamped_readings import read_clamped
from stiffness.model.datasheet import datasheet_model
from stiffness.model.model import ComplianceModel, model_text
from stiffness.robot.load import load_robot
from toolpaths.finding import WARNING, Finding


@dataclass(frozen=True, repr=False)
class Made:
    """A model that was written, its JSON report, and the files."""

    model: ComplianceModel
    report: dict[str, Any]
    files: tuple[Path, ...]


@writes("model", "json")
def clamped_file(
    readings: Path,
    robot: str,
    model: Path,
    *,
    above: float = ABOVE,
    scale_sd: float = SCALE_SD,
    json: Path | None = None,
    strict: bool = False,
    say: Say = quiet,
) -> Made:
    """Motor torque against motor angle with the end-effector locked, to a model.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    arm = load_robot(robot)
    say(f"reading {readings.name}")
    read = read_clamped(readings, arm)
    _refuse_other_suffix(model)
    fits = fit_clamped(read, above=above, scale_sd=scale_sd)
    provenance: dict[str, object] = {
        "source": readings.name,
        "sha256": hashlib.sha256(readings.read_bytes()).hexdigest(),
        "load_range": "; ".join(f"joint {f.joint + 1}: up to {f.largest:.0f} N*m" for f in fits),
        "fitted": f"straight line above {above:g} of the largest torque",
        "torque_scale_sd": scale_sd,
        "preload_side": "loading branches: the torque holds the flank",
        "temperature": "not given",
        "software": f"toolpath-compensator {version()}",
    }
    made = clamped_model(arm, robot_beside(Path(), robot, model), fits, provenance)
    report = clamped_report(made, fits, arm.n)
    report["findings"] = findings_report(_friction_findings(fits, readings))
    refuse_warnings(report, strict)
    return _write(made, model, report, json)


@writes("model", "json")
def datasheet_file(
    robot: str, model: Path, *, json: Path | None = None, strict: bool = False, say: Say = quiet
) -> Made:
    """Reducer data of a robot file to a starting model.

    Raises:
        StiffnessError, CompensatorError: refused; no output is left behind.
    """
    arm = load_robot(robot)
    _refuse_other_suffix(model)
    say(f"reducers of {arm.name}")
    made = datasheet_model(arm, robot_beside(Path(), robot, model))
    report = datasheet_report(made)
    report["findings"] = findings_report(notes("model", arm.name, arm.assumptions))
    refuse_warnings(report, strict)
    return _write(made, model, report, json)


def _friction_findings(fits: tuple[JointFit, ...], readings: Path) -> list[Finding]:
    """A warning for every joint whose gap was read on loading branches alone."""
    what = "no unloading branch: the gap is too small by what friction holds"
    remedy = "take readings while the torque goes back, too"
    return [
        Finding(WARNING, f"{readings}: joint {f.joint + 1}", what, remedy, kind="measurement")
        for f in fits
        if f.friction_in_gap
    ]


def _refuse_other_suffix(model: Path) -> None:
    if model != STDOUT and model.suffix != ".toml":
        raise CompensatorError(f"{model}: a model file ends in .toml")


def _write(made: ComplianceModel, model: Path, report: dict[str, Any], json: Path | None) -> Made:
    with Outputs() as outputs:
        outputs.text(model, model_text(made))
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    return Made(made, report, tuple(f for f in (model, json) if f))
