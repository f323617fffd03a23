"""Traces of programs that ran on the plant, which shares no code with the product: what each kind tells."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.report.analysis.circular_test import circular_tests
from compensator.report.figures.ball_bar import ballbar_figure
from compensator.tasks.diagnose import diagnose_files
from compensator.tasks.identify import evaluate_file
from tests.compensator.plant_bench import Bench, write_poses
from tests.trace_bench import Ran, ballbar, both_ways, positions, run, surface, write_trace

K = [3.0e6, 2.7e6, 2.1e6, 4.2e5, 1.4e5, 5.6e4]
NOISE = 0.005  # mm
CENTRE = np.array([1.5, 0.0, 0.9])
PULL = {"kind": "constant", "frame": "base", "wrench": [0.0, 300.0, -200.0, 0.0, 0.0, 0.0]}
GAP = [1.2e-4, 0.0, 0.0, 0.0, 0.0, 0.0]


def bench(folder: Path, process: dict[str, Any] = PULL) -> Bench:
    return Bench(
        folder,
        "abb-irb6600-175-255",
        {"joint-stiffness": {"k_nm_per_rad": K}},
        {"xyz": list(CENTRE * 1e3), "rpy": [0.0, 0.0, 0.0]},
        process,
        start=[0.0, 10.0, 20.0, 0.0, 60.0, 0.0],
    )


def circles(
    folder: Path, *, planes: tuple[str, ...] = ("xy",), points: int = 120, process: Any = PULL, **ill: Any
) -> Ran:
    b = bench(folder, process)
    return run(b, both_ways(points=points, planes=planes), b.plant(**ill))


def raised(path: Path, more: float) -> None:
    """All deviations of a surface trace by so many mm more."""
    samples = path.with_name("surface-samples.csv")
    rows = list(csv.DictReader(samples.read_text().splitlines()))
    with samples.open("w", newline="") as stream:
        out = csv.DictWriter(stream, rows[0])
        out.writeheader()
        out.writerows({**row, "deviation": float(row["deviation"]) + more} for row in rows)


def diagnosed(path: Path) -> dict[str, Any]:
    return diagnose_files([path], path.parent / "model.toml", path.parent / "refined.toml").report


def added(report: dict[str, Any]) -> dict[str, list[str]]:
    return {a["effect"]: a["where"] for a in report["added"]}


def test_a_model_that_is_right_leaves_the_noise_of_a_tracker_that_follows_the_tool(tmp_path: Path) -> None:
    _, report = evaluate_file(positions(circles(tmp_path), NOISE), tmp_path / "model.toml")
    assert report["path"]["rms_mm"] == pytest.approx(NOISE, rel=0.1)
    assert report["path"]["noise_floor_mm"] == pytest.approx(NOISE)
    assert report["displacement"] is None and report["absolute"] is None


def test_between_two_rows_commands_are_interpolated_in_the_joints(tmp_path: Path) -> None:
    ran = circles(tmp_path, points=60)
    at = np.arange(1, len(ran.tcp) - 1) + 0.25
    low = np.floor(at).astype(int)
    q = 0.75 * ran.table.q[low] + 0.25 * ran.table.q[low + 1]
    between = dataclasses.replace(ran, walk=ran.bench.plant().walk(q, ran.table.wrench[low], start=ran.bench.q_start))
    path = positions(between, NOISE)
    lines = path.with_name("positions-samples.csv").read_text().splitlines()
    rest = [line.split(",", 1)[1] for line in lines[1:]]
    text = "\n".join([lines[0], *(f"{k},{row}" for k, row in zip(at, rest, strict=True))])
    path.with_name("positions-samples.csv").write_text(text + "\n")
    _, report = evaluate_file(path, tmp_path / "model.toml")
    assert report["path"]["rms_mm"] == pytest.approx(NOISE, rel=0.1)


def test_a_frame_that_is_not_known_is_placed_by_some_of_the_samples(tmp_path: Path) -> None:
    path = positions(circles(tmp_path, planes=("xy", "xz")), NOISE, registered=False)
    table = np.loadtxt(path.with_name("positions-samples.csv"), delimiter=",", skiprows=1)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    table[:, 1:] = (table[:, 1:] - [100.0, 200.0, 300.0]) @ turn
    text = "\n".join(",".join(map(str, row)) for row in table)
    path.with_name("positions-samples.csv").write_text("index,x,y,z\n" + text + "\n")
    result, report = evaluate_file(path, tmp_path / "model.toml")
    assert result.registered_on == 25
    assert report["path"]["rms_mm"] < 2 * NOISE


def test_centre_and_length_of_a_ballbar_are_estimated(tmp_path: Path) -> None:
    path = ballbar(circles(tmp_path, planes=("xy", "xz")), NOISE, CENTRE, error=0.02, aside=(0.4, -0.3, 0.2))
    report = diagnosed(path)
    assert report["verdict"] == "adequate"
    assert report["rms_mm"]["path"]["after"] < 1.3 * NOISE
    (placed,) = report["traces"]
    assert placed["center_mm"] == pytest.approx([1500.4, -0.3, 900.2], abs=0.5)
    assert [c["plane"] for c in report["iso230_4"]] == ["ZX", "XY"]


def test_the_circle_is_drawn_as_it_was_read_and_predicted(tmp_path: Path) -> None:
    path = ballbar(circles(tmp_path, points=60, gap=GAP, breakaway=1e9), NOISE, CENTRE)
    seen = evaluate_file(path, tmp_path / "model.toml")[0].seen
    figure = ballbar_figure([seen], [seen])
    (test,) = circular_tests(seen.session.path, seen.samples.position[:, 0])
    lines = {name: [d for d in figure["data"] if d["name"] == name] for name in ("measured", "the model at hand")}
    drawn = np.concatenate([np.hypot(d["x"], d["y"]) for d in lines["measured"]])
    assert np.ptp(drawn) == pytest.approx(0.25, rel=0.35) and len(drawn) == len(test.rows)
    enlarged = np.ptp(drawn) / test.bidirectional_circular_error
    assert len(lines["measured"]) == 2 and enlarged == pytest.approx(round(enlarged, -2), rel=1e-3)
    predicted = np.concatenate([np.hypot(d["x"], d["y"]) for d in lines["the model at hand"]])
    assert np.abs(predicted - drawn).max() > 0.03  # ten times the noise: it knows of no gap


def test_a_gap_in_joint_1_steps_the_radius_where_the_joint_turns(tmp_path: Path) -> None:
    ran = circles(tmp_path, gap=GAP, breakaway=1e9)
    path = ballbar(ran, NOISE, CENTRE)
    report = diagnosed(path)
    assert added(report) == {"backlash": ["joint-1"]}
    assert report["added"][0]["parameters"]["gap_rad"]["value"] == pytest.approx(GAP[0], rel=0.05)
    (test,) = report["iso230_4"]
    steps = {r["joint"]: abs(r["step_mm"]) for r in test["reversals"] if abs(r["at_deg"]) > 45}
    assert max(steps, key=lambda joint: steps[joint]) == "joint-1"
    assert test["bidirectional_circular_error"] > test["predicted"]["before"]["bidirectional_circular_error"]


def test_the_preload_finding_from_two_circles(tmp_path: Path) -> None:
    """Gap and ratio of joint 1 within 5 %: radius 150 mm, both directions, 5 um noise."""
    across = {"kind": "constant", "frame": "path", "wrench": [0.0, 400.0, -100.0, 0.0, 0.0, 0.0]}
    ran = circles(tmp_path, points=180, process=across, gap=GAP, breakaway=1e9, ratio=[0.6, 1, 1, 1, 1, 1])
    report = diagnosed(ballbar(ran, NOISE, CENTRE, error=0.02, aside=(0.4, -0.3, 0.2)))
    numbers = {name: p["value"] for a in report["added"] for name, p in a["parameters"].items()}
    assert added(report) == {"preload-softening": ["joint-1"], "backlash": ["joint-1"]}
    assert numbers["gap_rad"] == pytest.approx(GAP[0], rel=0.05)
    assert numbers["ratio"] == pytest.approx(0.6, rel=0.05)


def test_a_softer_joint_has_moved(tmp_path: Path) -> None:
    soft = [3.0e6, 2.7e6, 1.5e6, 4.2e5, 1.4e5, 5.6e4]
    report = diagnosed(positions(circles(tmp_path, planes=("xy", "xz"), stiffness=soft), NOISE))
    assert report["verdict"] == "parameters-changed"
    (moved,) = report["changed"]
    assert moved["where"] == ["joint-3"] and moved["to"] == pytest.approx(1.5e6, rel=0.01)


def contour(folder: Path, force: float) -> tuple[Ran, np.ndarray]:
    """A square whose walls have an uneven allowance; the cut pushes ``force`` times as hard as the table says."""
    corners = np.array([[-150, -100], [150, -100], [150, 100], [-150, 100], [-150, -100]], dtype=float)
    out = np.array([[0, -1, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], dtype=float)
    normals = np.repeat(out, 40, axis=0)
    share = np.tile(np.arange(40) / 40, 4)[:, None]
    wall = np.repeat(np.arange(4), 40)
    spots = corners[wall] + share * (corners[wall + 1] - corners[wall])
    b = bench(folder, {"kind": "table", "frame": "base", "file": "w.csv", "material": "aluminium"})
    load = 150 * (1 + 0.6 * np.sin(2 * np.pi * np.arange(160) / 37))
    pull = -load[:, None] * normals - 0.5 * load[:, None] * np.cross([0, 0, 1], normals) - [0, 0, 60]
    with open(folder / "w.csv", "w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["index", "fx", "fy", "fz", "mx", "my", "mz"])
        table.writerows([k, *row, 0, 0, 0] for k, row in enumerate(pull))
    rows = [[*p.round(6), 0, 0, 0, 1, 1000.0, "cut" if k else "rapid"] for k, p in enumerate(spots)]
    ran = run(b, rows, b.plant())
    walk = b.plant().walk(ran.table.q, force * ran.table.wrench, start=b.q_start)
    return dataclasses.replace(ran, walk=walk), normals


def test_a_larger_force_and_a_softer_arm_are_a_group_of_one_part(tmp_path: Path) -> None:
    ran, normals = contour(tmp_path, force=1.3)
    report = diagnosed(surface(ran, NOISE, normals))
    (found,) = report["added"]
    # a link that yields more, or joints that harden, leave the same on one part at one place
    assert found["effect"] == "cutting-force"
    assert sorted(found["confused_with"]) == ["joint-hardening", "joint-stiffness", "link-compliance"]
    assert found["parameters"]["change"]["value"] == pytest.approx([0.3] * 3, abs=0.02)
    assert any("one common change" in note for note in report["notes"])
    assert report["rms_mm"]["path"]["after"] < 1.3 * NOISE
    assert any("half the depth" in text for text in report["next_traces"])
    assert 'material = "aluminium"' in (tmp_path / "refined.toml").read_text()


def test_a_smaller_cutter_leaves_the_same_along_every_normal(tmp_path: Path) -> None:
    ran, normals = contour(tmp_path, force=1.0)
    path = surface(ran, NOISE, normals)
    raised(path, 0.03)
    report = diagnosed(path)
    (found,) = report["added"]
    assert found["effect"] == "cutter-size"
    assert found["parameters"]["radius_m"]["value"] == pytest.approx(3e-5, abs=3e-6)


def test_a_part_that_is_as_predicted_is_adequate(tmp_path: Path) -> None:
    ran, normals = contour(tmp_path, force=1.0)
    assert diagnosed(surface(ran, NOISE, normals))["verdict"] == "adequate"


def test_readings_that_are_late_show_one_latency(tmp_path: Path) -> None:
    """40 ms at 1 m/min are 0.67 mm of path."""
    ran = circles(tmp_path, points=120)
    late, step = 0.04, np.linalg.norm(np.diff(ran.tcp, axis=0), axis=1) / (1000.0 / 6e4)
    time = np.concatenate([[0.0], np.cumsum(step)])
    read = np.stack([np.interp(time - late, time, axis) for axis in ran.tcp.T], axis=1) * 1e3
    read += np.random.default_rng(5).normal(0, NOISE, read.shape)
    moving = np.arange(3, len(time))
    columns = {"index": moving, "time": time[moving], **dict(zip("xyz", read[moving].T, strict=True))}
    path = write_trace(ran, "positions", columns, NOISE, "late")
    _, report = evaluate_file(path, tmp_path / "model.toml")
    assert report["traces"][0]["latency_s"] == pytest.approx(late, rel=0.03)
    assert report["path"]["rms_mm"] < 2 * NOISE
    told = write_trace(ran, "positions", columns, NOISE, "told", instrument={"noise": NOISE, "latency": late})
    _, report = evaluate_file(told, tmp_path / "model.toml")
    assert "latency_s" not in report["traces"][0] and report["path"]["rms_mm"] < 2 * NOISE


def test_points_without_index_are_given_to_the_pose_that_cut_them(tmp_path: Path) -> None:
    ran, normals = contour(tmp_path, force=1.0)
    path = surface(ran, NOISE, normals)
    cell = tmp_path / "cell.toml"
    cell.write_text(cell.read_text() + '\n[process.cutter]\nshape = "flat"\ndiameter = 10.0\nlength = 20.0\n')
    rows = list(csv.DictReader(path.with_name("surface-samples.csv").read_text().splitlines()))
    for row in rows:  # from the tool's centre to the wall that its flank cut
        row.pop("index")
        for axis, along in zip("xyz", "ijk", strict=True):
            row[axis] = str(float(row[axis]) - 5.0 * float(row[along]))
    rows[0] |= {"x": "0", "y": "0"}
    with path.with_name("surface-samples.csv").open("w", newline="") as stream:
        out = csv.DictWriter(stream, rows[0])
        out.writeheader()
        out.writerows(rows)
    _, report = evaluate_file(path, tmp_path / "model.toml")
    assert report["path"]["rms_mm"] < 1.3 * NOISE
    assert any("1 points that no cut made" in note and "rows 2" in note for note in report["traces"][0]["notes"])


def test_preview_and_compensate_apply_a_cutting_force_to_the_same_process_only(tmp_path: Path) -> None:
    """And a program that is written tells the process without it, so that it does not count twice."""
    cut = {"kind": "constant", "frame": "path", "wrench": [-120.0, 80.0, -60.0, 0.0, 0.0, 0.0], "material": "aluminium"}
    toolpath = write_poses(tmp_path / "path.csv", both_ways(points=20))
    plain = bench(tmp_path, cut)
    effects = {**plain.effects, "cutting-force": {"change": [0.5, 0.5, 0.5], "material": "aluminium"}}
    effects["cutter-size"] = {"radius_m": 1e-5, "material": "aluminium"}
    _, as_said = plain.compensate(toolpath)
    done, harder = dataclasses.replace(plain, effects=effects).compensate(toolpath)
    assert done.report["not_applied"] == ["cutter-size"]
    np.testing.assert_array_equal(harder.wrench, as_said.wrench)
    told = {**cut, "wrench": [1.5 * w for w in cut["wrench"]]}
    _, by_hand = dataclasses.replace(plain, process=told).compensate(toolpath)
    np.testing.assert_allclose(harder.q, by_hand.q, atol=1e-9)
    elsewhere = {**cut, "material": "steel"}
    other, steel = dataclasses.replace(plain, effects=effects, process=elsewhere).compensate(toolpath)
    assert other.report["not_applied"] == ["cutting-force", "cutter-size"]
    np.testing.assert_array_equal(steel.q, as_said.q)
