"""Numbers that readings know together only, against an arm whose every spring is known."""

from __future__ import annotations

import pytest

from stiffness.diagnosis.added_effects import Addition
from stiffness.diagnosis.diagnose import diagnose
from stiffness.diagnosis.regrouped import regrouped
from stiffness.effects import BY_NAME
from stiffness.identification.fit import Fit
from tests.effects_report.told import told
from tests.plant.cell_design import CELLS
from tests.stiffness.diagnosis.sick import UR, sick


def begun(name: str, extras: bool, **numbers: dict[int, float]) -> Addition:
    """An effect begun at some numbers."""
    effect = BY_NAME[name]
    values = effect.neutral(6)
    for parameter, given in numbers.items():
        for index, value in given.items():
            values[parameter][index] = value
    sites = tuple(s for s in effect.sites(6) if name != "link-compliance" or s.where == ("link-4",))
    return Addition(effect, sites, frozenset(sites) if extras else frozenset(), values)


SCENARIO = "link-compliance link-4"


@pytest.fixture(scope="module")
def true() -> dict[str, float]:
    """What link 4 of the plant yields, in the words of the catalogue."""
    (truth,) = sick(SCENARIO, UR, seed=1).truth
    return {name: value for (name, _), value in told(truth, CELLS[UR]).exact.items()}


@pytest.fixture(scope="module")
def link(true: dict[str, float]) -> Fit:
    """A light arm whose link 4 yields in all directions, in one of them about the axis of joint 4."""
    ill = sick(SCENARIO, UR, seed=1)
    part = {name: {3: 0.67 * true[name]} for name in ("rx_rad_per_nm", "rz_rad_per_nm")}
    return ill.fits.fit([begun("link-compliance", False, at={3: 0.4}, **part)], ill.base)


def test_a_link_of_a_light_arm_is_not_held_where_its_numbers_begin(link: Fit, true: dict[str, float]) -> None:
    """It yields two hundred times as much as the typical one."""
    numbers, sd = link.values()["link-compliance"], link.deviations()["link-compliance"]
    for name in ("rx_rad_per_nm", "rz_rad_per_nm"):
        assert numbers[name][3] == pytest.approx(true[name], abs=4 * sd[name][3])
        assert sd[name][3] < 0.1 * true[name]


def test_a_twist_about_the_axis_of_a_joint_stands_in_its_spring(link: Fit, true: dict[str, float]) -> None:
    (found,) = regrouped(link, ["link-compliance"])
    assert str(found.number) == "link-compliance.ry_rad_per_nm[4]"
    assert [str(h) for h in found.holders] == ["joint-stiffness.k_nm_per_rad[4]"]
    assert found.shares == pytest.approx((-1.0,), abs=0.01)
    assert "joint-stiffness" in str(found) and "ry_rad_per_nm[4]" in str(found)
    yields = 1 / link.values()["joint-stiffness"]["k_nm_per_rad"][3]
    assert yields == pytest.approx(1 / CELLS[UR].stiffness[3] + true["ry_rad_per_nm"], rel=0.02)


def test_diagnose_says_what_stands_for_both() -> None:
    ill = sick(SCENARIO, UR, seed=1)
    said = diagnose([ill.session], ill.base.model(ill.session.robot_name, {}))
    assert [(a.effect, a.where) for a in said.added] == [("link-compliance", ("link-4",))]
    (note,) = [n for n in said.notes if n.startswith("link-compliance: the readings know ")]
    assert "ry_rad_per_nm[4] together with k_nm_per_rad[4] of joint-stiffness only" in note


def test_what_the_readings_tell_stands_for_itself(link: Fit) -> None:
    """Of a base nothing can be regrouped: no joint moves as it does in every posture."""
    ill = sick("base-compliance", UR, seed=1)
    fit = ill.fits.fit([begun("base-compliance", False, linear_m_per_n={0: 1e-8}, angular_rad_per_nm={1: 1e-7})])
    assert regrouped(fit, ["base-compliance"]) == []
    assert regrouped(link, ["joint-stiffness"]) == []
