"""`cutting`: measured cutting forces, or spindle powers, to a material file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from compensator.errors import CompensatorError
from compensator.process.milling.doubts import material_doubts
from compensator.process.milling.force_fit import ForceFit, fit_forces, material_text
from compensator.process.milling.force_tests import read_force_tests
from compensator.process.milling.material import material_text_of
from compensator.report.json.cutting import cutting_report
from compensator.report.json.findings import findings_report
from compensator.report.json.text import as_json
from compensator.tasks.outputs import Outputs
from compensator.tasks.run_files import STDOUT, writes
from compensator.tasks.say import Say, quiet
from compensator.tasks.strict import refuse_warnings
from toolpaths.finding import WARNING, Finding

ILL = 100.0  # condition of columns of length 1, from which on standard deviations of single numbers mislead


@dataclass(frozen=True, repr=False)
class MadeMaterial:
    """A material file that was written: the fit, its JSON report, and the files."""

    fit: ForceFit
    report: dict[str, Any]
    files: tuple[Path, ...]


@writes("material", "json")
def cutting_file(
    forces: Path, material: Path, *, json: Path | None = None, strict: bool = False, say: Say = quiet
) -> MadeMaterial:
    """Coefficients of the cutting force by least squares.

    Raises:
        CompensatorError: refused; no output is left behind.
    """
    say(f"reading {forces.name}")
    tests = read_force_tests(forces)
    if material != STDOUT and material.suffix != ".toml":
        raise CompensatorError(f"{material}: a material file ends in .toml")
    fit = fit_forces(tests, str(forces))
    say("writing the material")
    text = material_text(fit, forces.stem, f"compensator cutting {forces.name}, {fit.count} readings")
    report = cutting_report(fit)
    doubts = material_doubts(material_text_of(text, str(material)).at())
    report["findings"] = findings_report([*_findings(fit, forces), *doubts])
    refuse_warnings(report, strict)
    with Outputs() as outputs:
        outputs.text(material, text)
        if json:
            outputs.text(json, as_json(report))
        outputs.commit()
    return MadeMaterial(fit, report, tuple(f for f in (material, json) if f))


def _findings(fit: ForceFit, forces: Path) -> list[Finding]:
    place = str(forces)
    found = [
        Finding(WARNING, place, f"{name} is not determined: {why}", "It is left out of the file")
        for name, why in fit.undetermined.items()
    ]
    if fit.condition > ILL:
        what = f"the tests hardly tell the coefficients apart (condition {fit.condition:.0f})"
        found.append(Finding(WARNING, place, what, "Add tests at other feeds per tooth and arcs"))
    return found
