"""The lab against what was asked of it: noise, frames, order, wrong rows. No product code takes part."""

from __future__ import annotations

import csv
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from . import Arm, Plant, Tool, small_arms
from .geometry import Array
from .lab import Form, Noise, Notes, Setup, Step, Target, measure
from .lab_design import random_setups

QUIET = Noise(tracker=1e-12, force=0.0, torque=0.0)
TOOL = Tool((0.05, -0.02, 0.25), (0.3, -0.4, 0.5), mass=20.0, com=(0.0, 0.01, 0.12))
TARGETS = (
    Target("tcp", 6, TOOL.xyz),
    Target("elbow", 3, (0.2, 0.1, 0.05)),
    Target("floor", 0, (0.5, 0.4, 0.0)),
)


def arm() -> Arm:
    return small_arms.six_axis(tool=TOOL)


def plant(**more: Any) -> Plant:
    given = {"stiffness": [2e6, 1.8e6, 1.4e6, 2.8e5, 1e5, 4e4], "gap": 5e-5, "ratio": 0.8, **more}
    return Plant(arm(), **given)


def column(notes: Notes, *names: str) -> Array:
    return np.array([[row[name] for name in names] for row in notes.rows], dtype=float)


def test_readings_are_the_truth_and_noise_of_the_size_asked_for() -> None:
    setups = random_setups(arm(), 60, seed=1)
    notes = measure(plant(), setups, TARGETS, noise=Noise(3e-5, 0, 0.4, 0.07), seed=2)
    off = column(notes, "x", "y", "z") * 1e-3 - notes.truth.position
    assert off.shape == (900, 3)
    np.testing.assert_allclose(off.std(axis=0), 3e-5, rtol=0.1)
    np.testing.assert_allclose(off.mean(axis=0), 0, atol=4e-6)
    wrench = column(notes, "fx", "fy", "fz", "mx", "my", "mz") - notes.truth.wrench
    np.testing.assert_allclose(wrench.std(axis=0), [0.4] * 3 + [0.07] * 3, rtol=0.1)
    assert np.abs(np.corrcoef(np.hstack([off, wrench]).T) - np.eye(9)).max() < 0.15
    loaded = column(notes, "state")[:, 0] > 0
    assert np.linalg.norm(notes.truth.wrench[loaded, :3], axis=1) == pytest.approx(
        np.tile(np.repeat([150, 300.0], 3), 120)
    )
    assert not notes.truth.wrench[~loaded].any()


def test_sensor_read_once_per_state() -> None:
    setups = random_setups(arm(), 4, seed=1)
    notes = measure(plant(), setups, TARGETS, form=Form(sensed="state", repeats=2), seed=2)
    wrench = column(notes, "fx", "fy", "fz", "mx", "my", "mz").reshape(4 * 5 * 2, 3, 6)
    assert np.ptp(wrench, axis=1).max() == 0
    assert np.ptp(wrench.reshape(20, 2, 3, 6), axis=1).min() > 0


def test_one_load_by_hand() -> None:
    # one weightless joint about -y, link 1 m along x: 100 N up at 1.2 m lift by 120 N*m / K
    small = small_arms.planar([1.0], tool=Tool((0.2, 0, 0)))
    lab = Plant(small, stiffness=1e5, gravity_on=False)
    step = Step(force=(0, 0, 100.0))
    target = Target("tip", 1, (0.2, 0, 0))
    setups = [Setup([0.0], [0.1], [Step(), step])]
    notes = measure(lab, setups, [target], noise=QUIET, form=Form(about="flange"))
    lift = 1.2e2 / 1e5  # rad, less the second order
    x, y, z = column(notes, "x", "y", "z")[1]
    assert z == pytest.approx(1200 * lift, rel=1e-5)
    assert x == pytest.approx(1200 * np.cos(lift), abs=1e-5)
    assert y == pytest.approx(0, abs=1e-6)
    np.testing.assert_allclose(column(notes, "my")[1], -100 * 0.2 * np.cos(lift), rtol=1e-5)


@pytest.mark.parametrize("about", ["tcp", "flange", "base"])
@pytest.mark.parametrize("frame", ["base", "tool"])
def test_wrench_does_the_same_work_in_every_form(frame: Any, about: Any) -> None:
    setups = random_setups(arm(), 3, seed=4)
    notes = measure(plant(), setups, TARGETS[:1], noise=QUIET, form=Form(frame=frame, about=about))
    flange = notes.truth.walk.links[notes.truth.at, 6]
    tcp = flange @ TOOL.pose
    origin = {"tcp": tcp[:, :3, 3], "flange": flange[:, :3, 3], "base": np.zeros((15, 3))}[about]
    wrench = column(notes, "fx", "fy", "fz", "mx", "my", "mz")
    if frame == "tool":
        wrench = np.hstack([(tcp[:, :3, :3] @ part[:, :, None])[:, :, 0] for part in (wrench[:, :3], wrench[:, 3:])])
    moment = wrench[:, 3:] + np.cross(origin - tcp[:, :3, 3], wrench[:, :3])
    np.testing.assert_allclose(np.hstack([wrench[:, :3], moment]), notes.truth.wrench, atol=1e-9)


def test_pull_elsewhere_and_payload() -> None:
    q = np.array([0.1, 0.2, 0.3, 0.4, 0.9, 0.6])
    setup = Setup(q, [0.05] * 6, [Step(), Step(force=(0, 0, -400.0), pull="elbow"), Step(payload=15.0)])
    notes = measure(plant(gap=0), [setup], TARGETS, noise=QUIET)
    assert [row["load_link"] for row in notes.rows] == [""] * 3 + [3] * 3 + [""] * 3
    assert [row["load_at"] for row in notes.rows[3:6]] == ["elbow"] * 3
    np.testing.assert_allclose(column(notes, "fz")[:, 0], [0] * 3 + [-400] * 3 + [0] * 3)
    assert not column(notes, "mx", "my", "mz").any()
    assert column(notes, "payload")[:, 0].tolist() == [0] * 6 + [15] * 3
    torque = notes.truth.walk.torque[1:]  # row 0 is the move
    np.testing.assert_allclose((torque[1] - torque[0])[3:], 0, atol=0.1)  # a pull at link 3 does not reach the wrist
    elbow = notes.truth.position[4]
    # axis 1 is the base z axis: a vertical pull does nothing there; axis 2 stands at (0.29 cos, 0.29 sin, 0.68)
    assert (torque[1] - torque[0])[0] == pytest.approx(0, abs=1e-6)
    out = np.array([np.cos(0.1), np.sin(0.1), 0])
    lever = float((elbow - 0.29 * out) @ out)
    assert (torque[1] - torque[0])[1] == pytest.approx(400 * lever, rel=2e-3)  # about +y: down is positive
    com = (notes.truth.walk.links[3, 6] @ np.append(TOOL.com, 1))[:3]
    assert (torque[2] - torque[0])[1] == pytest.approx(15 * 9.80665 * float((com - 0.29 * out) @ out), rel=2e-3)


def test_approach_is_what_the_plant_remembers() -> None:
    setups = random_setups(arm(), 12, seed=5)
    notes = measure(plant(), setups, TARGETS[:1], form=Form(step=True))
    direction = notes.truth.walk.direction[notes.truth.at]
    approach = column(notes, *(f"approach{k}" for k in range(1, 7)))
    np.testing.assert_array_equal(approach, direction)
    assert {-1.0, 1.0} == set(approach.ravel())
    step = column(notes, *(f"step{k}" for k in range(1, 7)))
    np.testing.assert_array_equal(np.sign(step), approach)
    assert np.abs(step).min() > np.degrees(0.03) and np.abs(step).max() < np.degrees(0.15)
    # the load holds no flank here: the play is on the side of the last move
    np.testing.assert_allclose(notes.truth.walk.play[notes.truth.at], approach * 2.5e-5, atol=1e-12)


def test_unregistered_blocks_are_rigidly_placed() -> None:
    setups = random_setups(arm(), 9, seed=6)
    form = Form(registered=False, blocks=3, length="m", angle="rad")
    notes = measure(plant(), setups, TARGETS, noise=QUIET, form=form, seed=3)
    seen, block = column(notes, "x", "y", "z"), column(notes, "block")[:, 0].astype(int)
    assert block.tolist() == [0] * 45 + [1] * 45 + [2] * 45
    for k in range(3):
        rows = block == k
        there, here = notes.truth.position[rows], seen[rows]
        assert np.linalg.norm(there - here, axis=1).min() > 0.1
        for i, j in ((0, 1), (3, 17), (44, 20)):
            assert np.linalg.norm(here[i] - here[j]) == pytest.approx(np.linalg.norm(there[i] - there[j]), abs=1e-9)
        placed = here @ notes.truth.station[k][:3, :3].T + notes.truth.station[k][:3, 3]
        np.testing.assert_allclose(placed, there, atol=1e-9)
    q = np.array([s.q for s in setups])
    np.testing.assert_allclose(column(notes, "q3")[:, 0], np.repeat(q[:, 2], 15))


def test_probe_reads_poses() -> None:
    probe = [
        Target("a", 6, (0, 0, 0.2), group="p"),
        Target("b", 6, (0.1, 0, 0.2), group="p"),
        Target("c", 6, (0, 0.1, 0.2), group="p"),
    ]
    setups = random_setups(arm(), 80, seed=7, directions=0)
    notes = measure(plant(), setups, probe, noise=Noise(2e-5, 3e-4, 0, 0), seed=8)
    off = (column(notes, "x", "y", "z") * 1e-3 - notes.truth.position).reshape(80, 3, 3)
    seen = column(notes, "x", "y", "z").reshape(80, 3, 3)
    np.testing.assert_allclose(np.linalg.norm(seen[:, 1] - seen[:, 0], axis=1), 100, atol=1e-9)  # a rigid probe
    assert off[:, 0].std() == pytest.approx(2e-5, rel=0.15)
    across = np.linalg.norm(off[:, 1] - off[:, 0], axis=1)
    assert np.sqrt(np.mean(across**2)) == pytest.approx(0.1 * 3e-4 * np.sqrt(2), rel=0.2)


def test_rough_targets_are_off_in_the_file_only() -> None:
    rough = [replace(t, exact=t.name == "floor") for t in TARGETS]
    setups = random_setups(arm(), 2, seed=9)
    notes, exact = (
        measure(plant(), setups, targets, noise=QUIET, form=Form(rough=0.004), seed=1) for targets in (rough, TARGETS)
    )
    np.testing.assert_array_equal(notes.truth.position, exact.truth.position)
    for t in TARGETS:
        off = np.array(notes.table["reflectors"][t.name]["position"]) * 1e-3 - np.array(t.at)
        size = float(np.linalg.norm(off))
        assert size == 0 if t.name == "floor" else 0.001 < size < 0.02


def test_wrong_rows_are_named_and_the_others_are_right() -> None:
    setups = random_setups(arm(), 10, seed=10)
    right = measure(plant(), setups, TARGETS, seed=11)
    notes = measure(plant(), setups, TARGETS, form=Form(wrong=12), seed=11)
    off = np.linalg.norm(column(notes, "x", "y", "z") - column(right, "x", "y", "z"), axis=1)
    lines = np.flatnonzero(off > 0) + 2
    assert tuple(lines) == notes.truth.wrong_rows
    assert len(lines) == 12
    assert off[off > 0].min() > 1.0
    assert (off > 100).sum() >= 2  # mixed-up targets are far apart
    assert right.truth.wrong_rows == ()


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    setups = random_setups(arm(), 5, seed=12, pulls=(None, "elbow"), preload=20.0, payload=5.0)
    again = random_setups(arm(), 5, seed=12, pulls=(None, "elbow"), preload=20.0, payload=5.0)
    form = Form(registered=False, wrong=3, rough=0.001, seconds=20.0, repeats=2)
    for name, design, seed in (("a", setups, 1), ("b", again, 1), ("c", setups, 2)):
        measure(plant(), design, TARGETS, form=form, seed=seed).write(tmp_path / name, "ur10")
    a, b, c = ((tmp_path / name / "samples.csv").read_bytes() for name in "abc")
    assert a == b != c
    assert (tmp_path / "a/session.toml").read_bytes() == (tmp_path / "b/session.toml").read_bytes()
    assert len(a.splitlines()) == 1 + 5 * 6 * 2 * 3


def test_what_is_written(tmp_path: Path) -> None:
    robot = tmp_path / "own.urdf"
    robot.write_text(small_arms.URDF)
    setups = random_setups(arm(), 2, seed=13)
    form = Form(length="m", angle="rad", seconds=7.5, extra={"humidity": [0.4, 0.5], "shift": ["early", "late"]})
    form = replace(form, purposes={2: {"purpose": "joint-4", "points": {"A": "tcp"}}}, sd=True)
    path = measure(plant(calibrated_out=True), setups, TARGETS, form=form).write(tmp_path / "day", robot)
    assert (path.parent / "own.urdf").read_text() == small_arms.URDF
    table = tomllib.loads(path.read_text())
    assert table["robot"] == "own.urdf" and table["gravity"] == "calibrated-out"
    assert table["tool"] == {
        "xyz": [0.05, -0.02, 0.25],
        "rpy": [0.3, -0.4, 0.5],
        "mass": 20.0,
        "com": [0.0, 0.01, 0.12],
    }
    assert table["setups"] == {"2": {"purpose": "joint-4", "points": {"A": "tcp"}}}
    with (path.parent / "samples.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 30
    assert [float(r["time"]) for r in rows[:3]] == [0.0, 7.5, 15.0]
    assert {r["humidity"] for r in rows[:15]} == {"0.4"} and rows[29]["shift"] == "late"
    assert float(rows[0]["sx"]) == 2e-5
    floor = [[float(r[c]) for c in "xyz"] for r in rows if r["reflector"] == "floor"]
    np.testing.assert_allclose(floor, np.tile([0.5, 0.4, 0.0], (10, 1)), atol=1.2e-4)


def test_random_setups_are_reachable_and_varied() -> None:
    ur10 = Arm.load(Path(__file__).parents[2] / "stiffness/robot/data/ur10.toml", tool=Tool((0, 0, 0.1)))
    for robot in (ur10, arm()):
        setups = random_setups(robot, 40, seed=14, force=80.0, levels=(0.3, 0.6, 1.0), directions=1)
        q, move = np.array([s.q for s in setups]), np.array([s.move for s in setups])
        assert ((q >= robot.lower) & (q <= robot.upper)).all()
        assert ((q - move >= robot.lower) & (q - move <= robot.upper)).all()
        np.testing.assert_allclose(np.mean(np.sign(move), axis=0), 0, atol=0.5)
        lab = Plant(robot, stiffness=1e5, gravity_on=False)
        tcp = np.array([lab.nominal(angles)[:3, 3] for angles in q])
        assert tcp[:, 2].min() > 0.1
        assert np.ptp(tcp, axis=0).min() > 0.7 and np.ptp(q, axis=0).min() > 1.5
        ways = np.array([s.steps[-1].force for s in setups])
        np.testing.assert_allclose(np.linalg.norm(ways, axis=1), 80)
        assert np.linalg.eigvalsh(ways.T @ ways / 40 / 6400)[0] > 0.15  # all directions of space
        assert [float(np.linalg.norm(s.force)) for s in setups[0].steps] == pytest.approx([0, 24, 48, 80])


def test_a_pull_off_the_flange_needs_load_columns() -> None:
    setups = random_setups(arm(), 1, seed=15, pulls=("elbow",))
    with pytest.raises(ValueError, match="load columns"):
        measure(plant(), setups, TARGETS, form=Form(load_columns=False))
