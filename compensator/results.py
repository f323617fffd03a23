"""What the functions of ``compensator.api`` return: numbers as the JSON summaries have them, and tables."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from compensator.errors import CompensatorError
from compensator.program.provenance import Provenance
from compensator.report.words.findings import finding_sentences
from compensator.report.words.numbers import deflection_mm, residual_mm
from compensator.solve.assessment import Assessment
from compensator.solve.compensation import Compensation
from stiffness.diagnosis.result import Diagnosis
from stiffness.identification.evaluate import Evaluation
from stiffness.identification.fit import Fit
from stiffness.local_method.fit import LocalFit
from stiffness.model.model import ComplianceModel
from stiffness.session.session import Session
from toolpaths.languages.table import Language
from toolpaths.program_files import ProgramFiles
from toolpaths.toolpath import CUT, Toolpath

if TYPE_CHECKING:
    from pandas import DataFrame

Columns = dict[str, Sequence[object]]


@dataclass(frozen=True, repr=False, eq=False)
class TaskResult(ABC):
    """What a task found.

    Attributes:
        summary: as ``--json`` of the command line writes it; lengths in mm.
        inputs: the files that were read; ``write`` refuses them as outputs.
    """

    summary: Mapping[str, Any]
    inputs: tuple[Path, ...]

    @property
    def findings(self) -> tuple[str, ...]:
        """One sentence each, the worst level first."""
        return tuple(finding_sentences(dict(self.summary)))

    @abstractmethod
    def facts(self) -> dict[str, str]:
        """What the result comes down to: words -> value with its unit."""

    @abstractmethod
    def columns(self) -> Columns:
        """Name with unit -> values: the table of ``to_pandas``."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name} {value}' for name, value in self.facts().items())})"

    def _repr_html_(self) -> str:
        from compensator.report.html.notebook import notebook_table

        return notebook_table(type(self).__name__, self.facts(), self.findings)

    def to_pandas(self) -> DataFrame:
        """The table as a pandas DataFrame.

        Raises:
            CompensatorError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as e:
            remedy = "pip install 'toolpath-compensator[pandas]', or take columns(), which needs nothing"
            raise CompensatorError(f"to_pandas: pandas is not installed: {remedy}") from e
        return pandas.DataFrame(self.columns())


@dataclass(frozen=True, repr=False, eq=False)
class PathResult(TaskResult):
    """A path, previewed or compensated.

    Attributes:
        judged: the commands, and what is judged about them.
        source: the toolpath as it was read.
        files: of it; None: it was given as an object.
        language: that the program of a filter in place has; None: any but that of a source that could be filtered.
        provenance: hashes of what was read.
    """

    judged: Assessment
    source: Toolpath
    files: ProgramFiles | None
    language: Language | None
    provenance: Provenance

    @property
    def result(self) -> Compensation:
        """Commands, states and predictions in SI, base axes."""
        return self.judged.result

    def facts(self) -> dict[str, str]:
        """Predicted error and correction, mm."""
        error, corrected = self.summary["predicted_error_mm"], self.result.is_corrected
        told = {
            "toolpath": self.source.source,
            "poses": str(self.summary["n_poses"]),
            "error before": f"mean {deflection_mm(error['before']['mean'])}, max "
            f"{deflection_mm(error['before']['max'])} mm",
        }
        if corrected:
            told["error after"] = f"max {deflection_mm(error['after']['max'])} mm"
            told["largest correction"] = f"{deflection_mm(self.summary['max_correction_mm'])} mm"
        return told

    def columns(self) -> Columns:
        """A row per pose: place in the work object, and in base axes error before and correction, mm; angles, deg."""
        c = self.result
        toolpath = c.path.toolpath
        out: Columns = {
            "source_line": toolpath.line.tolist(),
            "kind": np.where(toolpath.kind == CUT, "cut", "rapid").tolist(),
        }
        q = np.degrees(c.command.q if c.is_corrected else c.path.q)
        vectors = {
            "{}_mm": toolpath.position * 1e3,
            "error_before_{}_mm": c.error_before * 1e3,
            "correction_{}_mm": c.correction * 1e3,
            "f{}_n": c.wrench[:, :3],
            "m{}_nm": c.wrench[:, 3:],
        }
        for name, rows in vectors.items():
            out |= {name.format(axis): rows[:, k].tolist() for k, axis in enumerate("xyz")}
        return out | {f"q{k + 1}_deg": q[:, k].tolist() for k in range(q.shape[1])}


@dataclass(frozen=True, repr=False, eq=False)
class IdentifyResult(TaskResult):
    """A fit to sessions; ``prior``: file of the model that it started from."""

    fit: Fit | LocalFit
    sessions: tuple[Session, ...]
    prior: str | None

    def facts(self) -> dict[str, str]:
        """Readings, effects, and what the fit leaves, mm."""
        r = self.summary
        rms = {f"{kind} rms": f"{residual_mm(of['fitted'])} mm" for kind, of in r["rms_mm"].items() if of}
        return {"readings": str(r["n_readings"]), "effects": ", ".join(r["effects"]), **rms}

    def columns(self) -> Columns:
        """A row per joint: stiffness and its standard deviation, N*m/rad; None where not identified."""
        names = ("stiffness_nm_per_rad", "stiffness_sd_nm_per_rad", "identifiable")
        table = {name: list(self.summary[name]) for name in names}
        return {"joint": list(range(1, len(table["identifiable"]) + 1)), **table}


@dataclass(frozen=True, repr=False, eq=False)
class DiagnoseResult(TaskResult):
    """What a model lacks in sessions; ``known`` is that model."""

    diagnosis: Diagnosis
    sessions: tuple[Session, ...]
    known: ComplianceModel

    def facts(self) -> dict[str, str]:
        """Verdict, additions, and the error on set-ups that took no part, mm."""
        r = self.summary
        told = {"verdict": str(r["verdict"]), "added": ", ".join(a["effect"] for a in r["added"]) or "nothing"}
        for kind, rms in r["rms_mm"].items():
            if rms:
                told[f"{kind} rms"] = f"{residual_mm(rms['before'])} -> {residual_mm(rms['after'])} mm"
        return told

    def columns(self) -> Columns:
        """A row per number that was added: effect, place, parameter, value, standard deviation, unit."""
        rows = [
            (a["effect"], where, name, value, sd, p["unit"])
            for a in self.summary["added"]
            for name, p in a["parameters"].items()
            for where, value, sd in _by_place(a["where"], p["value"], p["sd"])
        ]
        names = ("effect", "where", "parameter", "value", "sd", "unit")
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}


def _by_place(where: Sequence[str], value: Any, sd: Any) -> list[tuple[str, float, float]]:
    """A number per place, or all numbers of the one place."""
    values, deviations = ([v] if isinstance(v, float) else list(v) for v in (value, sd))
    places = list(where) if len(where) == len(values) else [", ".join(where)] * len(values)
    return list(zip(places, values, deviations, strict=True))


@dataclass(frozen=True, repr=False, eq=False)
class EvaluateResult(TaskResult):
    """How well a model predicts a session."""

    evaluation: Evaluation

    def facts(self) -> dict[str, str]:
        """Error by kind of reading, mm."""
        told = {"readings": str(self.summary["n_readings"])}
        for kind in ("displacement", "absolute"):
            if score := self.summary[kind]:
                told[f"{kind} rms"] = f"{residual_mm(score['rms_mm'])} mm"
        return told

    def columns(self) -> Columns:
        """A row per kind of reading: rms, 95 %, largest, noise floor, mm."""
        kinds = [kind for kind in ("displacement", "absolute") if self.summary[kind]]
        names = ("rms_mm", "p95_mm", "max_mm", "noise_floor_mm")
        return {"kind": list(kinds)} | {name: [self.summary[kind][name] for kind in kinds] for name in names}


@dataclass(frozen=True)
class WrittenFiles:
    """What ``write`` left on the disk; ``summary``: of a program, with the error of the file as it was read back."""

    files: tuple[Path, ...]
    summary: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"WrittenFiles({', '.join(map(str, self.files))})"
