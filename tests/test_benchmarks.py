"""The benchmarks compare things that agree: loop and product give the same numbers. No time is asserted."""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path

import numpy as np
import pytest

from benchmarks import commands, job, paths, poses, reading, start, table, timing
from benchmarks.rig import RICHER, WRENCH, Rig, rig, task
from stiffness.robot.load import load_robot
from toolpaths.files import read_back, read_toolpath
from toolpaths.toolpath import Toolpath

ABB = "abb-irb6600-175-255"
MODELS = [(ABB, {}), (ABB, {"richer": True}), (ABB, {"calibrated_out": True}), ("ur10", {})]
MODELS += [("ur10", {"richer": True, "calibrated_out": True})]


@pytest.fixture(params=MODELS, ids=lambda m: f"{m[0]} {' '.join(m[1])}".strip())
def bench(request: pytest.FixtureRequest) -> Rig:
    name, options = request.param
    return rig(name, **options)


def test_loop_and_product_find_the_same_commands(bench: Rig) -> None:
    path = task(bench, 40)
    product = poses.command(bench, path)
    assert product.converged.all()
    assert np.abs(product.q - path.start).max() > 1e-4  # there is something to correct
    np.testing.assert_allclose(poses.naive_command(bench, path), product.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(poses.naive_chain(bench, path), product.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(poses.whole_chain(bench, path).q, product.q, rtol=0, atol=1e-10)


def test_loop_and_product_deflect_alike(bench: Rig) -> None:
    path = task(bench, 40)
    product = poses.forward(bench, path)
    assert np.linalg.norm(product - path.position, axis=1).max() > 1e-4
    np.testing.assert_allclose(poses.naive_forward(bench, path), product, rtol=0, atol=1e-10)


def test_every_loop_of_joint_springs_finds_the_same_commands() -> None:
    arm = rig(ABB)
    path = task(arm, 25)
    product = poses.command(arm, path).q
    np.testing.assert_allclose(poses.naive_least_squares(arm, path), product, rtol=0, atol=1e-10)
    np.testing.assert_allclose(poses.naive_closed_form(arm, path), product, rtol=0, atol=1e-12)


def test_loop_and_product_agree_on_a_full_compliance_matrix_and_a_turned_tool() -> None:
    """Far from the diagonal and from the axes: a strong coupling, a flange that moves far, a tool at an angle."""
    rng = np.random.default_rng(7)
    root = rng.normal(size=(6, 6)) * np.array([2e-4, 2e-4, 2e-4, 1e-3, 1e-3, 1e-3])[:, None]
    c = root @ root.T
    spring = {
        "linear_m_per_n": np.diag(c)[:3],
        "angular_rad_per_nm": np.diag(c)[3:],
        "coupling": c[np.tril_indices(6, -1)],
    }
    base = rig(ABB, richer=True)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    tool = dataclasses.replace(base.tool, rotation=turn)
    arm = Rig(base.robot, tool, {**base.values, "tool-compliance": spring})
    q = task(base, 10).start
    product = arm.predictor.forward(q, WRENCH, np.zeros(0))
    for k, angles in enumerate(q):
        rotation, position = arm.naive.forward(angles, WRENCH)
        np.testing.assert_allclose(product.position[k], position, rtol=0, atol=1e-10)
        np.testing.assert_allclose(product.rotation[k], rotation, rtol=0, atol=1e-10)
    stiff = Rig(base.robot, tool, {"joint-stiffness": base.values["joint-stiffness"]})
    moved = np.linalg.norm(product.position - stiff.predictor.forward(q, WRENCH, np.zeros(0)).position, axis=1)
    assert moved.min() > 1e-4  # the spring matters


def test_the_loop_can_be_wrong() -> None:
    """A loop on another model does not pass for the product."""
    arm, other = rig(ABB, richer=True), rig(ABB)
    path = task(arm, 5)
    assert np.abs(poses.naive_command(other, path) - poses.command(arm, path).q).max() > 1e-5
    assert set(RICHER) <= set(arm.values)


def test_a_loop_needs_masses() -> None:
    weightless = dataclasses.replace(load_robot(ABB), mass=None, com=None)
    with pytest.raises(ValueError, match="no masses"):
        _ = Rig(weightless, rig(ABB).tool, rig(ABB).values).naive


def test_walk_row_by_row_and_in_blocks_agree() -> None:
    move, torque = paths.moves(3000)
    low, high = paths.naive_walk(move, torque)
    state = paths.walked(move, torque)
    np.testing.assert_allclose(state.low, low, rtol=0, atol=1e-18)
    np.testing.assert_allclose(state.high, high, rtol=0, atol=1e-18)
    assert low.min() == -5e-5 and low.max() == 5e-5 and np.any(np.abs(low) < 4e-5)  # flanks and in between
    assert (high - low).max() > 1e-5  # not known at first


def test_both_jobs_write_every_pose_of_the_path(tmp_path: Path) -> None:
    job.write_inputs(tmp_path, 30, memory=True)
    nominal = read_toolpath(tmp_path / "path.csv", chord=1e-5)
    assert job.text(tmp_path) == 30
    text = read_back(tmp_path / "text.mod", "rapid")
    np.testing.assert_allclose(text.position, nominal.position, rtol=0, atol=1e-7)
    count = job.compensate(tmp_path)
    program = read_back(tmp_path / "out.mod", "rapid")
    assert len(program.position) == count >= 30
    assert 1e-4 < np.abs(program.position[0] - nominal.position[0]).max() < 2e-2


def test_rows_of_every_part() -> None:
    rows = [*poses.run(many=30, few=3, rounds=1), *paths.run(many=200, few=20, rounds=1)]
    rows += [*commands.run((20, 40), rounds=1), *commands.run_filter((40,)), *start.run(rounds=1, poses=20)]
    assert all(np.isfinite(row.value) and row.value > 0 for row in rows)
    assert len({(row.group, row.what) for row in rows}) >= len(rows) - 12
    printed = table.text(rows)
    assert all(row.what in printed and row.group in printed for row in rows)
    assert json.loads(json.dumps([row.as_dict() for row in rows]))[0]["unit"] == "poses/s"


def test_ratio_is_the_median_of_the_rounds() -> None:
    assert timing.ratio([1.0, 8.0, 30.0], [1.0, 4.0, 3.0]) == 2.0


def test_rounds_run_in_turn() -> None:
    ran: list[str] = []
    seconds = timing.interleaved({"a": lambda: ran.append("a"), "b": lambda: ran.append("b")}, 2)
    assert ran == ["a", "b", "a", "b", "a", "b"]  # the first of each warms up
    assert [len(s) for s in seconds.values()] == [2, 2]


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no choice of cores on this system")
def test_cores_are_given_back() -> None:
    before = os.sched_getaffinity(0)
    with timing.cores(1) as got:
        assert got == 1 == len(os.sched_getaffinity(0))
    assert os.sched_getaffinity(0) == before


@pytest.mark.parametrize("name", reading.KINDS)
def test_files_of_the_reading_benchmark_are_read_whole(tmp_path: Path, name: str) -> None:
    kind = reading.KINDS[name]
    file = tmp_path / f"m.{kind.suffix}"
    file.write_text(kind.text(60))
    path = reading.reading(file)()
    assert isinstance(path, Toolpath) and len(np.unique(path.line)) >= 60
    assert len(np.unique(np.round(path.position, 9), axis=0)) > (1 if "arcs" in name or "circles" in name else 50)


def test_rows_of_the_reading_benchmark() -> None:
    rows = list(reading.run(40))
    assert len(rows) == 2 * len(reading.KINDS) and all(r.value > 0 and r.unit in ("s", "x") for r in rows)
