"""Traces beside a session of set-ups, and traces of different materials."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import identify_files
from compensator.tasks.measurements import load_measurements
from stiffness.diagnosis.added_effects import Addition
from stiffness.diagnosis.refined_model import given_way
from stiffness.effects import BY_NAME
from stiffness.model.model import load_model
from stiffness.session.processes import of_one_process
from tests.compensator.plant_bench import MM, TOOL
from tests.compensator.trace.test_traces_of_the_plant import CENTRE, NOISE, ballbar, circles, contour, surface
from tests.plant.lab import Form, Noise, Target, measure
from tests.plant.lab_design import random_setups

SOFT = [3.0e6, 2.7e6, 1.5e6, 4.2e5, 1.4e5, 5.6e4]


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A ball-bar and a session with a column of its own, of an arm whose joint 3 is softer than its model."""
    folder = tmp_path_factory.mktemp("both")
    ran = circles(folder, points=60, stiffness=SOFT)
    plant = ran.bench.plant(stiffness=SOFT)
    setups = random_setups(plant.arm, 12, 3, force=800.0, levels=(0.4, 1.0))
    form = Form(seconds=5.0, extra={"humidity": list(np.linspace(30.0, 60.0, 12))})
    tcp = Target("tcp", 6, MM * np.array(TOOL["xyz"]))
    notes = measure(plant, setups, [tcp], noise=Noise(), form=form, seed=5)
    return [ballbar(ran, NOISE, CENTRE), notes.write(folder / "session", "abb-irb6600-175-255")]


def test_a_ballbar_beside_a_session_is_diagnosed_whichever_comes_first(both: list[Path]) -> None:
    model = both[0].with_name("model.toml")
    for order in (both, both[::-1]):
        report = diagnose_files(order, model).report
        (moved,) = report["changed"]
        assert moved["where"] == ["joint-3"] and moved["to"] == pytest.approx(1.5e6, rel=0.01)
        for kind in ("displacement", "path"):
            rms = report["rms_mm"][kind]
            assert rms["after"] < 1.3 * rms["noise_floor"] < rms["before"], kind


def test_a_ballbar_beside_a_session_is_identified(both: list[Path], tmp_path: Path) -> None:
    found = identify_files(both, tmp_path / "model.toml", effects=["joint-stiffness"]).report
    assert found["stiffness_nm_per_rad"][:5] == pytest.approx(SOFT[:5], rel=0.02)
    fitted = found["rms_mm"]["displacement"]
    assert fitted["fitted"] < 1.3 * fitted["noise_floor"] and found["rms_mm"]["path"] is not None


def test_effects_of_the_process_are_of_one_material(tmp_path: Path) -> None:
    """A force in aluminium that is 30 % larger leaves what is known of steel alone."""
    folders = {"aluminium": tmp_path / "a", "steel": tmp_path / "s"}
    paths = []
    for material, folder in folders.items():
        folder.mkdir()
        ran, normals = contour(folder, force=1.3 if material == "aluminium" else 1.0)
        paths.append(surface(ran, NOISE, normals, seed=len(material)))
        cell = folder / "cell.toml"
        cell.write_text(cell.read_text().replace("aluminium", material))
    report = diagnose_files(paths, folders["steel"] / "model.toml", tmp_path / "refined.toml").report
    (found,) = report["added"]
    assert found["effect"] == "cutting-force"
    assert found["parameters"]["change"]["value"][1] == pytest.approx(0.3, abs=0.02)
    assert 'material = "aluminium"' in (tmp_path / "refined.toml").read_text()
    assert any("'steel'" in note and "one material and cutter at a time" in note for note in report["notes"])
    one, other = of_one_process(load_measurements(paths), [("steel", "")])
    assert one.path is not None and other.path is not None
    assert (one.path.as_said, other.path.as_said) == (True, False)
    force = Addition(BY_NAME["cutting-force"], (), frozenset(), {})
    steel = {"cutting-force": {"change": np.array([0.2, 0.2, 0.2])}}
    known = replace(load_model(tmp_path / "refined.toml"), values=steel, processes={"cutting-force": ("steel", "")})
    cut = load_measurements(paths[:1])
    (note,) = given_way(known, cut, [force])
    assert "aluminium" in note and "no longer that of material 'steel' (change = [0.2, 0.2, 0.2])" in note
    assert given_way(replace(known, processes={"cutting-force": ("aluminium", "")}), cut, [force]) == []
