"""Bad sessions, one by one, from the file to the fit: refused, or reported in words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from stiffness.errors import StiffnessError
from stiffness.identification.fit import Fit
from stiffness.identify import identify
from stiffness.session.session import load_session
from tests.plant.lab import Noise, Target, measure
from tests.plant.lab_design import random_setups
from tests.stiffness.bench_lab import Lab
from tests.stiffness.session_desk import Rows

ABB = "abb-irb6600-175-255"


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    folder = tmp_path_factory.mktemp("day")
    Lab().session(folder, 3, setups=15)
    return (folder / "session.toml").read_text(), (folder / "samples.csv").read_text()


@pytest.fixture
def desk(tmp_path: Path, day: tuple[str, str]) -> Path:
    (tmp_path / "session.toml").write_text(day[0])
    (tmp_path / "samples.csv").write_text(day[1])
    return tmp_path


def fitted(folder: Path, *effects: str) -> Fit:
    return identify([load_session(folder / "session.toml")], effects or None)


def test_the_day_is_in_order(desk: Path) -> None:
    fit = fitted(desk)
    assert fit.determined()[:6].all()
    (note,) = fit.notes
    assert note.startswith("kinematic-offset: held at the drawing, ")


def _without_column(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    return [{k: v for k, v in row.items() if k != "q3"} for row in rows]


def _without_reference(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    return [row for row in rows if not (row["setup"] == "4" and row["state"] == "0")]


def _twice(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    return [*rows, rows[6]]


def _cell(column: str, text: str, line: int = 9) -> Callable[[list[dict[str, str]]], list[dict[str, str]]]:
    return lambda rows: [row | {column: text} if k + 2 == line else row for k, row in enumerate(rows)]


def _setup_turned(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    return [row | {"q2": "200"} if row["setup"] == "2" else row for row in rows]


BAD = {
    "missing column": (_without_column, ["samples.csv", "q3"]),
    "no state 0": (_without_reference, ["samples.csv", "set-up 4", "state 0"]),
    "unknown reflector": (_cell("reflector", "tpc"), ["row 9", "reflector", "tpc", "did you mean tcp?"]),
    "out of limits": (_setup_turned, ["row 17", "q2", "200", "limits"]),
    "NaN": (_cell("y", "nan"), ["row 9", "column y", "nan", "finite"]),
    "duplicate": (_twice, ["row 8", "reflector"]),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_table_is_refused(desk: Path, name: str) -> None:
    change, words = BAD[name]
    rows = Rows(desk)
    rows.order = change(rows.order)
    rows.write()
    with pytest.raises(StiffnessError) as caught:
        fitted(desk)
    assert [w for w in words if w not in str(caught.value)] == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('length = "mm"', 'length = "inch"', ["session.toml", "length", "inch"]),
        ('angle = "deg"', 'angle = "degrees"', ["session.toml", "angle", "degrees"]),
        ('length = "mm"', 'length = "m"', ["in m", "units.length"]),
        ('angle = "deg"', 'angle = "rad"', ["rad"]),
        (f'robot = "{ABB}"', 'robot = "ur10"', ["ur10"]),
        (f'robot = "{ABB}"', 'robot = "kuka-kr210-r2700"', ["kuka-kr210-r2700"]),
    ],
)
def test_a_wrong_word_is_refused(desk: Path, old: str, new: str, words: list[str]) -> None:
    text = (desk / "session.toml").read_text()
    assert old in text
    (desk / "session.toml").write_text(text.replace(old, new))
    with pytest.raises(StiffnessError) as caught:
        fitted(desk)
    assert [w for w in words if w not in str(caught.value)] == []


@pytest.fixture
def sister(desk: Path) -> Path:
    """The session with the robot's sister: an upper arm 50 mm longer."""
    text = (resources.files("stiffness") / "robot" / "data" / f"{ABB}.toml").read_text()
    assert "a = 1075.0" in text
    (desk / "sister.toml").write_text(text.replace("a = 1075.0", "a = 1125.0").replace(f'"{ABB}"', '"sister"'))
    session = desk / "session.toml"
    session.write_text(session.read_text().replace(f'robot = "{ABB}"', 'robot = "sister.toml"'))
    return desk


def test_a_sister_robot_is_doubted(sister: Path) -> None:
    fit = fitted(sister, "joint-stiffness", "kinematic-offset")
    assert any("no arm is so far from its drawing" in note for note in fit.notes)
    assert any("x_m of joint 2: -50 mm" in note for note in fit.notes)
    assert fit.values()["kinematic-offset"]["x_m"][1] == pytest.approx(-0.05, abs=1e-4)
    stiff = fitted(sister, "joint-stiffness")
    assert any("mm (RMS) from where the robot model has its reflectors" in note for note in stiff.notes)


def test_more_residual_than_noise_is_said(desk: Path) -> None:
    """A spring that is not there: the fit without the flank of a worn gear leaves many times the noise."""
    worn = tuple([2e-3] * 6)
    session, _ = Lab(gap=worn).session(desk / "worn", 5, setups=12)
    fit = identify([session], ["joint-stiffness"])
    assert any("times what the noise leaves" in note for note in fit.notes)


@pytest.mark.parametrize("spread", [0.0, 1e-3])
def test_five_almost_equal_postures(tmp_path: Path, spread: float) -> None:
    lab = Lab()
    plant = lab.plant()
    (first, *_) = random_setups(plant.arm, 1, 1, force=800.0, levels=(0.4, 1.0), directions=1)
    rng = np.random.default_rng(1)
    plan = [replace(first, q=first.q + spread * rng.normal(size=6)) for _ in range(5)]
    notes = measure(plant, plan, [Target("tcp", 6, np.array([0.02, -0.01, 0.25]))], noise=Noise(), seed=3)
    fit = identify([load_session(notes.write(tmp_path, lab.robot))], ["joint-stiffness"])
    told = fit.not_identified()
    assert len(told) >= 4
    assert all(
        any(f"joint {k + 1}:" in line for line in told) for k in np.flatnonzero(~fit.determined())
    )
    assert fit.condition_number() > 1e3
    flags = fit.model(lab.robot, {}).identified["joint-stiffness"]
    assert np.array_equal(flags, fit.determined())
