"""[machine] of the cell: where a G-code file with rotary words puts the tool, and what the table must not say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.cell.cell_file import load_cell
from compensator.errors import CellError
from compensator.tasks import compensate as tasks
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import columns, files
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import read_toolpath

TABLES: dict[str, Any] = {
    "kinematics": "table-table",
    "axis": [
        {"letter": "A", "direction": [1.0, 0.0, 0.0], "centre": [0.0, 0.0, -40.0]},
        {"letter": "C", "direction": [0.0, 0.0, -1.0], "centre": [25.0, 0.0, 0.0]},
    ],
}
ROTARY = "G21 G90\nG0 X35 Y0 Z10 A0 C0\nG1 A90 F500\nC90\nM30\n"
# (35, 0, 50) from A's centre turns to (35, -50, 0); then (10, -50) from C's centre turns to (-50, -10)
TIPS = [[35.0, 0.0, 10.0], [35.0, -50.0, -40.0], [-25.0, -10.0, -40.0]]
AXES = [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]


def rotary(tmp_path: Path, text: str = ROTARY) -> Path:
    file = tmp_path / "part.nc"
    file.write_text(text)
    return file


def test_table_table_by_hand(tmp_path: Path) -> None:
    """Ends of the moves as worked out by hand; poses between them lie on the circles of the axes."""
    cell = load_cell(files(tmp_path, {"machine": TABLES}).cell)
    path = read_toolpath(rotary(tmp_path), machine=cell.posted_for())
    ends = np.flatnonzero(path.row == np.round(path.row))
    np.testing.assert_allclose(path.position[ends], np.array(TIPS) / 1e3, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.axis[ends], AXES, rtol=0, atol=1e-15)
    first = path.position[: ends[1] + 1] - [0.035, 0.0, -0.04]
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), 0.05, rtol=1e-12)
    assert len(first) > 45 and np.ptp(first[:, 0]) < 1e-15


def test_the_command_takes_the_machine_of_the_cell(tmp_path: Path) -> None:
    """The poses of preview are those in the work object, not X, Y, Z of the machine."""
    job = files(tmp_path, {"machine": TABLES})
    text = "G21 G90\nG0 X35 Y0 Z10 A0 C0\nG1 A10 F500\nM30\n"
    preview_file(rotary(tmp_path, text), job.cell, csv=job.out / "a.csv")
    last = columns(job.out / "a.csv", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm")[-1]
    c, s = np.cos(np.radians(10.0)), np.sin(np.radians(10.0))
    np.testing.assert_allclose(last, [35.0, -50.0 * s, 50.0 * c - 40.0], rtol=0, atol=2e-6)


def test_without_a_machine_refused_by_line(tmp_path: Path) -> None:
    """The first rotary word, through the command; nothing is written."""
    job = files(tmp_path)
    with pytest.raises(ReadError, match=r"part\.nc.*A0.*rotary") as caught:
        preview_file(rotary(tmp_path), job.cell, csv=job.out / "a.csv")
    assert caught.value.line == 2 and job.left() == []


def test_systems_and_pivot_in_mm(tmp_path: Path) -> None:
    """G55 lies 100 mm beside G54; the head's tip swings about a point 230 mm above it."""
    head = {
        "kinematics": "head", "pivot": 230.0, "axis": [{"letter": "B", "direction": [0.0, 2.0, 0.0]}],
        "systems": {"G54": [0.0, 0.0, 0.0], "G55": [100.0, -7.0, 3.0]},
    }  # fmt: skip
    machine = load_cell(files(tmp_path, {"machine": head}).cell).posted_for()
    text = "G21 G90 G54\nG0 X1 Y2 Z3 B0\nG55 X1 Y2 Z3\nG1 B90 F100\nM30\n"
    path = read_toolpath(rotary(tmp_path, text), machine=machine)
    ends = path.position[path.row == np.round(path.row)] * 1e3
    np.testing.assert_allclose(ends, [[1, 2, 3], [101, -5, 6], [101 - 230, -5, 236]], rtol=0, atol=1e-10)


def test_radii_in_mm(tmp_path: Path) -> None:
    """A side cut by a cutter of 5 mm radius in D1: its centre runs beside the contour."""
    machine = load_cell(files(tmp_path, {"machine": {"radii": {"1": 5, "2": 0.0}}}).cell).posted_for()
    text = "G21 G90\nG0 X0 Y-20 Z3\nG41 D1 G1 Y0 F100\nX-40\nG40 G0 Y30\nG41 D2 G1 X0\nM30\n"
    path = read_toolpath(rotary(tmp_path, text), machine=machine)
    expected = [[-5, -5], [-40, -5], [-40, 30], [0, 30]]
    np.testing.assert_allclose(path.position[1:5, :2] * 1e3, expected, atol=1e-10)


def test_systems_are_filtered_in_place(tmp_path: Path) -> None:
    """The numbers of the file are those of its own systems; read with the same machine it is what was commanded."""
    systems = {"G54": [0.0, 0.0, 0.0], "G55": [60.0, 10.0, -3.0]}
    job = files(tmp_path, {"machine": {"systems": systems}})
    text = "G21 G90 G54\nG0 X0 Y0 Z50\nG1 Z-2 F500\nX30\nG0 Z50\nG55 X0 Y0\nG1 Z1\nG91 X5\nG90 X20 Y4\nG0 Z50\nM30\n"
    one = "G21 G90\nG0 X0 Y0 Z50\nG1 Z-2 F500\nX30\nG0 Z50\nX60 Y10\nG1 Z-2\nX65\nX80 Y14\nG0 Z47\nM30\n"
    done = compensate_file(rotary(tmp_path, text), job.cell, job.out / "part.nc")
    assert done.report["predicted_error_mm"]["after"]["max"] < 5e-3 < 0.05 < done.report["max_correction_mm"]
    machine = load_cell(job.cell).posted_for()
    got = read_toolpath(job.out / "part.nc", machine=machine)
    plain = files(tmp_path)
    compensate_file(rotary(tmp_path, one), plain.cell, plain.out / "one.nc")
    np.testing.assert_allclose(got.position, read_toolpath(plain.out / "one.nc").position, rtol=0, atol=1.5e-6)
    kept = [line for line in (job.out / "part.nc").read_text().split("\n") if "G0" in line or "G5" in line]
    assert kept == ["G21 G90 G54", "G0 X0 Y0 Z50", "G0 Z50", "G55 X0 Y0", "G0 Z50"]


def test_rotary_words_are_refused_before_the_solve(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Filtered in place they would need other angles; into another language they go."""
    job = files(tmp_path, {"machine": TABLES})
    with pytest.raises(WriteError, match=r"part\.nc:2: rotary words .* in the robot's language"):
        monkeypatch.setattr(tasks, "compensate", None)
        compensate_file(rotary(tmp_path), job.cell, job.out / "part.nc")
    assert job.left() == []


def test_other_languages_do_not_need_it(tmp_path: Path) -> None:
    """A cell with a machine reads a csv as one without."""
    job = files(tmp_path, {"machine": TABLES})
    a, b = read_toolpath(job.toolpath, machine=load_cell(job.cell).posted_for()), read_toolpath(job.toolpath)
    np.testing.assert_array_equal(a.position, b.position)
    assert load_cell(files(tmp_path).cell).posted_for() is None


A, C = TABLES["axis"]
WRONG: list[tuple[str, dict[str, Any], str]] = [
    ("unknown key", {"tilt": 3}, r"unknown key machine\.tilt = 3"),
    ("unknown key of an axis", {"axis": [{**A, "centre_mm": 1.0}, C]}, r"unknown key machine\.axis\.1\.centre_mm"),
    ("nothing", {"kinematics": None, "axis": None}, r"machine: nothing is declared"),
    ("kinematics", {"kinematics": "table-head"}, r"machine\.kinematics = 'table-head'.*head-table"),
    ("one axis", {"axis": [A]}, r"machine: kinematics 'table-table' needs 2 axes, 1 are given"),
    ("twice", {"axis": [A, A]}, r"machine: axes A, A: different ones"),
    ("letter", {"axis": [A, {**C, "letter": "U"}]}, r"machine\.axis\.2\.letter = 'U'"),
    ("no direction", {"axis": [A, {"letter": "C"}]}, r"machine\.axis\.2\.direction is missing"),
    ("direction 0", {"axis": [A, {**C, "direction": [0.0, 0.0, 0.0]}]}, r"direction of machine\.axis C is 0 0 0"),
    ("text", {"axis": [A, {**C, "centre": ["25 mm", 0.0, 0.0]}]},
     r"machine\.axis\.2\.centre = .*item 1 is '25 mm': text; write the number alone"),
    ("pivot of a table", {"pivot": 200.0}, r"machine: pivot = 200: .* has no head"),
    ("pivot in metres", {"kinematics": "head-table", "pivot": 0.2}, r"machine\.pivot is 0\.2 mm long"),
    ("system", {"systems": {"G53": [0.0, 0.0, 0.0]}}, r"machine\.systems\.G53"),
    ("radius", {"radii": {"1": -2.0}}, r"machine\.radii\.1 = -2"),
    ("register", {"radii": {"D1": 2.0}}, r"machine\.radii\.D1"),
    ("system of two", {"systems": {"G55": [0.0, 0.0]}},
     r"machine\.systems\.G55 = \[0\.0, 0\.0\]: there are 2, expected 3"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), [w[1:] for w in WRONG], ids=[w[0] for w in WRONG])
def test_wrong_keys_are_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    """The file and the key are named."""
    table = {k: v for k, v in {**TABLES, **change}.items() if v is not None}
    with pytest.raises(CellError) as caught:
        load_cell(files(tmp_path, {"machine": table}).cell)
    assert re.search(message, str(caught.value)), str(caught.value)
    assert "cell.toml" in str(caught.value)
