"""What scripts outside rely on: keys, units and columns of interface.md, by value; same inputs, same bytes."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.errors import CompensatorError
from compensator.tasks.compensate import Done, compensate_file, preview_file
from stiffness.robot.load import load_robot
from tests.compensator.independent_statics import Arm
from tests.compensator.small_job import ABB, CELL, ROWS, STIFFNESS, columns, files, merged, nothing_but_findings

HEADER = (
    "index,kind,x_mm,y_mm,z_mm,qw,qx,qy,qz,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,feed_mm_min,nominal_x_mm,"
    "nominal_y_mm,nominal_z_mm,nominal_qw,nominal_qx,nominal_qy,nominal_qz,fx_n,fy_n,fz_n,mx_nm,my_nm,mz_nm,"
    "dx_mm,dy_mm,dz_mm,source_line"
)
KEYS = {
    "n_poses": int, "n_cut": int, "predicted_error_mm": dict, "max_correction_mm": float, "reversals": list,
    "solve": dict, "not_applied": list, "seconds": float,
}  # fmt: skip
BACKLASH = {"gap_rad": [6e-5, 5e-5, 6e-5, 1.1e-4, 1.6e-4, 2.2e-4], "breakaway_nm": [1e4] * 6}
PLAY = {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}, "backlash": BACKLASH}}
POSE = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")


def both(folder: Path, cell: dict[str, Any] | None = None, model: dict[str, Any] | None = None) -> tuple[Done, Done]:
    """Preview and compensation of the small job; a.csv, p.csv and both summaries are in `out`."""
    job = files(folder, cell, model)
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv", json=job.out / "a.json")
    shown = preview_file(job.toolpath, job.cell, csv=job.out / "p.csv", json=job.out / "p.json")
    return done, shown


def test_columns(tmp_path: Path) -> None:
    """Exactly those of the interface, in their order, in both commands; kinds and lines as in the file."""
    both(tmp_path)
    for name in ("a.csv", "p.csv"):
        with open(tmp_path / "out" / name, newline="") as stream:
            rows = list(csv.reader(stream))
        assert rows[0] == HEADER.split(",")
        assert all(len(row) == 33 for row in rows)
        assert [row[0] for row in rows[1:]] == [str(k) for k in range(len(rows) - 1)]
        assert {(row[1], int(row[-1])) for row in rows[1:]} == {
            ("rapid", 2), ("rapid", 3), ("cut", 4), ("cut", 5), ("cut", 6), ("rapid", 7)
        }  # fmt: skip
        feed = {int(row[-1]): row[15] for row in rows[1:] if row[1] == "cut"}
        assert {k: float(v) for k, v in feed.items()} == {4: 300.0, 5: 1200.0, 6: 1200.0}


def test_values_of_the_columns(tmp_path: Path) -> None:
    """nominal is the file; command plus deflection is nominal, where deflection and wrench are in base axes."""
    both(tmp_path)
    out = tmp_path / "out" / "a.csv"
    cut = np.array([row.split(",")[1] == "cut" for row in out.read_text().splitlines()[1:]])
    nominal = columns(out, *(f"nominal_{c}" for c in POSE))
    for row in ROWS:
        assert np.abs(nominal[:, :3] - row[:3]).max(axis=1).min() < 1e-6
    assert np.allclose(Rotation.from_quat(nominal[:, [4, 5, 6, 3]]).apply([0, 0, 1]), [0, 0, -1], atol=1e-9)
    command, work = columns(out, *POSE), Rotation.from_euler("z", 20, degrees=True)
    assert np.allclose(np.linalg.norm(command[:, 3:], axis=1), 1, atol=1e-9)
    deflected = command[:, :3] + work.inv().apply(columns(out, "dx_mm", "dy_mm", "dz_mm"))
    assert np.abs(deflected - nominal[:, :3])[cut].max() < 3e-6
    assert np.linalg.norm(command[:, :3] - nominal[:, :3], axis=1)[cut].min() > 0.2
    force, moment = np.array([-300.0, 200.0, 250.0]), np.array([5.0, -4.0, 3.0])
    assert np.allclose(columns(out, "fx_n", "fy_n", "fz_n")[cut], work.apply(force), atol=1e-6)
    assert np.allclose(columns(out, "mx_nm", "my_nm", "mz_nm")[cut], work.apply(moment), atol=1e-6)


def test_preview_writes_the_nominal_path(tmp_path: Path) -> None:
    """Command equal to nominal, to the digit; dx..dz the error there, by a statics of its own; nothing corrected."""
    _, shown = both(tmp_path)
    out = tmp_path / "out" / "p.csv"
    with open(out, newline="") as stream:
        for row in csv.DictReader(stream):
            assert [row[c] for c in POSE] == [row[f"nominal_{c}"] for c in POSE]
    q = np.radians(columns(out, *(f"q{k}_deg" for k in range(1, 7))))
    wrench = columns(out, "fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
    arm = Arm(load_robot(ABB), CELL["tool"], {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}, calibrated_out=True)
    zero = [arm.tcp(a, np.zeros(6))[:3, 3] for a in q]
    error = np.array([arm.tcp(a, w)[:3, 3] - z for a, w, z in zip(q, wrench, zero, strict=True)])
    assert np.abs(columns(out, "dx_mm", "dy_mm", "dz_mm") - 1e3 * error).max() < 1e-5
    assert shown.report["max_correction_mm"] == 0.0
    assert shown.report["predicted_error_mm"]["after"] == shown.report["predicted_error_mm"]["before"]


def test_json_keys(tmp_path: Path) -> None:
    """Names, types and sense of every number, in both commands."""
    done, shown = both(tmp_path, model=PLAY)
    for name, task in (("a.json", done), ("p.json", shown)):
        text = (tmp_path / "out" / name).read_text()
        report = json.loads(text)
        assert report == task.report and text.endswith("}\n")
        assert {k: type(report[k]) for k in KEYS} == KEYS
        error = report["predicted_error_mm"]
        assert {"before", "after"} <= set(error) and all(set(error[k]) == {"mean", "p95", "max"} for k in error)
        assert 0.2 < error["before"]["mean"] <= error["before"]["p95"] <= error["before"]["max"] < 5
        assert set(report["solve"]) == {"iterations_max", "unconverged"} and report["solve"]["unconverged"] == 0
        assert report["n_poses"] == len(task.result) and report["n_cut"] == int(task.result.cutting.sum())
        assert report["reversals"], "the L turns joints around"
        for r in report["reversals"]:
            assert r["where"] in {f"joint-{k}" for k in range(1, 7)} and 2 <= r["source_line"] <= 7
    a = json.loads((tmp_path / "out" / "a.json").read_text())
    assert a["predicted_error_mm"]["after"]["max"] < 5e-3
    out = tmp_path / "out" / "a.csv"
    size = np.linalg.norm(
        columns(out, "x_mm", "y_mm", "z_mm") - columns(out, *(f"nominal_{c}" for c in POSE[:3])), axis=1
    )
    assert a["max_correction_mm"] == pytest.approx(size.max(), abs=1e-5)
    assert a["solve"]["iterations_max"] >= 1


def test_reversals_are_where_the_angles_turn(tmp_path: Path) -> None:
    """Counted by hand on the angles of the program: sign changes of real moves, with their source line."""
    done, _ = both(tmp_path)
    q = columns(tmp_path / "out" / "a.csv", *(f"q{k}_deg" for k in range(1, 7)))
    line = columns(tmp_path / "out" / "a.csv", "source_line")[:, 0].astype(int)
    expected = set()
    for j in range(6):
        last = 0.0
        for k, step in enumerate(np.diff(q[:, j]), start=1):
            if abs(step) < 1e-4:
                continue
            if last and np.sign(step) != last:
                expected.add((f"joint-{j + 1}", int(line[k])))
            last = np.sign(step)
    found = {(r["where"], r["source_line"]) for r in done.report["reversals"]}
    assert expected and expected <= found
    assert len(found - expected) <= 2  # a turn of less than 1e-4 deg


def test_not_applied(tmp_path: Path) -> None:
    """Effects of another tool are listed and leave the result alone; the tool's own are applied."""
    spring = {"linear_m_per_n": [1e-6] * 3, "angular_rad_per_nm": [1e-5] * 3, "tool": "spindle-b"}
    model = {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}, "tool-compliance": spring}}
    plain, _ = both(tmp_path)
    without = (tmp_path / "out" / "a.csv").read_bytes()
    other, _ = both(tmp_path, {"tool": {"name": "spindle-a"}}, model)
    assert other.report["not_applied"] == ["tool-compliance"] and plain.report["not_applied"] == []
    assert (tmp_path / "out" / "a.csv").read_bytes() == without
    own, _ = both(tmp_path, {"tool": {"name": "spindle-b"}}, model)
    assert own.report["not_applied"] == []
    assert own.report["max_correction_mm"] > plain.report["max_correction_mm"] + 0.3
    # without names both are called "tool"
    model["effects"]["tool-compliance"] = {k: v for k, v in spring.items() if k != "tool"}
    unnamed, _ = both(tmp_path, model=model)
    assert unnamed.report["not_applied"] == []
    assert unnamed.report["max_correction_mm"] == own.report["max_correction_mm"]


def test_an_unknown_first_flank_is_flagged(tmp_path: Path) -> None:
    """Without [start], with gaps and no holding torque: the cutting poses and the spread stand in the summary."""
    tool = {"xyz": [30.0, -20.0, 420.0], "mass": None, "com": None}
    done, _ = both(tmp_path, {"tool": tool, "mount": {"rpy": [0.0, 0.0, 0.0]}}, PLAY)
    q = done.result.path.q
    still = np.abs(np.diff(q, axis=0)).sum(axis=0) < 1e-4
    flagged = done.report["unknown_state"]
    start = np.degrees(q[0]) + 5.0
    known, _ = both(tmp_path, {"start": {"joints": start.tolist()}}, PLAY)
    assert known.report["unknown_state"]["n_cut"] == 0
    # a cut right away: nothing is known of the flanks of its first poses
    job = files(tmp_path, None, PLAY, rows=ROWS[2:5])
    at_once = compensate_file(job.toolpath, job.cell, job.out / "a.csv").report["unknown_state"]
    assert 0 < at_once["n_cut"] <= 30 and 0.01 < at_once["max_spread_mm"] < 2
    # an approach in the air makes the flanks known of every joint that moves in it
    assert not still.any()
    assert flagged["n_cut"] == 0


def test_several_tools(tmp_path: Path) -> None:
    """Each pose is solved with its own tool, in one program; tool 0 is a number like any other."""
    nc = "G21 G90\nG0 X0 Y0 Z60\nG1 Z0 F500\nG1 X50\nG0 Z60\nT2 M6\nG0 X0 Y30\nG1 Z0 F400\nG1 X50\nG0 Z60\n"
    short, long = CELL["tool"], merged(CELL["tool"], {"xyz": [10.0, 5.0, 300.0], "name": "long", "mass": 45.0})
    job = files(tmp_path, {"tool": None, "tools": {"0": short, "2": long}})
    path = tmp_path / "path.nc"
    path.write_text(nc)
    done = compensate_file(path, job.cell, job.out / "a.csv")
    result = done.result
    tool = result.path.toolpath.tool
    assert set(tool) == {0, 2}
    effects = {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}
    for number, table in ((0, short), (2, long)):
        arm = Arm(load_robot(ABB), table, effects, calibrated_out=True)
        for k in np.flatnonzero((tool == number) & result.cutting)[::5]:
            reached = arm.tcp(result.command.q[k], result.wrench[k])
            assert np.abs(reached[:3, 3] - result.target.origin[k]).max() < 1e-9
    compensate_file(path, job.cell, job.out / "a.mod")
    text = (job.out / "a.mod").read_text()
    assert text.count("PERS tooldata") == 2
    names = {line.split(",")[-1].split("\\")[0].strip() for line in text.splitlines() if "MoveL" in line}
    assert len(names) == 2, names


def test_quaternions_in_a_free_turn_job_are_not_touched(tmp_path: Path) -> None:
    """The orientations of a csv come out as they went in, whatever free_tool_axis says."""
    q = Rotation.from_euler("xyz", [180, 10, 35], degrees=True).as_quat()[[3, 0, 1, 2]]
    rows = [[*r[:3], *q.tolist(), r[6], r[7]] for r in ROWS]
    header = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "feed_mm_min", "kind")
    job = files(tmp_path, rows=rows, header=header)
    compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    got = columns(job.out / "a.csv", *(f"nominal_{c}" for c in POSE[3:]))
    assert np.abs(np.abs(got @ q) - 1).max() < 1e-9


def test_same_inputs_same_bytes(tmp_path: Path) -> None:
    """Programs and csv to the byte, JSON but for the seconds; in other processes with other hash seeds too."""
    job = files(tmp_path, model=PLAY)
    seen: dict[str, set[bytes]] = {}
    for seed in ("0", "4711"):
        for name in ("a.csv", "a.mod", "a.src"):
            command = [
                sys.executable,
                "-m",
                "compensator.cli",
                "compensate",
                str(job.toolpath),
                "--cell",
                str(job.cell),
            ]
            run = subprocess.run(
                [*command, "-o", str(job.out / name), "--json", str(job.out / "a.json")],
                cwd=Path(__file__).resolve().parents[3], env={**os.environ, "PYTHONHASHSEED": seed},
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            assert run.returncode == 0 and run.stdout == "" and nothing_but_findings(run.stderr), run.stderr
            seen.setdefault(name, set()).add((job.out / name).read_bytes())
            report = json.loads((job.out / "a.json").read_text())
            assert report.pop("seconds") > 0
            seen.setdefault(f"json of {name}", set()).add(json.dumps(report).encode())
    assert len(seen) == 6 and all(len(v) == 1 for v in seen.values()), seen.keys()


def test_a_feed_that_the_file_does_not_give(tmp_path: Path) -> None:
    """The default of the cell is taken, and said."""
    rows = [[*r[:6], r[7]] for r in ROWS]
    job = files(
        tmp_path,
        {"program": {"default_feed": 777.0}},
        rows=rows,
        header=("x_mm", "y_mm", "z_mm", "i", "j", "k", "kind"),
    )
    done = compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    text = (job.out / "a.csv").read_text().splitlines()[1:]
    assert {row.split(",")[15] for row in text if ",cut," in row} == {"777"}
    assert any("no feed" in str(f) and "777" in str(f) for f in done.findings)


def test_a_zero_wrench_changes_nothing(tmp_path: Path) -> None:
    """No load, sag known to the controller: the program is the nominal path."""
    done, _ = both(tmp_path, {"process": {"kind": "constant", "frame": "base", "wrench": [0.0] * 6}})
    assert done.report["max_correction_mm"] < 1e-8 and done.report["predicted_error_mm"]["before"]["max"] < 1e-8
    out = tmp_path / "out" / "a.csv"
    assert np.abs(columns(out, *POSE[:3]) - columns(out, *(f"nominal_{c}" for c in POSE[:3]))).max() < 1e-6


def test_gravity_needs_masses(tmp_path: Path, shared: Path) -> None:
    """A URDF without inertias: uncompensated gravity is refused with the reason, calibrated-out runs."""
    urdf = shared / "data" / "robots" / "abb_irb6640_185_280.urdf"
    name = os.path.relpath(urdf, tmp_path)
    job = files(tmp_path, {"robot": name, "tip": None, "gravity": "uncompensated"}, {"robot": name})
    with pytest.raises(CompensatorError) as caught:
        compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    text = str(caught.value)
    assert "cell.toml: gravity = 'uncompensated' needs the link masses of abb_irb6640_185_280" in text
    assert "calibrated-out" in text
    assert job.left() == []
    job = files(tmp_path, {"robot": name, "tip": None}, {"robot": name, "effects": PLAY["effects"]})
    with pytest.raises(CompensatorError, match=r"backlash depends on the gravity torque"):
        compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    job = files(tmp_path, {"robot": name, "tip": None}, {"robot": name})
    assert (
        compensate_file(job.toolpath, job.cell, job.out / "a.csv").report["predicted_error_mm"]["after"]["max"] < 1e-5
    )


def test_frames_of_a_urdf(tmp_path: Path, shared: Path) -> None:
    """Other base or tip than the model's: refused by both names; the same ones: fine."""
    name = os.path.relpath(shared / "data" / "robots" / "kuka_kr210_r2700_2.urdf", tmp_path)
    tips = {"tip": "tool0"}
    job = files(tmp_path, {"robot": name, **tips}, {"robot": name})
    with pytest.raises(
        CompensatorError, match=r"cell\.toml: base .* and tip 'tool0' of the cell are not .*model\.toml"
    ):
        compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    job = files(tmp_path, {"robot": name, "base": "link_1"}, {"robot": name})
    with pytest.raises(CompensatorError, match=r"cell\.toml.*link_1"):
        compensate_file(job.toolpath, job.cell, job.out / "a.csv")
    assert job.left() == []
    job = files(tmp_path, {"robot": name, **tips}, {"robot": name, **tips})
    assert compensate_file(job.toolpath, job.cell, job.out / "a.csv").files
