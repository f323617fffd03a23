"""Diagnoses that several tests look at: each takes some seconds, so each is made once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from compensator.tasks.diagnose import Diagnosed, diagnose_files
from stiffness.identify import identify
from stiffness.model.model import ComplianceModel, load_model, save_model
from stiffness.session.session import load_session
from tests.plant.cells import SCENARIOS, write

SETUPS = 14


@dataclass(frozen=True)
class Sick:
    """A lab's files, and what the command made of them: refined.toml, out.json, report.html in ``folder``."""

    folder: Path
    session: Path
    model: ComplianceModel
    done: Diagnosed


def prepared(scenario: str, folder: Path) -> tuple[Path, Path]:
    """A model of the healthy arm, and a session of the sick one with fewer set-ups: session, model."""
    case = write(SCENARIOS[scenario], folder, 3, "ur10", size=5.0, sessions=("A_healthy", "D"))
    only(case.paths["D"].parent / "samples.csv", lambda setup, line: setup <= SETUPS)
    healthy = load_session(case.paths["A_healthy"])
    model = folder / "model.toml"
    save_model(identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {"kind": "static"}), model)
    return case.paths["D"], model


def only(samples: Path, keep: object) -> None:
    """Leave rows of samples.csv for which ``keep(set-up, line)``."""
    assert callable(keep)
    head, *rows = samples.read_text().splitlines()
    kept = [row for k, row in enumerate(rows) if keep(int(row.split(",")[0]), k + 2)]
    samples.write_text("\n".join([head, *kept]) + "\n")


def _sick(scenario: str, folder: Path) -> Sick:
    session, model = prepared(scenario, folder)
    done = diagnose_files(
        [session], model, folder / "refined.toml", json=folder / "out.json", html=folder / "report.html"
    )
    return Sick(folder, session, load_model(model), done)


@pytest.fixture(scope="session")
def loose(tmp_path_factory: pytest.TempPathFactory) -> Sick:
    """Joint 1 has backlash that the model lacks."""
    return _sick("backlash joint-1", tmp_path_factory.mktemp("loose"))


@pytest.fixture(scope="session")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Sick:
    """Nothing is wrong."""
    return _sick("clean", tmp_path_factory.mktemp("healthy"))
