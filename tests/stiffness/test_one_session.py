"""One session of a cell that is ill already: identify by default, then diagnose with that model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffness.diagnosis.diagnose import diagnose
from stiffness.identify import identify
from stiffness.session.session import load_session
from tests.effects_report.case import Row, Task, run
from tests.effects_report.judge import misses
from tests.plant import paper_experiment as paper
from tests.plant.cell_design import CELLS
from tests.plant.cells import SCENARIOS, write

ABB, UR, KUKA = CELLS


def row(arm: str, scenario: str, folder: Path) -> Row:
    return run(Task(arm, scenario, 1, 3.0, folder, "b"))


@pytest.mark.parametrize(
    ("arm", "scenario", "at_hand", "added"),
    [
        (UR, "clean", (), ()),
        (UR, "joint-coupling joint-2 joint-3", (), ("joint-coupling",)),
        (UR, "backlash joint-1", ("backlash",), ()),
        (KUKA, "base-compliance", (), ("base-compliance",)),
        (ABB, "tracker-drift", (), ("tracker-drift",)),
    ],
)
def test_identify_takes_what_the_approach_brings_and_diagnose_the_rest(
    arm: str, scenario: str, at_hand: tuple[str, ...], added: tuple[str, ...], tmp_path: Path
) -> None:
    found = row(arm, scenario, tmp_path)
    assert misses(found) == []
    assert {*found.at_hand} == {"joint-stiffness", "kinematic-offset", *at_hand}
    assert found.added == added


def test_the_papers_experiment_in_seven_set_ups(tmp_path: Path) -> None:
    """Table 2, joint 1 in both cases of Table 4, one load level: the softer flank of joint 1 and of no other."""
    arm = paper.plant(paper.CASES[0] * paper.K1, paper.CASES[1] / paper.CASES[0])
    trials = [*((t, 1.0) for t in paper.TRIALS), (paper.TRIALS[0], -1.0)]
    pages = [paper._page(arm, t, paper.NOISE, 100, 7 + k, side, paper.Form()) for k, (t, side) in enumerate(trials)]
    notes = paper.bound(pages, [paper._purpose(t) for t, _ in trials])
    session = load_session(notes.write(tmp_path, paper.ROBOT))
    fit = identify([session])
    (effect,) = (e for e in fit.unknowns.effects if e.memory)
    assert effect.name in ("preload-softening", "backlash")
    values = fit.values()
    assert values["joint-stiffness"]["k_nm_per_rad"][0] == pytest.approx(paper.CASES[0] * paper.K1, rel=0.02)
    if effect.name == "preload-softening":
        assert values[effect.name]["ratio"][0] == pytest.approx(paper.CASES[1] / paper.CASES[0], abs=0.02)
        assert np.all(values[effect.name]["ratio"][1:] == 1.0)
    assert diagnose([session], fit.model(paper.ROBOT, {})).verdict == "adequate"


def test_what_an_earlier_model_had_and_nothing_shows_is_removed(tmp_path: Path) -> None:
    """A gap that an old model has in a joint that is healthy: found out, named with its joint, and gone."""
    paths = write(SCENARIOS["base-compliance"], tmp_path, 2, UR, sessions=("A_healthy", "D")).paths
    healthy, ill = (load_session(paths[k]) for k in ("A_healthy", "D"))
    model = identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    gap = np.array([0.0, 0.0, 2e-3, 0.0, 0.0, 0.0])
    told = {"gap_rad": gap, "breakaway_nm": np.zeros(6), "side": np.ones(6)}
    wrong = replace(model, values={**model.values, "backlash": told})
    found = diagnose([ill], wrong)
    assert [(r.effect, r.where) for r in found.removed] == [("backlash", ("joint-3",))]
    assert [a.effect for a in found.added] == ["base-compliance"]
    assert found.verdict == "explained"
    assert "backlash" not in found.model.values


def test_what_a_session_cannot_show_stays_as_the_model_has_it(tmp_path: Path) -> None:
    """A gap a hundred times below the noise is neither seen nor refuted."""
    paths = write(SCENARIOS["clean"], tmp_path, 2, UR, sessions=("A_healthy",)).paths
    healthy = load_session(paths["A_healthy"])
    model = identify([healthy], ["joint-stiffness"]).model(healthy.robot_name, {})
    told = {"gap_rad": np.full(6, 2e-7), "breakaway_nm": np.zeros(6), "side": np.ones(6)}
    found = diagnose([healthy], replace(model, values={**model.values, "backlash": told}))
    assert found.verdict == "adequate"
    assert found.removed == () and found.added == ()
    np.testing.assert_array_equal(found.model.values["backlash"]["gap_rad"], told["gap_rad"])
