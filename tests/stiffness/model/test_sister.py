"""Starting models: where their numbers come from, by an own calculation from the built-in files."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stiffness
from stiffness.model.model import ComplianceModel, builtin_models, load_model, model_text
from stiffness.model.sister import carried, starting_model
from stiffness.robot.load import builtin_robots, load_robot
from tests.stiffness.model.test_datasheet import BARE, robot_text

DATA = Path(stiffness.__file__).parent


def read_sets() -> np.ndarray:
    """(sets, 6) c_j = K_j / (m g L), from the files themselves."""
    rows = []
    for name in builtin_models():
        model = tomllib.loads((DATA / "model" / "data" / f"{name}.toml").read_text())
        robot = tomllib.loads((DATA / "robot" / "data" / f"{name}.toml").read_text())
        mass = sum(joint["mass"] for joint in robot["joints"])
        k = np.array(model["effects"]["joint-stiffness"]["k_nm_per_rad"])
        rows.append(k / (mass * 9.80665 * load_robot(name).reach))
    return np.array(rows)


def stiffness_of(model: ComplianceModel) -> list[float]:
    """Of every joint, N*m/rad."""
    found: list[float] = model.values["joint-stiffness"]["k_nm_per_rad"].tolist()
    return found


def test_a_robot_without_a_set_gets_that_of_its_sisters() -> None:
    """Scaled by mass and reach: a UR10 is near what is measured on real ones, 1e4 to 1e5 N*m/rad at its shoulder."""
    arm = load_robot("ur10")
    made = starting_model(arm, "ur10")
    c = read_sets()
    k = made.values["joint-stiffness"]["k_nm_per_rad"]
    expected = np.exp(np.log(c).mean(axis=0)) * float(arm.mass.sum()) * 9.80665 * 1.3
    assert k == pytest.approx(expected, rel=1e-3)
    assert 1e4 < k[0] < 1e5
    sd = made.sd["joint-stiffness"]["k_nm_per_rad"]
    assert sd == pytest.approx(k * (1 - np.exp(-np.log(c).std(axis=0, ddof=1))), rel=1e-3)
    assert (sd > 0.2 * k).all() and (sd < k).all()


def test_a_robot_with_a_set_gets_that_with_a_band() -> None:
    """Its values to the digit, and a standard deviation that the set does not have."""
    for name in builtin_models():
        made, own = starting_model(load_robot(name), name), load_model(name)
        assert stiffness_of(made) == stiffness_of(own)
        assert len(made.sd["joint-stiffness"]["k_nm_per_rad"]) == 6 and not own.sd


def test_reducers_come_before_sisters(tmp_path: Path) -> None:
    """As `datasheet` makes it."""
    file = tmp_path / "geared.toml"
    file.write_text(robot_text(*[BARE] * 6).replace('name = "arm"', 'name = "geared"'))
    assert starting_model(load_robot(str(file)), str(file)).provenance["method"] == "data sheet"


def test_masses_that_are_not_known(tmp_path: Path) -> None:
    """Grow with the cube of the reach: within a factor of two of what the built-in arms have."""
    for name in builtin_models():
        arm = load_robot(name)
        bare = replace(arm, mass=None, com=None, mass_problem="not given")
        assert 0.5 < carried(bare) / carried(arm) < 2


@pytest.mark.parametrize("name", builtin_robots())
def test_the_file_is_read_again(tmp_path: Path, name: str) -> None:
    file = tmp_path / "m.toml"
    made = starting_model(load_robot(name), name)
    file.write_text(model_text(made))
    again = load_model(file)
    assert stiffness_of(again) == stiffness_of(made)
