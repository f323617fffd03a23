"""Where a robot must not be sent: each refusal names pose, line, value and bound, and leaves nothing behind."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CompensatorError, PathError, SolveError
from compensator.tasks.compensate import compensate_file, preview_file
from stiffness.kinematics.posture_search import PostureSearch
from stiffness.kinematics.solver import inverse_kinematics
from stiffness.robot.load import load_robot
from tests.compensator.posture_toolpaths import between, job_at
from tests.compensator.small_job import ABB, ROWS, STIFFNESS, Files, files
from toolpaths.errors import ToolpathError

HOME = [10, 15, 20, 30, 40, -20]
AWAY = [12, 16, 21, 32, 42, -18]
UR10_MODEL = {"effects": {"joint-stiffness": {"k_nm_per_rad": [3e4, 3e4, 2e4, 6e3, 5e3, 5e3]}}}


def wrench(*six: float, frame: str = "tool") -> dict[str, Any]:
    """A constant process."""
    return {"process": {"kind": "constant", "frame": frame, "wrench": list(six)}}


LATERAL = wrench(100.0, 0.0, 0.0, 0.0, 0.0, 0.0)
LIGHT = wrench(20.0, -10.0, 15.0, 0.5, 0.2, 0.1, frame="base")


def solve(**bounds: Any) -> dict[str, Any]:
    """[solve] with a fixed turn about the tool axis."""
    return {"solve": {"free_tool_axis": False, **bounds}}


def refusal(job: Files, kind: type[Exception]) -> str:
    """The message of compensate; there must be no output."""
    with pytest.raises(kind) as caught:
        compensate_file(job.toolpath, job.cell, job.out / "out.mod", json=job.out / "out.json")
    assert job.left() == []
    return str(caught.value)


Case = tuple[str, str, Sequence[Sequence[float]], dict[str, Any], dict[str, Any], type[Exception], str]
SINGULAR = (
    r"path\.csv:\d+ \(pose \d+\): too near the {} singularity \({}\): .* is ([-\d.e]+), bound ([\d.]+) \(solve\.{}\)"
)
CASES: list[Case] = [
    ("wrist", ABB, between([10, 15, 20, 30, 10, -20], [10, 15, 20, 30, 0.5, -20], 12), {}, {}, PathError,
     SINGULAR.format("wrist", "nominal", "min_wrist_angle")),
    ("wrist of the command", ABB, between([10, 15, 20, 30, 2.1, -20], [12, 15, 20, 30, 2.1, -20], 4),
     wrench(600.0, 0.0, 0.0, 0.0, 0.0, 0.0), {}, PathError, SINGULAR.format("wrist", "commanded", "min_wrist_angle")),
    ("elbow", ABB, between([10, 15, -60, 30, 40, -20], [10, 15, -79.5, 30, 40, -20], 12), {}, {}, PathError,
     SINGULAR.format("elbow", "nominal", "min_elbow_angle")),
    ("shoulder", ABB, between([10, -64, 10, 30, 40, -20], [10, -64, 16.7, 30, 40, -20], 30), {}, {}, PathError,
     SINGULAR.format("shoulder", "nominal", "min_shoulder")),
    ("jacobian", "ur10", between([10, -60, 80, -110, -40, 20], [10, -60, 80, -110, -1, 20], 8), LIGHT, UR10_MODEL,
     PathError, SINGULAR.format("jacobian", "nominal", "min_singular_value")),
    ("joint limit", ABB, between([10, 15, 20, 30, 100, -20], [10, 15, 20, 30, 125, -20], 12), {}, {}, PathError,
     r"path\.csv:\d+ \(pose \d+\): nominal angle of joint 5 is (12\d\.\d+) deg, limits are -120\.000 \.{3} (120)\.0"),
    ("joint limit of the command", ABB, between([10, 15, 20, 30, 119.99, -20], [10, 16, 21, 31, 119.99, -19], 4),
     wrench(-600.0, 0.0, 0.0, 0.0, 0.0, 0.0), {}, PathError,
     r"path\.csv:2 \(pose 0\): commanded angle of joint 5 is (120\.\d+) deg, limits are -120\.000 \.{3} (120)\.0"),
    ("configuration flip", ABB, between([10, 15, 20, 30, 0.3, -20], [12, 15, 20, 30, 0.3, -20], 4),
     {**LATERAL, "gravity": "uncompensated", **solve(min_wrist_angle=0.001, max_correction=50.0)},
     {"effects": {"joint-stiffness": {"k_nm_per_rad": [*STIFFNESS[:4], 2e4, 3.7e4]}}}, SolveError,
     r"path\.csv:2 \(pose 0\): the corrected command lies in another arm configuration \(ABB cfx 1, path 0\)()()"),
    ("joint jump", ABB, [[10, 15, 20, 5, 5, -20], [10, 15, 20, 175, 5, -190]], solve(min_wrist_angle=0.2), {},
     PathError,
     r"path\.csv:3 \(pose \d+\): joint 4 would jump ([\d.]+) deg .*max_joint_step is (30) deg"),
    ("correction above its bound", ABB, between(HOME, AWAY, 8), solve(max_correction=0.8), {}, SolveError,
     r"path\.csv:\d+ \(pose \d+\): correction (0\.[89]\d+) mm is above solve\.max_correction = (0\.8) mm \(\d+ poses"),
    ("whole sag", ABB, between(HOME, AWAY, 8), {"gravity": "uncompensated", "tool": {"mass": 60.0}}, {}, SolveError,
     r"correction (5\.\d+) mm is above solve\.max_correction = (5) mm.*gravity"),
    ("too soft joints", ABB, between(HOME, AWAY, 8), {},
     {"effects": {"joint-stiffness": {"k_nm_per_rad": [100.0] * 6}}}, SolveError,
     r"15 of 15 poses have no command .* the worst: .*path\.csv:\d+ \(pose \d+\): ([\d.e+-]+)()"),
    ("too soft tool", ABB, between(HOME, AWAY, 8), {},
     {"effects": {"joint-stiffness": {"k_nm_per_rad": [1e6] * 6},
                  "tool-compliance": {"linear_m_per_n": [1e-3] * 3, "angular_rad_per_nm": [1e-2] * 3}}}, SolveError,
     r"15 of 15 poses have no command .* the worst: .*path\.csv:\d+ \(pose \d+\): ([\d.e+-]+)()"),
    ("joint not identified", ABB, between(HOME, AWAY, 8),
     wrench(-900.0, 600.0, 750.0, 15.0, -12.0, 9.0, frame="workobject"),
     {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS, "identified": [True, True, False, True, True, True]}}},
     SolveError, r"path\.csv:\d+ \(pose \d+\): the process loads joint 3 with (\d+) N\*m, .*model\.toml()"),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=[c[0] for c in CASES])
def test_refused(tmp_path: Path, case: Case) -> None:
    """The words, and that the value named is beyond the bound named."""
    _, robot, degrees, cell, model, kind, message = case
    text = refusal(job_at(tmp_path, robot, degrees, cell, model), kind)
    found = re.search(message, text)
    assert found, text
    value, bound = found.groups()
    if bound and "too near the" in text:
        assert float(value) < float(bound)
    elif bound and "cfx" not in text:
        assert float(value) > float(bound)


@pytest.mark.parametrize(("case"), [c for c in CASES if "singularity" in c[6]], ids=lambda c: c[0])
def test_the_bound_is_what_refuses(tmp_path: Path, case: Case) -> None:
    """With a bound that lies below the value named, the pose named is not the first to be refused."""
    _, robot, degrees, cell, model, kind, message = case
    found = re.search(message, refusal(job_at(tmp_path, robot, degrees, cell, model), kind))
    assert found
    key = re.search(r"solve\.(\w+)", found[0])
    assert key
    value = {"min_wrist_angle": np.degrees, "min_elbow_angle": np.degrees, "min_shoulder": lambda v: v * 1e3}.get(
        key[1], float
    )(float(found[1]) * 0.9)
    job = job_at(tmp_path, robot, degrees, {**cell, **solve(**{key[1]: float(value)})}, model)
    try:
        compensate_file(job.toolpath, job.cell, job.out / "out.csv")
    except CompensatorError as e:
        assert found[0].split(":")[1] not in str(e)


def test_preview_warns_where_compensate_refuses(tmp_path: Path) -> None:
    """A joint whose stiffness is not identified: the same words, in findings and notes, and the file is written."""
    (case,) = (c for c in CASES if c[0] == "joint not identified")
    _, robot, degrees, cell, model, kind, message = case
    job = job_at(tmp_path, robot, degrees, cell, model)
    refused = re.search(message, refusal(job, kind))
    assert refused
    shown = preview_file(job.toolpath, job.cell, csv=job.out / "out.csv")
    (warning,) = (f for f in shown.findings if f.level == "warning" and "not identified" in f.what)
    said = re.search(message, str(warning))
    assert said and abs(int(said[1]) - int(refused[1])) <= 0.02 * int(refused[1]) > 1
    assert str(warning) in shown.report["notes"]
    assert (job.out / "out.csv").exists()
    sure = {"effects": {"joint-stiffness": {"k_nm_per_rad": STIFFNESS}}}
    (tmp_path / "sure").mkdir()
    other = job_at(tmp_path / "sure", robot, degrees, cell, sure)
    assert not any("not identified" in f.what for f in preview_file(other.toolpath, other.cell).findings)


def test_a_line_at_fault_is_named_as_in_the_file(tmp_path: Path) -> None:
    """Line 7 of the file goes out of reach: the message says line 7 and shows the point as the file has it."""
    rows = [list(r) for r in ROWS]
    rows[5][:3] = [2500.0, 60.0, 700.0]
    text = refusal(files(tmp_path, rows=rows), PathError)
    assert re.search(r"path\.csv:7 \(pose \d+\): out of reach of abb-irb6600-175-255: TCP \([\d., ]+\) mm", text), text
    away = re.search(r"is (\d+) mm from the base origin", text)
    assert away and float(away[1]) > 2500


@pytest.mark.parametrize("word", ["nan", "inf", "-inf", "1e400"])
@pytest.mark.parametrize("column", [0, 3, 6])
def test_not_a_number_in_the_toolpath(tmp_path: Path, word: str, column: int) -> None:
    """NaN and infinity in any column, by line and column."""
    rows: list[list[Any]] = [list(r) for r in ROWS]
    rows[3][column] = word
    text = refusal(files(tmp_path, rows=rows), ToolpathError)
    assert re.search(rf"path\.csv:5: column {['x_mm', '', '', 'i', '', '', 'feed_mm_min'][column]}: ", text), text


def test_nothing_to_cut(tmp_path: Path) -> None:
    """A file of rapids only."""
    text = refusal(files(tmp_path, rows=[r for r in ROWS if r[-1] == "rapid"]), CompensatorError)
    assert re.search(r"path\.csv: no cutting move", text)


def test_start_in_another_configuration_is_kept_to(tmp_path: Path) -> None:
    """A [start] with the wrist turned over picks that configuration: refused where it cannot follow."""
    flipped = [10.0, 15.0, 20.0, 30.0 - 180.0, -40.0, -20.0 + 180.0]
    job = job_at(tmp_path, ABB, between(HOME, AWAY, 6), {"start": {"joints": flipped}})
    done = compensate_file(job.toolpath, job.cell, job.out / "out.csv")
    q = np.degrees(done.result.path.q)
    assert np.allclose(q[0], flipped, atol=1e-6) and np.all(q[:, 4] < 0)


def test_tool_call_without_an_entry(tmp_path: Path) -> None:
    """G-code that calls T2 while the cell has [tools.1] only, and one that moves before any call."""
    tool = {"xyz": [0.0, 0.0, 240.0]}
    cell = {"tool": None, "tools": {"1": tool}}
    job = files(tmp_path, cell)
    nc = tmp_path / "path.nc"
    nc.write_text("G21 G90\nT1 M6\nG0 X0 Y0 Z50\nG1 Z0 F500\nT2 M6\nG1 X50\n")
    text = refusal(Files(tmp_path, nc, job.cell), CompensatorError)
    assert re.search(r"path\.nc:6: tool 2 cuts, but .*cell\.toml has \[tools\.N\] for 1 only", text)
    nc.write_text("G21 G90\nG0 X0 Y0 Z50\nG1 Z0 F500\nT1 M6\nG1 Z20\n")
    text = refusal(Files(tmp_path, nc, job.cell), CompensatorError)
    assert re.search(r"path\.nc:3: a cut before any tool call, but .*cell\.toml has \[tools\.N\] for 1 only", text)
    nc.write_text("G21 G90\nG0 X0 Y0 Z50\nT1 M6\nG0 X0 Y0 Z50\nG1 Z0 F500\nG1 X20\n")  # a rapid before a call
    assert compensate_file(nc, job.cell, job.out / "a.csv").report["n_cut"] > 0


def test_a_preview_without_equilibrium(tmp_path: Path) -> None:
    """What is too soft to stand is refused in a preview too, by file and line."""
    soft = {"effects": {"joint-stiffness": {"k_nm_per_rad": [100.0] * 6}}}
    job = job_at(tmp_path, ABB, between(HOME, AWAY, 8), {}, soft)
    with pytest.raises(CompensatorError) as caught:
        preview_file(job.toolpath, job.cell, csv=job.out / "out.csv")
    assert job.left() == []
    assert re.search(r"path\.csv:\d+ \(pose [\d.]+ of the file\): no static equilibrium", str(caught.value))


def test_free_turn_and_a_lateral_force_in_the_tool_frame(tmp_path: Path) -> None:
    """Only an axial force and moment make sense while the turn about the tool axis is open."""
    axial = wrench(0.0, 0.0, 200.0, 0.0, 0.0, 3.0)
    for k, lateral in ((0, 100.0), (1, -50.0), (3, 2.0), (4, -2.0)):
        bad = wrench(*[lateral if i == k else 0.0 for i in range(6)])
        text = refusal(files(tmp_path, bad), CompensatorError)
        assert re.search(r"cell\.toml: process\.frame = 'tool' with a lateral force or moment", text)
    job = files(tmp_path, axial)
    assert compensate_file(job.toolpath, job.cell, job.out / "a.csv").files
    # a fixed turn is not enough: the file itself has to say the orientation
    both = files(tmp_path, {**LATERAL, "solve": {"free_tool_axis": False}})
    (both.out / "a.csv").unlink()
    assert "fixed orientation" in refusal(both, CompensatorError)


@pytest.mark.parametrize("orientations", [True, False], ids=["fixed", "turn open"])
def test_the_first_pose_out_of_reach_is_named_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, orientations: bool
) -> None:
    """An arm without a closed form: 815 poses, the last quarter beyond it; no search for every posture is begun."""
    searched: list[int] = []
    every = PostureSearch._every
    monkeypatch.setattr(PostureSearch, "_every", lambda self, pose: searched.append(1) or every(self, pose))
    rows = [[float(k), 0.0, 0.0, *([0.0, 1.0, 0.0, 0.0] if orientations else [0.0, 0.0, 1.0])] for k in range(815)]
    header = ("x_mm", "y_mm", "z_mm", *(("qw", "qx", "qy", "qz") if orientations else ("i", "j", "k")))
    model = {"robot": "ur10", "effects": {"joint-stiffness": {"k_nm_per_rad": [3e4] * 6}}}
    tool = {"xyz": [0.0, 0.0, 150.0], "rpy": [0.0, 0.0, 0.0], "mass": None, "com": None}
    work = {"xyz": [600.0, 200.0, 100.0], "rpy": [0.0, 0.0, 0.0]}
    job = files(tmp_path, {"robot": "ur10", "tool": tool, "workobject": work}, model, rows, header)
    text = refusal(job, PathError)
    found = re.search(r"path\.csv:(\d+) \(pose \d+\): out of reach of ur10: TCP \(([\d.]+), 0\.00, 0\.00\) mm", text)
    assert found and searched == []
    # a UR10 that stretches down to a flange that looks down reaches as far as its wrist may be from axis 1
    robot = load_robot("ur10")
    inverse = inverse_kinematics(robot)
    pose = np.eye(4)
    pose[:3, :3] = np.diag([1.0, -1.0, -1.0])

    def reached(x: float) -> bool:
        turned = pose.copy()
        turned[:3, 3] = [0.6 + x / 1e3, 0.2, 0.25]
        return len(inverse.all(turned)) > 0

    x = float(found[2])
    assert 300.0 < x < 800.0 and not reached(x) and reached(x - 1.0) and int(found[1]) == int(x) + 2
