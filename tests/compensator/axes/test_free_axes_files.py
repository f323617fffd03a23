"""Free axes from file to file: the words of each language, what is read back, verified, refused, and told."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from scipy.spatial.transform import Rotation

from compensator.axes import axis_refinement
from compensator.axes.free_axes import FreeAxes
from compensator.cell.job import load_job
from compensator.errors import CompensatorError
from compensator.path.planned_path import PlannedPath
from compensator.program.export import program_of
from compensator.report.json.verification import CONFIRMED
from compensator.solve.compensate import compensate
from compensator.solve.load_along import load_along
from compensator.solve.planned import sampled
from compensator.tasks.axis_map import axis_map_file
from compensator.tasks.compensate import compensate_file, preview_file
from compensator.tasks.place import place_file
from compensator.tasks.verify import verify_file
from tests.compensator.small_job import WORN, Files, files, milling
from toolpaths.errors import ToolpathError
from toolpaths.files import read_toolpath, write_program

RAIL = {"carries": "robot", "direction": [0.0, 1.0, 0.0], "free": True, "range": [-1500.0, 2500.0], "speed": 60.0,
        "acceleration": 40.0}  # fmt: skip
LONG: list[list[Any]] = [
    [0, 0, 60, 0, 0, 1, 0, "rapid"], [0, 0, -2, 0, 0, 1, 1200, "cut"], [0, 3800, -2, 0, 0, 1, 1200, "cut"],
    [0, 3800, 60, 0, 0, 1, 0, "rapid"],
]  # fmt: skip


def job(folder: Path, rows: list[list[Any]] | None = None, rail: dict[str, Any] | None = None, **cell: Any) -> Files:
    """A long cut along a rail, E1."""
    folder.mkdir(exist_ok=True)
    tables = {"external": {"E1": RAIL if rail is None else rail}, "sampling": {"spacing": 40.0}, **cell}
    return files(folder, tables, rows=LONG if rows is None else rows)


def table(file: Path) -> dict[str, np.ndarray]:
    """Columns of numbers of a csv."""
    with open(file, newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {k: np.array([float(r[k]) for r in rows]) for k in ("x_mm", "y_mm", "z_mm", "E1_mm")}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """The same path in every language that has external axes."""
    made = job(tmp_path_factory.mktemp("written"))
    done = compensate_file(made.toolpath, made.cell, made.out / "c.mod", json=made.out / "c.json")
    for name in ("c.src", "c.ls", "c.csv"):
        write_program(program_of(done.result, name="c"), made.out / name)
    return made


MOVES = {
    "c.mod": r"MoveL \[\[([-\d.]+),([-\d.]+),([-\d.]+)\],\[[^]]*\],\[[^]]*\],\[([-\d.]+),9E9,9E9,9E9,9E9,9E9\]\]",
    "c.src": r"LIN \{X ([-\d.]+),Y ([-\d.]+),Z ([-\d.]+),A [-\d.]+,B [-\d.]+,C [-\d.]+,S \d+,T \d+,E1 ([-\d.]+)\}",
    "c.ls": r"X = *([-\d.]+)  mm,\tY = *([-\d.]+)  mm,\tZ = *([-\d.]+)  mm,\n[^\n]*deg,\n\tE1= *([-\d.]+)  mm\n\};",
}


@pytest.mark.parametrize("name", list(MOVES))
def test_values_of_every_language(written: Files, name: str) -> None:
    """Pose and rail are the same in all of them: by the words of the language."""
    expected = table(written.out / "c.csv")
    text = (written.out / name).read_bytes().decode().replace("\r\n", "\n")
    found = np.array([[float(v) for v in m] for m in re.findall(MOVES[name], text)])
    for k, column in enumerate(("x_mm", "y_mm", "z_mm", "E1_mm")):
        np.testing.assert_allclose(found[:, k], expected[column], atol=6e-5)
    assert np.ptp(found[:, 3]) > 1000.0
    begin = {"c.mod": r"MoveAbsJ \[\[[^]]*\],\[([-\d.]+),9E9", "c.src": r"PTP \{E6AXIS: A1 [^}]*,E1 ([-\d.]+)\}"}
    if name in begin:
        start = re.search(begin[name], text)
        assert start is not None and float(start[1]) == pytest.approx(found[0, 3])


@pytest.mark.parametrize("name", ["c.mod", "c.src", "c.ls"])
def test_a_program_is_read_as_any_other(written: Files, name: str) -> None:
    """The readers of robot programs see the rail where the writer put it."""
    read = read_toolpath(written.out / name)
    assert read.setting is not None
    (values,) = read.setting.external.values()
    expected = table(written.out / "c.csv")["E1_mm"]
    np.testing.assert_allclose(values[-len(expected) :], expected, atol=6e-5)


@pytest.mark.parametrize(("program", "name"), [("c.mod", "eax_a"), ("c.mod", "E1"), ("c.src", "eax_a"), ("c.ls", "E1")])
def test_a_preview_of_the_program_sees_the_same_arm(written: Files, tmp_path: Path, program: str, name: str) -> None:
    """As a program with a rail that the cell declares, not free, by either name of the axis: the joint angles are those
    that were solved."""
    plain = job(tmp_path, rail={k: RAIL[k] for k in ("carries", "direction")})
    text = plain.cell.read_text().replace("[external.E1]", f"[external.{name}]")
    plain.cell.write_text(text)
    preview_file(written.out / program, plain.cell, csv=tmp_path / "p.csv")
    rows = [np.genfromtxt(f, delimiter=",", names=True, dtype=None, encoding="ascii") for f in
            (written.out / "c.csv", tmp_path / "p.csv")]  # fmt: skip
    at = [np.stack([r[c] for c in ("x_mm", "y_mm", "z_mm")], axis=1) for r in rows]
    solved = np.flatnonzero(rows[0]["kind"] == "cut")[3:-3:3]
    seen = [int(np.argmin(np.linalg.norm(at[1] - at[0][k], axis=1))) for k in solved]
    assert len(seen) > 20 and np.abs(at[1][seen] - at[0][solved]).max() < 1e-3
    for k in range(1, 7):
        np.testing.assert_allclose(rows[1][f"q{k}_deg"][seen], rows[0][f"q{k}_deg"][solved], atol=1e-4)


@pytest.mark.parametrize("name", ["c.nc", "c.script", "c.pgx", "c.jbi"])
def test_a_language_without_axes_is_refused_before_solving(tmp_path: Path, name: str) -> None:
    made = job(tmp_path)
    with pytest.raises(ToolpathError, match=r"no place for external axes, and E1 would be lost.*write RAPID, KRL"):
        compensate_file(made.toolpath, made.cell, made.out / name)
    assert made.left() == []


@pytest.mark.parametrize("carries", ["robot", "part"])
def test_gcode_that_is_filtered_in_place_has_none_either(tmp_path: Path, carries: str) -> None:
    table = {"carries": "part", "direction": [0.0, 0.0, 1.0], "center": [1500.0, 0.0, 700.0], "free": True,
             "range": [-90.0, 90.0]}  # fmt: skip
    made = job(tmp_path, rail=RAIL if carries == "robot" else table)
    code = tmp_path / "part.nc"
    code.write_text("G21 G90 G17\nT1 M6\nS5000 M3\nG0 X0 Y0 Z50\nG1 Z-2 F1200\nX60\nG0 Z50\nM30\n")
    with pytest.raises(ToolpathError, match=r"gcode has no place for external axes, and E1 would be lost"):
        compensate_file(code, made.cell, made.out / "c.nc")
    assert made.left() == []


def test_fanuc_has_three(tmp_path: Path) -> None:
    rows = [[0, 0, 60, 0, 0, 1, 0, "rapid"], [0, 0, -2, 0, 0, 1, 1200, "cut"], [50, 0, -2, 0, 0, 1, 1200, "cut"]]
    made = files(tmp_path, {"external": {"E4": RAIL}}, rows=rows)
    with pytest.raises((CompensatorError, ToolpathError), match="E4: group 1 of a TP program has E1 to E3"):
        compensate_file(made.toolpath, made.cell, made.out / "c.ls")


def test_same_bytes_and_verified(written: Files, tmp_path: Path) -> None:
    again = job(tmp_path)
    compensate_file(again.toolpath, again.cell, tmp_path / "c.mod")
    assert (tmp_path / "c.mod").read_bytes() == (written.out / "c.mod").read_bytes()
    verified = verify_file(tmp_path / "c.mod", again.cell, toolpath=[again.toolpath])
    verified.refuse_unconfirmed()
    assert verified.report["verdict"] == CONFIRMED and verified.report["predicted_error_mm"]["program"]["max"] < 0.001


def test_a_rail_that_was_moved_is_found(written: Files, tmp_path: Path) -> None:
    """30 mm further at one pose, the target with it: the arm does the same, and cuts the part elsewhere."""
    again = job(tmp_path)
    lines = (written.out / "c.mod").read_bytes().decode().split("\r\n")
    k = next(i for i, line in enumerate(lines) if i > len(lines) // 2 and "MoveL [[" in line)
    shift = Rotation.from_euler("z", -20, degrees=True).apply([0.0, 30.0, 0.0])  # along the rail, in the work object
    numbers = [float(v) for v in re.search(r"MoveL \[\[([^]]*)\]", lines[k])[1].split(",")] + shift
    lines[k] = re.sub(r"MoveL \[\[[^]]*\]", "MoveL [[{:.4f},{:.4f},{:.4f}]".format(*numbers), lines[k])
    lines[k] = re.sub(r"(\],\[)([-\d.]+)(,9E9)", lambda m: f"{m[1]}{float(m[2]) + 30:.4f}{m[3]}", lines[k])
    (tmp_path / "d.mod").write_bytes("\r\n".join(lines).encode())
    verified = verify_file(tmp_path / "d.mod", again.cell, toolpath=[again.toolpath])
    assert verified.report["predicted_error_mm"]["program"]["max"] == pytest.approx(30.0, abs=0.01)
    with pytest.raises(CompensatorError, match="edited"):
        verified.refuse_unconfirmed()


def test_gaps_put_poses_in_while_the_rail_goes(tmp_path: Path) -> None:
    made = job(tmp_path)
    (tmp_path / "model.toml").write_text(tomli_w.dumps(WORN))
    done = compensate_file(made.toolpath, made.cell, made.out / "c.csv")
    assert done.report["inserted_poses"] > 0 and done.report["predicted_error_mm"]["after"]["max"] < 0.02
    rail = table(made.out / "c.csv")["E1_mm"]
    assert (np.diff(rail) > -1e-3).mean() > 0.98 and np.ptp(rail) > 1000.0


def test_what_is_told(written: Files) -> None:
    told = json.loads((written.out / "c.json").read_text())["external"]
    one = told["axes"]["E1"]
    assert one["range_mm"] == RAIL["range"] and one["moves"] and one["fastest_mm_per_s"] <= RAIL["speed"] * 1.001
    assert one["greatest_mm"] - one["least_mm"] <= one["travel_mm"]
    assert told["windows"] > 0 and told["windows_failed"] == 0
    assert told["chosen"]["cost_um2"]["axes"] > 0
    parts = {k: v for k, v in told["chosen"]["cost_um2"].items() if k != "sum"}
    assert sum(parts.values()) == pytest.approx(told["chosen"]["cost_um2"]["sum"])


def test_assumed_limits_are_told(tmp_path: Path) -> None:
    rows = [*LONG[:2], [60, 0, -2, 0, 0, 1, 1200, "cut"]]
    made = job(tmp_path, rows, {k: v for k, v in RAIL.items() if k not in ("speed", "acceleration")})
    done = preview_file(made.toolpath, made.cell, csv=tmp_path / "p.csv")
    told = "speed and acceleration of external.E1 are not given: 100 mm/s and 100 mm/s2 are assumed"
    assert any(told in str(f) for f in done.findings)
    assert np.ptp(table(tmp_path / "p.csv")["E1_mm"]) == 0.0  # a short path: one place serves


def test_limits_in_metres_are_asked_about(tmp_path: Path) -> None:
    rows = [*LONG[:2], [60, 0, -2, 0, 0, 1, 1200, "cut"]]
    made = job(tmp_path, rows, {**RAIL, "speed": 0.3, "acceleration": 0.2})
    done = preview_file(made.toolpath, made.cell)
    told = [str(f) for f in done.findings if "is this in m/s" in str(f)]
    assert len(told) == 2 and all(one.startswith("warning") for one in told)
    assert "speed of external.E1 is 0.3 mm/s: is this in m/s?" in told[0]


def test_turn_and_lean_are_chosen_beside(tmp_path: Path) -> None:
    made = job(tmp_path, LONG, solve={"turn": "path", "lean": 3.0})
    done = compensate_file(made.toolpath, made.cell, made.out / "c.mod")
    assert done.report["turn"]["chosen"]["cost_um2"]["sum"] > 0 and done.report["external"]["axes"]["E1"]["moves"]
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006


def test_the_axis_map_is_that_of_the_moved_base(tmp_path: Path) -> None:
    made = job(tmp_path)
    found = axis_map_file(made.toolpath, made.cell, poses=60)
    chosen = found.result
    assert found.report["external"]["axes"]["E1"]["moves"] and "E1 moves between" in str(found.report["findings"])
    assert chosen.position[-1] > 3.8 and chosen.path.toolpath.ways is not None
    near = np.round(chosen.chosen / chosen.grid.step).astype(int) % len(chosen.grid.turns)
    assert chosen.grid.free[np.arange(len(near)), near].all()


def test_a_rail_that_stays_is_a_part_that_stands_elsewhere(tmp_path: Path) -> None:
    """The same commands as of a cell without a rail whose work object is nearer by what the rail stands at; weight,
    touching off and scene included."""
    rows = [*LONG[:2], [60, 0, -2, 0, 0, 1, 1200, "cut"], [60, 40, -5, 0, 0, 1, 1200, "cut"]]
    touched = {"touched_off": [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [0.0, 30.0, 0.0]]}
    tables = {"gravity": "uncompensated", "workobject": touched, "start": {"joints": [0.0, 10.0, 20.0, 0.0, 60.0, 0.0]}}
    (tmp_path / "rail").mkdir()
    rail = files(tmp_path / "rail", {"external": {"E1": {**RAIL, "range": [700.0, 1100.0]}}, **tables}, rows=rows)
    done = compensate_file(rail.toolpath, rail.cell, rail.out / "c.csv")
    place = done.report["external"]["constant"]["places"]["E1"]
    assert 700.0 <= place <= 1100.0
    nearer = {**touched, "xyz": [1500.0, -150.0 - place, 800.0]}
    (tmp_path / "plain").mkdir()
    plain = files(tmp_path / "plain", {**tables, "workobject": nearer}, rows=rows)
    turn = done.result.path
    job_ = load_job(plain.cell)
    path = sampled(job_.placement, read_toolpath(plain.toolpath))
    began = PlannedPath(path, job_.planner.reference(path), turn.q, turn.turn, turn.branch)
    other = compensate(job_, job_.planner.turned(began, turn.turn))
    np.testing.assert_allclose(done.result.command.q, other.command.q, atol=1e-8)
    np.testing.assert_allclose(done.result.before, other.before, atol=1e-8)


def test_many_touches_are_of_one_base(tmp_path: Path) -> None:
    points = [[0.0, 0.0, 0.0], [0.0, 3000.0, 0.0], [40.0, 0.0, 0.0]]
    made = job(tmp_path, workobject={"touched_off": points})
    with pytest.raises(CompensatorError, match=r"touched_off has 3 touches, and the rail moves.*give 2 at most"):
        compensate_file(made.toolpath, made.cell, made.out / "c.mod")


def test_a_contact_is_kept_away_from(tmp_path: Path) -> None:
    """A post stands in the hall where the arm would best have its elbow: the base goes elsewhere."""
    rows = [*LONG[:2], [60, 0, -2, 0, 0, 1, 1200, "cut"]]
    alone = job(tmp_path / "alone", rows)
    best = compensate_file(alone.toolpath, alone.cell, alone.out / "c.mod").report["external"]["axes"]["E1"]["least_mm"]
    post = {"name": "post", "box": [[500.0, best - 120.0, 0.0], [700.0, best + 120.0, 2500.0]], "frame": "base"}
    held = job(tmp_path / "held", rows, scene=[post])
    done = compensate_file(held.toolpath, held.cell, held.out / "c.mod")
    assert done.report["collisions"]["contacts"] == []
    assert abs(done.report["external"]["axes"]["E1"]["least_mm"] - best) > 50.0


def test_the_base_is_kept_away_from_what_stands_on_the_floor(tmp_path: Path) -> None:
    """A block that the arm goes over, where the base would best stand."""
    rows = [*LONG[:2], [60, 0, -2, 0, 0, 1, 1200, "cut"]]
    alone = job(tmp_path / "alone", rows)
    best = compensate_file(alone.toolpath, alone.cell, alone.out / "c.mod").report["external"]["axes"]["E1"]["least_mm"]
    block = {"name": "block", "box": [[-150.0, best - 80.0, 0.0], [150.0, best + 80.0, 200.0]]}
    held = job(tmp_path / "held", rows, scene=[block])
    done = compensate_file(held.toolpath, held.cell, held.out / "c.mod")
    assert done.report["collisions"]["contacts"] == []
    assert abs(done.report["external"]["axes"]["E1"]["least_mm"] - best) > 80.0


def test_a_milled_path(tmp_path: Path) -> None:
    """The engagement is that of the part: the same while the base goes 800 mm."""
    rows = [[-25, 20, 40, 0, 0, 1, 0, "rapid"], [-25, 20, -3, 0, 0, 1, 600, "cut"], [100, 20, -3, 0, 0, 1, 600, "cut"]]
    made = job(tmp_path, rows, process=milling(tmp_path))
    one = load_job(made.cell)
    path = sampled(one.placement, read_toolpath(made.toolpath))
    free = FreeAxes.of(one.placement, path)
    assert free is not None
    found = []
    for places in (np.zeros((len(path), 1)), np.linspace(100.0, 900.0, len(path))[:, None]):
        moved = free.on(path, places)
        tcp, none = one.planner.reference(moved), np.zeros(len(path))
        begun = PlannedPath(moved, tcp, np.zeros((len(path), 6)), none, none.astype(np.int64))
        found.append((load_along(one, begun), np.diff(tcp.origin, axis=0)))
    (still, on_floor), (going, on_rail) = found
    assert np.abs(still.wrench).max() > 10.0 and np.abs(on_floor - on_rail).max() > 0.01
    np.testing.assert_allclose(going.wrench, still.wrench, atol=1e-6)
    for name, values in still.columns.items():
        np.testing.assert_allclose(going.columns[name], values, atol=1e-6)


def test_windows_that_fail_stay_as_they_began(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No program of the refinement succeeds: the way over the lattice is taken, and a warning counts the windows."""
    monkeypatch.setattr(axis_refinement, "program", lambda *_, **__: None)
    made = job(tmp_path)
    done = compensate_file(made.toolpath, made.cell, made.out / "c.csv")
    told = done.report["external"]
    assert told["axes"]["E1"]["moves"] and told["windows_failed"] == told["windows"] > 0
    (said,) = (str(f) for f in done.findings if "windows of the rail's refinement failed" in str(f))
    assert "1 of 1" in said
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006


def test_whole_orientations_and_one_turn(tmp_path: Path) -> None:
    """A path that leaves no turn open, and a turn that has to stay: the rail goes along both."""
    rows = [[*r[:3], 0.0, 1.0, 0.0, 0.0, *r[6:]] for r in LONG]
    header = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "feed_mm_min", "kind")
    tables = {"external": {"E1": RAIL}, "sampling": {"spacing": 40.0}}
    whole = files(tmp_path, tables, rows=rows, header=header)
    done = compensate_file(whole.toolpath, whole.cell, whole.out / "c.csv")
    assert done.report["external"]["axes"]["E1"]["moves"] and not done.result.path.turn.any()
    one = job(tmp_path / "one", solve={"turn": "constant"})
    path = compensate_file(one.toolpath, one.cell, one.out / "c.csv").result.path
    assert np.ptp(path.turn) == 0.0 and path.axes is not None and path.axes.uses[0].moves


def test_two_tools(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The rail goes on from tool to tool; each has its own reach."""
    code = ["G21 G90 G17", "T1 M6", "S5000 M3", "G0 X0 Y0 Z50", "G1 Z-2 F1200", "G1 Y1500", "G0 Z50", "T2 M6",
            "G0 X20 Y1500", "G1 Z-2 F1200", "G1 Y3000", "G0 Z50", "M30"]  # fmt: skip
    (tmp_path / "part.nc").write_text("\n".join(code) + "\n")
    tool = {"xyz": [30.0, -20.0, 240.0], "rpy": [0.0, 25.0, 0.0], "mass": 30.0, "com": [10.0, 0.0, 110.0]}
    made = job(tmp_path, tool=None, tools={"1": tool, "2": {**tool, "xyz": [30.0, -20.0, 330.0]}})
    done = compensate_file(tmp_path / "part.nc", made.cell, made.out / "c.mod")
    assert capfd.readouterr() == ("", "")  # PIQP tells of every row without bounds
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.006
    text = (made.out / "c.mod").read_text()
    stands = [float(v) for v in re.findall(r"\],\[([-\d.]+),9E9,9E9", text)]
    assert len(stands) > 60 and np.abs(np.diff(stands)).max() < 150.0
    jumps = re.findall(r"MoveAbsJ \[\[[^]]*\],\[([-\d.]+),9E9", text)
    assert len(jumps) == 2  # to the start, and to the first pose of the second tool


def test_an_arm_without_a_closed_form(tmp_path: Path) -> None:
    tables = {"external": {"E1": RAIL}, "robot": "ur10", "tip": None}
    made = files(tmp_path, tables, {"robot": "ur10"}, rows=LONG)
    with pytest.raises(CompensatorError, match=r"external\.E1\.free: places are looked at in closed form"):
        compensate_file(made.toolpath, made.cell, made.out / "c.mod")


def test_two_names_of_one_axis_tell_the_same(tmp_path: Path) -> None:
    same = {k: RAIL[k] for k in ("carries", "direction")}
    both = job(tmp_path, external={"E1": same, "eax_a": same})
    assert set(load_job(both.cell).placement.external) == {"E1", "eax_a"}
    other = job(tmp_path, external={"E1": same, "eax_a": {**same, "direction": [1.0, 0.0, 0.0]}})
    with pytest.raises(CompensatorError, match="E1 and eax_a are two names of one axis: they have to tell the same"):
        load_job(other.cell)


def test_a_robot_program_keeps_its_own(written: Files) -> None:
    with pytest.raises(CompensatorError, match=r"external\.E1\.free = true: .*c\.mod is a robot program"):
        preview_file(written.out / "c.mod", written.cell)


def test_nothing_serves(tmp_path: Path) -> None:
    """Out of reach wherever the rail stands; too slow a rail; each says what to do."""
    far = job(tmp_path / "far", [[3500 if k == 0 else v for k, v in enumerate(row)] for row in LONG])
    with pytest.raises(CompensatorError, match=r"path\.csv:\d+.*out of reach.*E1 = -1500 \.\.\. 2500.*widen range"):
        compensate_file(far.toolpath, far.cell, far.out / "c.mod")
    longer = [[5200 if v == 3800 else v for v in row] for row in LONG]
    slow = job(tmp_path / "slow", longer, {**RAIL, "speed": 1.0, "acceleration": 1.0, "range": [-1500.0, 4000.0]})
    doubt = r"speed of external\.E1 is 1 mm/s: is this in m/s\?"
    with pytest.raises(CompensatorError, match=rf"no smooth way of E1 within speed and acc.*{doubt}.*lower the feed"):
        compensate_file(slow.toolpath, slow.cell, slow.out / "c.mod")


def test_placements_are_of_one_base(tmp_path: Path) -> None:
    made = job(tmp_path)
    with pytest.raises(CompensatorError, match=r"external\.E1\.free = true: place ranks placements of one base"):
        place_file([made.toolpath], made.cell, tmp_path / "study.parquet", within="x=1400:1500:2")
