"""ComplianceModel: a robot, the effects it shows, and their values; read from and written to model/1 files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stiffness.effects import CATALOGUE
from stiffness.effects.effect import Effect
from stiffness.errors import ModelError
from stiffness.model.correlations import Correlations
from stiffness.model.file import SCHEMA, read_tables, sd_key
from stiffness.model.toml_text import toml_text
from stiffness.robot.load import load_robot
from stiffness.robot.robot import Robot
from stiffness.text_file import toml_table

Floats = npt.NDArray[np.float64]
_DATA = Path(str(resources.files("stiffness") / "model" / "data"))


@dataclass(frozen=True, kw_only=True, repr=False)
class ComplianceModel:
    """Values of the effects that a robot shows.

    Attributes:
        source: the file, as the user named it.
        robot: name or path, as in the file.
        gravity: ``uncompensated`` or ``calibrated-out`` (measurement-session.md).
        reference_temperature: deg C where the robot model is true.
        base, tip: frames that the model was made with; None where the file does not give them.
        values: effect -> parameter -> array, in SI.
        sd: the same for standard deviations, where given.
        identified: effect -> per-joint booleans, where the file gives them.
        tools: effect -> name of the tool it holds for (scope ``tool``).
        processes: effect -> names of the material and the cutter it holds for (scope ``process``); "" where not told.
        provenance: free text by key: kind, source, load_range, preload_side, ...
        correlations: between the numbers of the model, where identification gave them.
    """

    source: str
    robot: str
    gravity: str
    reference_temperature: float
    base: str | None
    tip: str | None
    values: Mapping[str, Mapping[str, Floats]]
    sd: Mapping[str, Mapping[str, Floats]] = field(default_factory=dict)
    identified: Mapping[str, npt.NDArray[np.bool_]] = field(default_factory=dict)
    tools: Mapping[str, str] = field(default_factory=dict)
    processes: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    provenance: Mapping[str, Any] = field(default_factory=dict)
    correlations: Correlations | None = None

    def __repr__(self) -> str:
        return f"ComplianceModel({self.source!r}, {self.robot}, {', '.join(self.values)})"

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects of the model, in the order of the catalogue."""
        return tuple(e for e in CATALOGUE if e.name in self.values)

    def applied(
        self, tool: str, process: tuple[str, str] | None = None, *, walls: bool = False
    ) -> tuple[tuple[Effect, ...], tuple[str, ...]]:
        """Effects that act on a planned path with a tool and a process of these names, and names of those that do not.

        Args:
            process: names of material and cutter; None: nothing is cut. walls: it tells which wall a cutter cuts.
        """
        yes = [
            e
            for e in self.effects
            if e.scope == "robot"
            or (e.scope == "tool" and self.tools[e.name] == tool)
            or (e.process_wrench is not None and self.of_process(e, process))
            or (e.missing_radius is not None and walls and self.of_process(e, process))
        ]
        return tuple(yes), tuple(e.name for e in self.effects if e not in yes)

    def of_process(self, effect: Effect, process: tuple[str, str] | None) -> bool:
        """Whether an effect of scope ``process`` holds for a material and a cutter: absent names are equal."""
        return effect.scope == "process" and self.processes.get(effect.name, ("", "")) == process


def load_model(name_or_path: str | Path, joints: int = 6, *, folder: Path | None = None) -> ComplianceModel:
    """Read a model/1 file.

    Args:
        name_or_path: a path, or the name of a built-in robot: the set that comes with it.
        joints: of the robot.
        folder: what a relative path starts from; default the working folder.

    Raises:
        ModelError: names the file, the key, the value and what was expected.
    """
    builtin = builtin_model(str(name_or_path))
    path = builtin or (folder or Path()) / name_or_path
    if builtin is None and not path.suffix and not path.exists():
        why = "there is no such file, and the built-in robots with a stiffness set are"
        raise ModelError(f"{path}: {why} {', '.join(builtin_models())}")
    name = str(name_or_path if builtin else path)
    return _model(name, toml_table(name, path, ModelError, SCHEMA), joints)


def robot_of(model: ComplianceModel) -> Robot:
    """The robot that a model file names: a path is relative to the file.

    Raises:
        RobotError: there is no such robot, or its file is refused.
    """
    return load_robot(model.robot, folder=Path(model.source).resolve().parent, base=model.base, tip=model.tip)


def builtin_model(robot: str) -> Path | None:
    """The published stiffness set of a built-in robot, if there is one."""
    return _DATA / f"{robot}.toml" if robot in builtin_models() else None


def builtin_models() -> list[str]:
    """The built-in robots that a stiffness set comes with."""
    return sorted(path.stem for path in _DATA.glob("*.toml"))


def _model(name: str, table: dict[str, Any], joints: int) -> ComplianceModel:
    file, effects, correlations = read_tables(name, table, joints)
    return ComplianceModel(
        source=name,
        robot=file.robot,
        gravity=file.gravity,
        reference_temperature=file.reference_temperature,
        base=file.base,
        tip=file.tip,
        values={e: read.values for e, read in effects.items()},
        sd={e: read.sd for e, read in effects.items() if read.sd},
        identified={e: read.identified for e, read in effects.items() if read.identified is not None},
        tools={e: read.tool for e, read in effects.items() if read.tool is not None},
        processes={e: read.process for e, read in effects.items() if read.process is not None},
        provenance=file.provenance,
        correlations=correlations,
    )


def save_model(model: ComplianceModel, path: str | Path) -> None:
    """Write a model/1 file; reading it again gives the same numbers to the last bit."""
    Path(path).write_text(model_text(model), encoding="utf-8", newline="\n")


def model_text(model: ComplianceModel) -> str:
    """The model as the text of a model/1 file."""
    table: dict[str, Any] = {"schema": SCHEMA, "robot": model.robot, "gravity": model.gravity}
    table["reference_temperature"] = model.reference_temperature
    for key in ("base", "tip"):
        if getattr(model, key) is not None:
            table[key] = getattr(model, key)
    if model.provenance:
        table["provenance"] = dict(model.provenance)
    table["effects"] = {e.name: _effect_table(model, e) for e in model.effects}
    if model.correlations is not None:
        table["correlations"] = model.correlations.table()
    return toml_text(table)


def _effect_table(model: ComplianceModel, effect: Effect) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if effect.name in model.tools:
        table["tool"] = model.tools[effect.name]
    names = model.processes.get(effect.name, ("", ""))
    table |= {key: name for key, name in zip(("material", "cutter"), names, strict=True) if name}
    for p in effect.parameters:
        sd = model.sd.get(effect.name, {}).get(p.name, np.zeros(1))
        if p.each > 1 and np.all(model.values[effect.name][p.name] == p.default) and not np.any(sd):
            continue  # hundreds of numbers that say nothing
        numbers = model.values[effect.name][p.name].tolist()
        table[p.name] = numbers if len(numbers) > 1 else numbers[0]
        if p.name in model.sd.get(effect.name, {}):
            table[sd_key(p.name)] = model.sd[effect.name][p.name].tolist()
    if effect.name in model.identified:
        table["identified"] = model.identified[effect.name].tolist()
    return table
