"""The verb plan, from files to files."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.plan import plan_file
from stiffness.errors import StiffnessError
from stiffness.model.model import load_model
from stiffness.robot.load import load_robot
from tests.stiffness.bench_lab import Lab

ROBOT = "abb-irb6600-175-255"
TCP = (0.02, -0.01, 0.25)  # of the lab's tool
MODEL = """schema = "model/1"
robot = "abb-irb6600-175-255"
gravity = "uncompensated"
[effects.joint-stiffness]
k_nm_per_rad = [2.0e6, 1.774e6, 1.3784e6, 2.82e5, 9.6e4, 3.74e4]
sd_nm_per_rad = [2.0e5, 0.0, 0.0, 0.0, 0.0, 0.0]
"""


def test_files(tmp_path: Path) -> None:
    model, out, report = tmp_path / "m.toml", tmp_path / "plan.csv", tmp_path / "plan.json"
    model.write_text(MODEL)
    done = plan_file(model, out, count=4, force=500.0, json=report, seed=3)
    first = out.read_bytes()
    plan_file(model, out, count=4, force=500.0, seed=3)
    assert out.read_bytes() == first
    rows = list(csv.DictReader(first.decode().splitlines()))
    assert len(rows) == 4 * 3
    robot = load_robot(ROBOT)
    for row in rows:
        q = np.radians([float(row[f"q{k}_deg"]) for k in range(1, 7)])
        f, m, at = (np.array([float(row[k]) for k in keys]) for keys in (
            ("fx", "fy", "fz"), ("mx", "my", "mz"), ("pull_x_mm", "pull_y_mm", "pull_z_mm")))  # fmt: skip
        assert m == pytest.approx(np.cross(robot.pose(q)[:3, :3] @ at / 1e3, f), abs=1e-2)
        assert np.linalg.norm(f) == pytest.approx(0.0 if row["state"] == "0" else 500.0, abs=1e-3)
        assert {row[f"approach{k}"] for k in range(1, 7)} <= {"-1", "1"}
    told = json.loads(report.read_text())
    assert (told["criterion"], told["n_readings"], told["seed"], told["undetermined"]) == ("D", 12, 3, [])
    assert told["sentence"] == done.sentence
    before = [p["sd_before"] for p in told["parameters"]]
    assert before[0] == pytest.approx(2e5, rel=0.01)  # the model says so; of the others nobody knows
    assert before[1:] == [None] * 5
    k = load_model(model).values["joint-stiffness"]["k_nm_per_rad"]
    assert [p["value"] for p in told["parameters"]] == pytest.approx(k)
    assert all(0 < p["sd_after"] < 0.3 * v for p, v in zip(told["parameters"], k, strict=True))


def test_refusals(tmp_path: Path) -> None:
    model, out = tmp_path / "m.toml", tmp_path / "plan.csv"
    model.write_text(MODEL)
    for options, words in (
        ({"count": 0}, "--count 0"),
        ({"force": -5.0}, "--force -5"),
        ({"force": float("nan")}, "--force nan"),
        ({"seed": -1}, "--seed -1"),
        ({"toolpath": tmp_path / "x.nc"}, "needs --cell"),
    ):
        with pytest.raises(CompensatorError, match=words):
            plan_file(model, out, **options)
    with pytest.raises(StiffnessError, match="under 500000 N a joint of the model would give way"):
        plan_file(model, out, force=5e5)
    with pytest.raises(CompensatorError, match="is an input"):
        plan_file(model, model)
    other, _ = Lab("ur10").session(tmp_path / "ur", 1, setups=3)
    with pytest.raises(StiffnessError, match="ur10 is not that of the model"):
        plan_file(model, out, sessions=[Path(other.source)])
    session, _ = Lab().session(tmp_path / "abb", 1, setups=3)
    model.write_text(MODEL.replace('"uncompensated"', '"calibrated-out"'))
    with pytest.raises(StiffnessError, match="gravity = 'uncompensated', but the model"):
        plan_file(model, out, sessions=[Path(session.source)])
    assert not out.exists()


def test_sessions_give_tool_reflectors_noise_and_force(tmp_path: Path) -> None:
    session, _ = Lab().session(tmp_path / "abb", 1, setups=4)
    model, out, report = tmp_path / "m.toml", tmp_path / "plan.csv", tmp_path / "plan.json"
    model.write_text(MODEL)
    done = plan_file(model, out, sessions=[Path(session.source)], count=3, json=report)
    assert [r.name for r in done.plan.design.reflectors] == ["tcp", "side", "elbow"]
    assert done.plan.design.model.tool.position == pytest.approx(TCP)
    assert done.plan.loading.force == pytest.approx(800.0, rel=0.01)
    told = json.loads(report.read_text())
    assert all(p["sd_after"] < p["sd_before"] for p in told["parameters"])
    # the session, not the model's own deviations, says what is known
    assert np.allclose(done.plan.before, done.plan.design.measured(session))


CELL = """schema = "cell/1"
robot = "abb-irb6600-175-255"
model = "m.toml"
[tool]
xyz = [0.0, 0.0, 250.0]
mass = 35.0
com = [0.0, 0.0, 120.0]
[workobject]
xyz = [1500.0, -100.0, 800.0]
[process]
kind = "constant"
frame = "path"
wrench = [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0]
"""


def test_a_toolpath_says_what_matters(tmp_path: Path) -> None:
    """The deflection at its poses is known better than from a plan for all joints alike, and no joint is left out."""
    model, cell, path = tmp_path / "m.toml", tmp_path / "cell.toml", tmp_path / "part.nc"
    model.write_text(MODEL)
    cell.write_text(CELL)
    path.write_text("G21 G90 G17\nG0 X0 Y0 Z20\nG1 Z0 F600\nG1 X300\nG1 Y150\nG1 X0\nG0 Z20\nM30\n")
    options = {"cell": cell, "force": 600.0, "count": 6}
    report = tmp_path / "p.json"
    meant = plan_file(model, tmp_path / "v.csv", toolpath=path, json=report, **options)
    alike = plan_file(model, tmp_path / "d.csv", **options)
    told = json.loads(report.read_text())
    assert told["criterion"] == "V"
    sd = told["path_deflection_sd_mm"]
    assert sd["after"] < 0.02 * sd["before"]
    assert sd["after"] == pytest.approx(1e3 * (meant.plan.path_sd(meant.plan.after) or 0))
    matters = meant.plan.matters
    assert matters is not None
    other = np.trace(matters @ np.linalg.inv(alike.plan.after + np.eye(6)))
    assert sd["after"] < 0.95e3 * np.sqrt(other)
    assert told["undetermined"] == []
    assert alike.report["path_deflection_sd_mm"] is None
