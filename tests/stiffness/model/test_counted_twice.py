"""A mass that a model found, and that is declared since: said where it may weigh twice, and nowhere else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.identify import evaluated
from stiffness.identify import identify
from stiffness.model.counted_twice import REMEDY, counted_twice
from stiffness.model.model import ComplianceModel, load_model
from stiffness.statics.tool import Tool
from tests.compensator.small_job import MODEL, files
from tests.stiffness.bench_lab import Lab

SPRINGS = load_model("abb-irb6600-175-255")


def holding(mass: float, sd: float | None, name: str = "spindle", model: ComplianceModel = SPRINGS) -> ComplianceModel:
    """Springs, and a mass at the tool of a name."""
    own = {"payload": {"mass_kg": np.array([mass]), "com_m": np.array([0.0, 0.1, 0.2])}}
    told = {} if sd is None else {"payload": {"mass_kg": np.array([sd])}}
    return replace(
        model, values={**model.values, **own}, sd={**model.sd, **told}, tools={**model.tools, "payload": name}
    )


def tool(mass: float, name: str = "spindle") -> Tool:
    return Tool(rotation=np.eye(3), position=np.zeros(3), mass=mass, com=np.zeros(3), name=name)


@pytest.mark.parametrize(
    ("found", "sd", "declared", "same"),
    [
        (15.1, None, 15.0, True),
        (15.1, 0.05, 18.0, True),  # another holder in it
        (15.1, 0.05, 30.0, False),
        (4.0, 3.0, 12.0, True),  # the readings hardly tell it
        (4.0, float("nan"), 12.0, False),
        (4.0, 3.0, 14.0, False),
        (15.1, 0.05, 0.0, False),
        (0.0, 0.05, 0.0, False),
    ],
)
def test_masses_that_are_alike(found: float, sd: float | None, declared: float, same: bool) -> None:
    told = counted_twice(holding(found, sd), tool(declared))
    assert len(told) == same
    if same:
        assert f"{found:.3g} kg was found" in told[0] and f"{declared:.3g} kg are declared here" in told[0]
    assert counted_twice(holding(found, sd), tool(declared, "gripper")) == []
    assert counted_twice(SPRINGS, tool(declared)) == []


def test_evaluate_says_it_of_the_session(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 61, setups=12)
    springs = identify([session], ["joint-stiffness"]).model(session.robot_name, {})
    mass = session.tool.mass
    assert mass
    for found, said in ((mass + 0.3, 1), (3.0 * mass, 0)):
        report = evaluated(session, holding(found, 0.1, session.tool.name, springs))[1]
        told = [f for f in report["findings"] if "counts twice" in f["what"]]
        assert len(told) == said
        assert all(f["level"] == "warning" and f"{mass:.3g} kg are declared" in f["what"] for f in told)


@pytest.mark.parametrize("run", [compensate_file, preview_file], ids=["compensate", "preview"])
def test_a_path_says_it_of_the_cell(run: object, tmp_path: Path) -> None:
    payload = {"mass_kg": 31.0, "com_m": [0.0, 0.1, 0.2]}
    job = files(tmp_path, model={"effects": {**MODEL["effects"], "payload": payload}})
    if run is compensate_file:
        report = compensate_file(job.toolpath, job.cell, job.out / "a.csv").report
    else:
        report = preview_file(job.toolpath, job.cell, csv=job.out / "a.csv").report
    (told,) = [f for f in report["findings"] if "counts twice" in f["what"]]
    assert told["level"] == "warning"
    assert "31 kg was found" in told["what"] and "30 kg are declared here" in told["what"]
    assert REMEDY.split(",", maxsplit=1)[0] in str(told)
