"""clamped and datasheet: from files to a model file that the rest of the product loads."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.models import clamped_file, datasheet_file
from compensator.tasks.stiffness_map import map_file
from stiffness.errors import StiffnessError
from stiffness.model.model import load_model
from stiffness.robot.load import load_robot
from tests.stiffness import arms
from tests.stiffness.model.test_clamped import GAP, K, cycle, lines, written
from tests.stiffness.model.test_datasheet import BARE, RV, STRAIN_WAVE, robot_text

ABB = arms.NAMES[0]


def test_clamped_writes_model_and_report(tmp_path: Path) -> None:
    readings = written(tmp_path, [*lines(cycle(), cycle()), *lines(cycle(k=4e5), joint=4)])
    done = clamped_file(readings, ABB, tmp_path / "m.toml", json=tmp_path / "m.json")
    model = load_model(tmp_path / "m.toml")
    assert model.robot == ABB and model.provenance["kind"] == "static" and model.provenance["method"] == "clamped"
    assert model.provenance["sha256"] == hashlib.sha256(readings.read_bytes()).hexdigest()
    assert model.provenance["load_range"] == "joint 1: up to 2040 N*m; joint 4: up to 2040 N*m"
    np.testing.assert_allclose(model.values["joint-stiffness"]["k_nm_per_rad"][[0, 3]], [K, 4e5], rtol=1e-8)
    np.testing.assert_allclose(model.sd["joint-stiffness"]["k_nm_per_rad"][[0, 3]], [0.05 * K, 0.05 * 4e5], rtol=1e-4)
    report = json.loads((tmp_path / "m.json").read_text())
    assert report == done.report and report["effects"] == ["joint-stiffness", "backlash"]
    assert report["identifiable"] == [True, False, False, True, False, False]
    assert report["stiffness_nm_per_rad"][1] is None and report["gap_rad"][2] is None
    np.testing.assert_allclose(report["gap_rad"][0], GAP, rtol=1e-7)
    assert report["friction_in_gap"][0] is False and report["n_used"][0] == 24


def test_a_map_of_half_a_model_is_refused(tmp_path: Path) -> None:
    clamped_file(written(tmp_path, lines(cycle())), ABB, tmp_path / "m.toml")
    with pytest.raises(StiffnessError, match=r"m.toml: joint-stiffness of joint 2, 3, 4, 5, 6 is not identified"):
        map_file(tmp_path / "m.toml")


def test_datasheet_model_maps_and_names_its_robot_from_where_it_lies(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    arm = tmp_path / "robots" / "arm.toml"
    arm.write_text(robot_text(RV, RV, RV, STRAIN_WAVE, STRAIN_WAVE, BARE))
    (tmp_path / "models").mkdir()
    done = datasheet_file(str(arm), tmp_path / "models" / "m.toml", json=tmp_path / "m.json")
    model = load_model(tmp_path / "models" / "m.toml")
    assert model.robot == "../robots/arm.toml"
    assert load_robot(model.robot, folder=tmp_path / "models").reducers is not None
    assert (
        done.report["effects"] == ["joint-stiffness", "backlash", "joint-hardening"] == [e.name for e in model.effects]
    )
    assert done.report["identifiable"] == [True] * 6
    np.testing.assert_allclose(done.report["stiffness_nm_per_rad"][3], 0.39087 * 4e4, rtol=1e-4)
    mapped = map_file(tmp_path / "models" / "m.toml", spans="-120:-60:20,30:90:20", weight=False)
    assert mapped.report["n_ok"] > 5 and "an assumption" in " ".join(mapped.report["notes"])


def test_refusals_leave_nothing(tmp_path: Path) -> None:
    readings = written(tmp_path, ["1,x,1,150,loading,1"])
    with pytest.raises(StiffnessError, match="row 2, column motor_angle_deg = 'x'"):
        clamped_file(readings, ABB, tmp_path / "m.toml", json=tmp_path / "m.json")
    with pytest.raises(StiffnessError, match="no reducer data for"):
        datasheet_file(ABB, tmp_path / "m.toml")
    with pytest.raises(CompensatorError, match=r"m.txt: a model file ends in .toml"):
        datasheet_file(ABB, tmp_path / "m.txt")
    with pytest.raises(CompensatorError, match="is an input of this run"):
        clamped_file(readings, ABB, readings)
    arm = tmp_path / "arm.toml"
    arm.write_text(robot_text(*[BARE] * 6))
    with pytest.raises(CompensatorError, match="is an input of this run"):
        datasheet_file(str(arm), arm)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["arm.toml", "readings.csv"]
