"""A table that turns along a path, from file to file: words of each language, what is read back, refused, and told."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from scipy.spatial.transform import Rotation

from compensator.axes.free_axes import FreeAxes
from compensator.cell.job import load_job
from compensator.errors import CompensatorError
from compensator.path.added_poses import with_poses_between
from compensator.path.planned_path import PlannedPath
from compensator.program.export import program_of
from compensator.report.json.verification import CONFIRMED
from compensator.solve.load_along import load_along
from compensator.solve.planned import sampled
from compensator.solve.verify import simulated
from compensator.tasks.compensate import Done, compensate_file, preview_file
from compensator.tasks.verify import verify_file
from tests.compensator.axes.rail_plant import pose
from tests.compensator.axes.table_plant import Coordinated
from tests.compensator.axes.test_tables_on_the_plant import FEED, TABLE, WORK, ring
from tests.compensator.small_job import WORN, Files, files, milling
from toolpaths.errors import ToolpathError
from toolpaths.files import read_toolpath, write_program
from toolpaths.frame import Frame
from toolpaths.toolpath import Toolpath

SHORT = ring(100.0, 190.0, step=10.0)
START = {"joints": [-10.0, 0.0, 60.0, 115.0, 50.0, 60.0]}  # one arm configuration: an eighth of the work
PLAIN = {k: TABLE[k] for k in ("carries", "direction", "center", "unit", "unit_xyz", "unit_rpy")}


def job(folder: Path, rows: list[list[Any]] | None = None, table: dict[str, Any] | None = None, **cell: Any) -> Files:
    """A quarter of a ring on a table, E2."""
    folder.mkdir(exist_ok=True)
    tables = {"external": {"E2": TABLE if table is None else table}, "workobject": WORK,
              "sampling": {"spacing": 40.0, "chord": 0.2}, "start": START, **cell}  # fmt: skip
    return files(folder, tables, rows=SHORT if rows is None else rows)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Files, Done]:
    """The same path in every language that has words for it."""
    made = job(tmp_path_factory.mktemp("written"))
    done = compensate_file(made.toolpath, made.cell, made.out / "c.mod", json=made.out / "c.json")
    assert done.report["external"]["axes"]["E2"]["moves"]
    write_program(program_of(done.result, name="c"), made.out / "c.csv")
    numbered = job(made.folder / "krl", table={**TABLE, "unit": 2})
    again = compensate_file(numbered.toolpath, numbered.cell, made.out / "c.src")
    np.testing.assert_array_equal(again.result.command.q, done.result.command.q)
    return made, done


def table_of(file: Path) -> np.ndarray:
    """Rows of a csv."""
    return np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding="ascii")


@pytest.mark.parametrize("name", ["c.mod", "c.src"])
def test_every_language_tells_the_same_poses(written: tuple[Files, Done], name: str) -> None:
    """On the part, with the table beside them, and the work object where the cell has it on its unit."""
    out = written[0].out
    program = Coordinated.read(out / name) if name == "c.mod" else Coordinated.read_krl(out / name)
    assert program.unit == ("STN1" if name == "c.mod" else "2")
    rows = table_of(out / "c.csv")
    at = np.stack([rows[c] for c in ("x_mm", "y_mm", "z_mm")], axis=1)
    np.testing.assert_allclose(program.target[:, :3, 3] * 1e3, at, atol=6e-5)
    turn = Rotation.from_quat(np.stack([rows[c] for c in ("qw", "qx", "qy", "qz")], axis=1), scalar_first=True)
    assert (turn.inv() * Rotation.from_matrix(program.target[:, :3, :3])).magnitude().max() < 4e-7
    np.testing.assert_allclose(program.angle, rows["E2_deg"], atol=1e-6)
    unit = pose(TABLE["unit_xyz"], Rotation.from_euler("xyz", TABLE["unit_rpy"], degrees=True))
    work = pose(WORK["xyz"], Rotation.from_euler("xyz", WORK["rpy"], degrees=True))
    np.testing.assert_allclose(unit @ program.on_unit, work, atol=2e-7)
    nominal = np.stack([rows[f"nominal_{c}_mm"] for c in "xyz"], axis=1)
    np.testing.assert_allclose(nominal[rows["kind"] == "cut"][-1], SHORT[-2][:3], atol=1e-5)


def test_what_the_controller_has_to_have_stands_in_the_head(written: tuple[Files, Done]) -> None:
    text = [(written[0].out / name).read_text() for name in ("c.mod", "c.src")]
    assert "! eax_b turns the part while it cuts: mechanical unit STN1, coordinated." in text[0]
    assert "! [[1650,60,500],[0.96592583,0,0,0.25881905]]" in text[0]
    assert "; E2 turns the part while it cuts: MACHINE_DEF[2], mathematically coupled." in text[1]
    assert "; {FRAME: X 1650,Y 60,Z 500,A 30,B 0,C 0}" in text[1]


@pytest.mark.parametrize(("name", "unit"), [("c.mod", "STN1"), ("c.src", 2)])
@pytest.mark.parametrize("placed", [True, False])
def test_a_preview_of_the_program_sees_the_same_arm(
    written: tuple[Files, Done], tmp_path: Path, name: str, unit: str | int, placed: bool
) -> None:
    """The readers find work object, poses and table; the joint angles are those that were solved."""
    plain = job(tmp_path, table={**PLAIN, "unit": unit})
    if not placed:
        plain.cell.write_text(re.sub(r"\[workobject\]\n(?:(?:xyz|rpy) = \[[^\]]*\]\n)+", "", plain.cell.read_text()))
    preview_file(written[0].out / name, plain.cell, csv=tmp_path / "p.csv")
    rows = [table_of(f) for f in (written[0].out / "c.csv", tmp_path / "p.csv")]
    at = [np.stack([r[c] for c in ("x_mm", "y_mm", "z_mm")], axis=1) for r in rows]
    solved = np.flatnonzero(rows[0]["kind"] == "cut")[3:-3:5]
    seen = [int(np.argmin(np.linalg.norm(at[1] - at[0][k], axis=1))) for k in solved]
    assert len(seen) > 10 and np.abs(at[1][seen] - at[0][solved]).max() < 1e-3
    for k in range(1, 7):
        np.testing.assert_allclose(rows[1][f"q{k}_deg"][seen], rows[0][f"q{k}_deg"][solved], atol=2e-4)


def test_a_program_of_another_place_on_the_unit_is_refused(written: tuple[Files, Done], tmp_path: Path) -> None:
    plain = job(tmp_path, table={**PLAIN, "unit_xyz": [1650.0, 61.0, 500.0]})
    with pytest.raises(CompensatorError, match=r"\[workobject\] is not the work object of .*c\.mod: .*41\.000"):
        preview_file(written[0].out / "c.mod", plain.cell)


def test_verified(written: tuple[Files, Done]) -> None:
    """What stands there is what the same inputs give."""
    made = written[0]
    verified = verify_file(made.out / "c.mod", made.cell, toolpath=[made.toolpath])
    verified.refuse_unconfirmed()
    assert verified.report["verdict"] == CONFIRMED and verified.report["predicted_error_mm"]["program"]["max"] < 0.001


def test_a_table_that_was_moved_is_found(written: tuple[Files, Done], tmp_path: Path) -> None:
    """A degree further at one pose: the controller keeps the tool on the part, the arm goes where it was not sent, and
    yields by something else there."""
    text = (written[0].out / "c.mod").read_bytes().decode()
    moves = [m.start() for m in re.finditer("MoveL", text)]
    k = moves[len(moves) // 2]
    turned = re.sub(r"9E9,([-\d.]+),9E9", lambda m: f"9E9,{float(m[1]) + 1.0:.4f},9E9", text[k:], count=1)
    (tmp_path / "d.mod").write_bytes((text[:k] + turned).encode())
    plain, other = (simulated(written[1].result, f, "rapid") for f in (written[0].out / "c.mod", tmp_path / "d.mod"))
    assert not plain.others.any() and other.others.sum() == 1
    assert other.off.max() == pytest.approx(np.radians(1.0))  # of the table
    assert plain.error.max() < 1e-6 < other.error.max() < 1e-4


REFUSED = [
    ("c.ls", {}, r"fanuc has no words here for a table that turns while it cuts \(E2\)\. write RAPID, KRL or csv, or"),
    ("c.nc", {}, r"gcode has no place for external axes, and E2 would be lost"),
    ("c.mod", {"unit": None}, r"external\.E2: unit is missing: a program in rapid tells by its name.*unit = \"STN1\""),
    ("c.mod", {"unit": 2}, r"unit = 2: a program in rapid tells the name of the mechanical unit"),
    ("c.src", {}, r"unit = 'STN1': a program in krl tells the number of the mechanical unit"),
]


@pytest.mark.parametrize(("name", "change", "message"), REFUSED)
def test_what_cannot_be_written_is_refused_before_solving(
    tmp_path: Path, name: str, change: dict[str, Any], message: str
) -> None:
    table = {**TABLE, **change}
    if table["unit"] is None:
        table = {k: v for k, v in table.items() if not k.startswith("unit")}
    made = job(tmp_path, table=table)
    with pytest.raises((CompensatorError, ToolpathError), match=message):
        compensate_file(made.toolpath, made.cell, made.out / name)
    assert made.left() == []


def test_no_writer_takes_it_that_has_no_words(written: tuple[Files, Done], tmp_path: Path) -> None:
    """Whoever asks: a program that is made all the same is refused where it is written."""
    with pytest.raises(ToolpathError, match=r"fanuc has no words here for a table that turns"):
        write_program(program_of(written[1].result, name="c"), tmp_path / "c.ls")
    assert not list(tmp_path.iterdir())


def test_touches_of_a_part_that_turns(tmp_path: Path) -> None:
    made = job(tmp_path, workobject={**WORK, "touched_off": [[0.0, 0.0, 0.0]]})
    with pytest.raises(CompensatorError, match=r"touched_off: the table E2 may turn along the path.*it is set once"):
        compensate_file(made.toolpath, made.cell, made.out / "c.mod")


@pytest.mark.parametrize(("rpy", "xyz"), [([180.0, 0.0, 0.0], [0.0, 0.0, 0.0]), ([0.0, 0.0, 9.0], [0.0, 3.0, 0.0])])
def test_a_unit_whose_z_is_elsewhere_is_asked_about(
    written: tuple[Files, Done], tmp_path: Path, rpy: list[float], xyz: list[float]
) -> None:
    program = program_of(written[1].result, name="c")
    assert program.carrier is not None and program.carrier.about_z
    turn = Rotation.from_euler("xyz", rpy, degrees=True).as_matrix()
    frame = Frame(turn, program.carrier.stands.origin + np.array(xyz) / 1e3)
    told = write_program(replace(program, carrier=replace(program.carrier, frame=frame)), tmp_path / "c.mod").findings
    assert any("z of unit_rpy, or unit_xyz, is not on the axis" in str(f) for f in told)


def path_on_table(made: Files, turn: float) -> tuple[Any, Toolpath, FreeAxes, np.ndarray]:
    """A job, its path with the table turning evenly by ``turn`` deg, what is free, and the places (N, 1)."""
    one = load_job(made.cell)
    path = sampled(one.placement, read_toolpath(made.toolpath))
    free = FreeAxes.of(one.placement, path)
    assert free is not None
    places = np.linspace(0.0, turn, len(path))[:, None]
    return one, path, free, np.round(places, 4)


@pytest.mark.parametrize("whole", [False, True])
def test_poses_put_in_are_straight_on_the_part(tmp_path: Path, whole: bool) -> None:
    """And their tool axes between those of their neighbours, there: by plain rotations."""
    rows, header = SHORT, ("x_mm", "y_mm", "z_mm", "i", "j", "k", "feed_mm_min", "kind")
    if whole:
        turns = [Rotation.align_vectors([[-v for v in r[3:6]], [0, 0, 1]], [[0, 0, 1], [1, 0, 0]])[0] for r in SHORT]
        rows = [[*r[:3], *t.as_quat(scalar_first=True).tolist(), *r[6:]] for r, t in zip(SHORT, turns, strict=True)]
        header = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz", "feed_mm_min", "kind")
    tables = {"external": {"E2": TABLE}, "workobject": WORK, "sampling": {"spacing": 40.0, "chord": 10.0}}
    made = files(tmp_path, tables, rows=rows, header=header)
    _, path, free, places = path_on_table(made, -70.0)
    moved = free.on(path, places)
    segment = np.array([3, 3, 6])
    finer = with_poses_between(moved, segment, np.array([0.25, 0.5, 0.9]))
    put_in = np.array([4, 5, 9])
    angle = np.interp(finer.row[put_in], path.row, places[:, 0])
    work = pose(WORK["xyz"], Rotation.from_euler("xyz", WORK["rpy"], degrees=True))
    for k, (at, s, t, a) in enumerate(zip(put_in, segment, (0.25, 0.5, 0.9), angle, strict=True)):
        turn = Rotation.from_euler("z", a, degrees=True)
        center = np.array(TABLE["center"]) / 1e3
        part = np.linalg.inv(work) @ pose((center - turn.apply(center)) * 1e3, turn) @ work
        expected = (1 - t) * path.position[s] + t * path.position[s + 1]
        np.testing.assert_allclose(finer.position[at], part[:3, :3] @ expected + part[:3, 3], atol=1e-9)
        np.testing.assert_allclose(finer.on_part[at], expected, atol=1e-9)
        between = (1 - t) * path.axis[s] + t * path.axis[s + 1]
        between = part[:3, :3] @ (between / np.linalg.norm(between))
        assert np.degrees(np.arccos(np.clip(between @ finer.axis[at], -1, 1))) < 0.1, k


def test_a_milled_path(tmp_path: Path) -> None:
    """The engagement is that of the part, and the force turns with it."""
    rows = [[-25, 20, 40, 0, 0, 1, 0, "rapid"], [-25, 20, -3, 0, 0, 1, 600, "cut"], [100, 20, -3, 0, 0, 1, 600, "cut"]]
    made = job(tmp_path, rows, process=milling(tmp_path))
    one, path, free, places = path_on_table(made, 80.0)
    found = []
    for at in (np.zeros_like(places), places):
        found.append(load_along(one, planned_on(one, free.on(path, at))))
    still, turning = found
    assert np.abs(still.wrench).max() > 10.0
    turn = Rotation.from_euler("z", places, degrees=True)
    expected = np.concatenate([turn.apply(still.wrench[:, :3]), turn.apply(still.wrench[:, 3:])], axis=1)
    np.testing.assert_allclose(turning.wrench, expected, atol=1e-6)
    assert np.abs(turning.wrench - still.wrench).max() > 5.0
    for name, values in still.columns.items():
        np.testing.assert_allclose(turning.columns[name], values, atol=1e-6)


def planned_on(one: Any, moved: Toolpath) -> PlannedPath:
    """A path with its axes, its turn 0, no joint angles yet."""
    none = np.zeros(len(moved))
    return PlannedPath(moved, one.planner.reference(moved), np.zeros((len(moved), 6)), none, none.astype(np.int64))


def test_gaps_turn_and_lean_beside(tmp_path: Path) -> None:
    """Poses put in where flanks change, turn and lean chosen along the path: all on the part that turns."""
    made = job(tmp_path, solve={"turn": "path", "lean": 3.0})
    (tmp_path / "model.toml").write_text(tomli_w.dumps(WORN))
    done = compensate_file(made.toolpath, made.cell, made.out / "c.mod")
    assert done.report["external"]["axes"]["E2"]["moves"] and done.report["inserted_poses"] > 0
    assert done.report["predicted_error_mm"]["after"]["max"] < 0.02
    program = Coordinated.read(made.out / "c.mod")
    step = np.linalg.norm(np.diff(program.target[:, :3, 3], axis=0), axis=1)
    assert np.abs(np.diff(program.angle)).max() < 1.05 * (TABLE["speed"] * step / (FEED / 60e3)).max() + 1e-3
