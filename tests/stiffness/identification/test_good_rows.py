"""Good rows: what several reflectors of a state show is not called wrong; what one of them shows alone is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from stiffness.diagnosis.diagnose import diagnose
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import Session, load_session
from tests.plant import lab
from tests.plant.ailments_joint import coupling
from tests.plant.cells import Scenario, write
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import FORCE, Lab

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

AT_TOOL = (("a", (0.06, 0.01, 0.16)), ("b", (-0.05, 0.055, 0.12)), ("c", (-0.02, -0.07, 0.14)))
ABSOLUTE = ["joint-stiffness", "kinematic-offset"]


def measured(folder: Path, seed: int, gap: tuple[float, ...] | None = None, setups: int = 24) -> Session:
    """Three reflectors at the tool; a gap is what no spring explains."""
    plant = Lab("ur10", gap=gap, breakaway=3.0).plant()
    targets = [lab.Target(name, 6, np.array(at)) for name, at in AT_TOOL]
    plan = random_setups(plant.arm, setups, seed, force=FORCE["ur10"], levels=(0.4, 1.0))
    return load_session(lab.measure(plant, plan, targets, seed=seed + 1000).write(folder, "ur10"))


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return measured(tmp_path_factory.mktemp("clean"), 3)


@pytest.fixture(scope="module")
def loose(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return measured(tmp_path_factory.mktemp("loose"), 3, gap=(0.0, 0.0, 0.0, 1e-3, 1e-3, 1e-3))


def moved(given: Session, by: Floats) -> Session:
    return replace(given, samples=replace(given.samples, position=given.samples.position + by))


def turned(given: Session, rows: Bools, angle: float) -> Session:
    """The arm turned by an angle, rad, more about the axis of joint 1 while some rows were read."""
    x, y, _ = given.samples.position.T
    return moved(given, np.where(rows[:, None], angle * np.column_stack([-y, x, np.zeros_like(x)]), 0.0))


def lines(fit: Fit) -> list[int]:
    return [line for _, line in fit.outlier_rows()]


def in_states(given: Session, states: list[tuple[int, int]]) -> Bools:
    s = given.samples
    return np.any([(s.setup == setup) & (s.state == state) for setup, state in states], axis=0)


@pytest.fixture(scope="module")
def coupled(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Joints 5 and 6 pull at each other: the tool turns, more at an outrigger of it than at the tool centre point."""
    pull = Scenario("coupled", (coupling(5, 6),))
    return load_session(write(pull, tmp_path_factory.mktemp("coupled"), 2, "ur10", sessions=("D",)).paths["D"])


def test_what_springs_miss_in_single_reflectors_of_a_state_stays(coupled: Session) -> None:
    """Eight readings of the tool were called wrong: those that the tool's turning moves most."""
    fit = identify([coupled], ABSOLUTE)
    assert fit.solution.misfit > 2
    assert lines(fit) == []


def test_a_wrong_row_is_found_where_springs_miss_others(coupled: Session) -> None:
    for name, way in (("outrigger", [0.004, -0.003, 0.003]), ("tcp", [0.002, 0.003, 0.002])):
        reflector = [r.name for r in coupled.reflectors].index(name)
        row = in_states(coupled, [(9, 3)]) & (coupled.samples.reflector == reflector)
        assert row.any()
        found = identify([moved(coupled, np.where(row[:, None], way, 0.0))], ABSOLUTE)
        assert lines(found) == coupled.samples.line[row].tolist()


@pytest.mark.parametrize("effects", [ABSOLUTE, ["joint-stiffness"]])
def test_whole_states_that_a_model_misses_stay_and_are_named(clean: Session, effects: list[str]) -> None:
    """A joint on its other flank in four states: in all others the model holds, so it is not lacking without them."""
    rows = in_states(clean, [(3, 1), (7, 4), (12, 2), (20, 3)])
    fit = identify([turned(clean, rows, 8e-4)], effects)
    assert lines(fit) == []
    assert fit.lacks
    first = clean.samples.line[rows][::3]
    (said,) = [n for n in fit.notes if "fit the model" in n]
    assert said == (
        "4 states do not fit the model and stay, several reflectors agree: rows "
        f"{', '.join(map(str, first))} of {clean.samples_file}"
    )
    assert not any("fit the model" in n for n in identify([clean], effects).notes)


def test_diagnose_names_them_as_well(clean: Session) -> None:
    model, odd = identify([clean], ABSOLUTE).model("ur10", {}), [(3, 1), (7, 4), (12, 2), (20, 3)]
    found = diagnose([turned(clean, in_states(clean, odd), 8e-4)], model)
    (said,) = [n for n in found.notes if "fit the model" in n]
    assert said.startswith("4 states do not fit the model and stay")
    assert not any("fit the model" in n for n in diagnose([clean], model).notes)


@pytest.mark.parametrize("size", [5e-4, 2e-3, 0.02])
def test_one_reflector_that_was_knocked_in_a_state_is_found(clean: Session, loose: Session, size: float) -> None:
    way = size * np.array([0.6, 0.0, 0.8])
    for given in (clean, loose) if size > 1e-3 else (clean,):
        row = in_states(given, [(9, 3)]) & (given.samples.reflector == 1)
        fit = identify([moved(given, np.where(row[:, None], way, 0.0))], ABSOLUTE)
        assert lines(fit) == given.samples.line[row].tolist()


def test_a_wrong_row_in_a_state_that_does_not_fit_is_found_alone(clean: Session) -> None:
    state = in_states(clean, [(7, 4)])
    row = state & (clean.samples.reflector == 2)
    spoiled = moved(turned(clean, state, 8e-4), np.where(row[:, None], [0.0, 0.004, -0.003], 0.0))
    assert lines(identify([spoiled], ABSOLUTE)) == clean.samples.line[row].tolist()


def test_reflectors_that_were_mistaken_for_each_other_are_found(clean: Session) -> None:
    """At 0.12 m from each other they are far readings; at 1 mm deletion has to tell."""
    rows = np.flatnonzero(in_states(clean, [(5, 2)]))[:2]
    position = clean.samples.position.copy()
    for share in (1.0, 0.01):
        apart = share * (position[rows[1]] - position[rows[0]])
        by = np.zeros_like(position)
        by[rows] = [apart, -apart]
        assert lines(identify([moved(clean, by)], ABSOLUTE)) == clean.samples.line[rows].tolist()


def test_a_set_up_at_other_angles_than_it_says_is_left_out(clean: Session) -> None:
    """By one degree: 15 mm at the tool, in all its states alike."""
    rows = clean.samples.setup == 6
    fit = identify([turned(clean, rows, 0.0175)], ABSOLUTE)
    assert lines(fit) == clean.samples.line[rows].tolist()
    assert fit.solution.misfit == 1.0
