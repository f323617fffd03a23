"""A mass that a model found, and that is declared since: said where it may weigh twice, and nowhere else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.declared_mass import declared_masses
from compensator.tasks.identify import evaluated, identify_files
from stiffness.identify import identify
from stiffness.model.counted_twice import KEY, REMEDY, counted_twice
from stiffness.model.model import ComplianceModel, load_model
from tests.compensator.small_job import MODEL, files
from tests.stiffness.bench_lab import Lab

SPRINGS = load_model("abb-irb6600-175-255")


def holding(
    found: float, sd: float | None, declared: float | None, name: str = "spindle", model: ComplianceModel = SPRINGS
) -> ComplianceModel:
    """Springs, and a mass that was found at a tool beside what its session declared for it."""
    own = {"payload": {"mass_kg": np.array([found]), "com_m": np.array([0.0, 0.1, 0.2])}}
    told = {} if sd is None else {"payload": {"mass_kg": np.array([sd])}}
    return replace(
        model,
        values={**model.values, **own},
        sd={**model.sd, **told},
        tools={**model.tools, "payload": name},
        provenance={} if declared is None else {KEY: {name: declared}},
    )


@pytest.mark.parametrize(
    ("found", "sd", "before", "now", "same"),
    [
        (33.8, 0.23, 38.0, 71.8, True),
        (33.8, 0.23, 38.0, 38.0, False),  # the same tool as when it was measured, about as heavy as what it lacks
        (15.1, None, 0.0, 15.0, True),
        (15.1, 0.05, 0.0, 18.0, True),  # another holder in it
        (15.1, 0.05, 0.0, 30.0, False),
        (4.0, 3.0, 2.0, 14.0, True),  # the readings hardly tell it
        (4.0, float("nan"), 2.0, 14.0, False),
        (4.0, 3.0, 2.0, 16.0, False),
        (4.0, 3.0, 2.0, 1.0, False),
        (15.1, 0.05, None, 15.0, False),  # a file that does not tell
    ],
)
def test_masses_that_are_alike(found: float, sd: float | None, before: float | None, now: float, same: bool) -> None:
    told = counted_twice(holding(found, sd, before), "spindle", now)
    assert len(told) == same
    if same:
        assert f"{found:.3g} kg was found" in told[0] and f"{now:.3g} kg are declared here" in told[0]
    assert counted_twice(holding(found, sd, before), "gripper", now) == []
    assert counted_twice(SPRINGS, "spindle", now) == []


def test_evaluate_says_it_of_the_session(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path, 61, setups=12)
    springs = identify([session], ["joint-stiffness"]).model(session.robot_name, {})
    mass = session.tool.mass
    assert mass
    heavier = replace(session, samples=replace(session.samples, payload=np.full(len(session), 12.0)))
    runs = ((session, mass - 12.3, 1), (session, mass, 0), (heavier, mass, 1), (heavier, mass + 12, 0))
    for seen, before, said in runs:
        report = evaluated(seen, holding(12.0, 0.1, before, session.tool.name, springs))[1]
        told = [f for f in report["findings"] if "counts twice" in f["what"]]
        assert len(told) == said
        assert all(f["level"] == "warning" and "12 kg was found" in f["what"] for f in told)


def test_files_tell_what_was_declared(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path / "a", 61, setups=6)
    assert session.tool.mass
    identify_files([Path(session.source)], tmp_path / "m.toml", effects=["joint-stiffness"])
    assert load_model(tmp_path / "m.toml").provenance[KEY] == {session.tool.name: pytest.approx(session.tool.mass)}
    hung = replace(session, samples=replace(session.samples, payload=np.arange(len(session)) % 2 * 5.0))
    assert declared_masses([session, hung]) == {}


@pytest.mark.parametrize("run", [compensate_file, preview_file], ids=["compensate", "preview"])
def test_a_path_says_it_of_the_cell(run: object, tmp_path: Path) -> None:
    payload = {"mass_kg": 31.0, "com_m": [0.0, 0.1, 0.2]}
    told = {KEY: {"tool": -1.0}}
    job = files(tmp_path, model={"effects": {**MODEL["effects"], "payload": payload}, "provenance": told})
    if run is compensate_file:
        report = compensate_file(job.toolpath, job.cell, job.out / "a.csv").report
    else:
        report = preview_file(job.toolpath, job.cell, csv=job.out / "a.csv").report
    (told,) = [f for f in report["findings"] if "counts twice" in f["what"]]
    assert told["level"] == "warning"
    assert "31 kg was found" in told["what"] and "30 kg are declared here" in told["what"]
    assert REMEDY.split(",", maxsplit=1)[0] in str(told)
