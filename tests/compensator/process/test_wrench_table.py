"""Wrench tables: what is refused, and which pose gets which wrench."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.errors import CompensatorError
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import ROWS, Files, columns, files, write_csv

HEADER = ("index", "fx", "fy", "fz", "mx", "my", "mz")
CELL = {"process": {"kind": "table", "frame": "base", "file": "wrenches.csv"}}
FORCE = ("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm", "mz_nm")
GOOD = [[k, 100.0 + k, -10.0 * k, 5.0, 0.5, 0.25 * k, -1.0] for k in (2, 3, 4)]


def table_job(
    folder: Path, rows: Sequence[Sequence[Any]], header: Sequence[str] = HEADER, cell: dict[str, Any] = CELL
) -> Files:
    """The small job with a table; rows 2, 3, 4 of its path cut."""
    write_csv(folder / "wrenches.csv", header, rows)
    return files(folder, cell)


def refusal(job: Files) -> str:
    """The message; there must be no output."""
    with pytest.raises(CompensatorError) as caught:
        compensate_file(job.toolpath, job.cell, job.out / "out.csv")
    assert job.left() == []
    return str(caught.value)


BAD: list[tuple[str, Sequence[str], list[list[Any]], str]] = [
    ("missing row", HEADER, [GOOD[0], GOOD[2]], r"no row with index 3: pose 3 of .*path\.csv cuts"),
    ("last row missing", HEADER, GOOD[:2], r"no row with index 4: pose 4 of .*path\.csv cuts"),
    ("first cut missing", HEADER, GOOD[1:], r"no row with index 2: pose 2 of .*path\.csv cuts"),
    ("index twice", HEADER, [*GOOD, [3, 0, 0, 0, 0, 0, 0]], r"index 3 stands there twice"),
    ("not finite", HEADER, [GOOD[0], [3, "nan", 0, 0, 0, 0, 0], GOOD[2]], r"wrenches\.csv:3: .*finite"),
    ("infinite", HEADER, [GOOD[0], [3, 0, 0, 0, 0, 0, "-inf"], GOOD[2]], r"wrenches\.csv:3: .*finite"),
    ("words", HEADER, [GOOD[0], [3, "ten", 0, 0, 0, 0, 0], GOOD[2]], r"wrenches\.csv:3: .*ten"),
    ("short row", HEADER, [GOOD[0], [3, 0, 0, 0, 0, 0], GOOD[2]], r"wrenches\.csv:3: .*7 finite numbers"),
    ("half an index", HEADER, [GOOD[0], [3.5, 0, 0, 0, 0, 0, 0], GOOD[2]], r"index must be a whole number"),
    ("negative index", HEADER, [[-1, 0, 0, 0, 0, 0, 0], *GOOD], r"index must be a whole number"),
    ("column missing", HEADER[:-1], [r[:-1] for r in GOOD], r"wrenches\.csv:1: columns are .*expected index, fx"),
    ("column unknown", (*HEADER[:-1], "tz"), GOOD, r"wrenches\.csv:1: columns are .*tz; expected index, fx"),
    ("no rows", HEADER, [], r"wrenches\.csv.*no rows"),
]


@pytest.mark.parametrize(("header", "rows", "message"), [b[1:] for b in BAD], ids=[b[0] for b in BAD])
def test_refused(tmp_path: Path, header: Sequence[str], rows: list[list[Any]], message: str) -> None:
    """Each names the table, and its line where there is one."""
    text = refusal(table_job(tmp_path, rows, header))
    assert "wrenches.csv" in text and re.search(message, text), text


def test_no_table(tmp_path: Path) -> None:
    """The file of the cell is not there, or empty, or no text."""
    job = files(tmp_path, CELL)
    assert re.search(r"wrenches\.csv: there is no such file", refusal(job))
    (tmp_path / "wrenches.csv").write_bytes(b"")
    assert re.search(r"wrenches\.csv:1: columns are missing", refusal(job))
    (tmp_path / "wrenches.csv").write_bytes(b"\xff\xfe\xff")
    assert re.search(r"wrenches\.csv: is UTF-16 text; save it as UTF-8", refusal(job))
    (tmp_path / "wrenches.csv").write_text("index;fx;fy;fz;mx;my;mz\n2;1,5;0;0;0;0;0\n")
    assert re.search(r"wrenches\.csv:1: .*; cells are separated by commas, the decimal sign is a point", refusal(job))
    (tmp_path / "wrenches.csv").write_text("index,fx,fy,fz,mx,my,mz\n2,1,5,0,0,0,0,0\n")
    assert re.search(r"wrenches\.csv:2: .*; the decimal sign is a point", refusal(job))


def test_rows_of_a_csv_path(tmp_path: Path) -> None:
    """Index counts poses from 0; between two rows it is linear; rapids carry none, and need no row.

    Columns and rows stand in any order, and a row for a rapid is ignored.
    """
    order = [3, 0, 1, 2, 6, 5, 4]
    shuffled = [[r[k] for k in order] for r in (GOOD[2], GOOD[0], [0, 9e9, 0, 0, 0, 0, 0], GOOD[1])]
    job = table_job(tmp_path, shuffled, [HEADER[k] for k in order])
    compensate_file(job.toolpath, job.cell, job.out / "out.csv")
    at = columns(job.out / "out.csv", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm")
    got = columns(job.out / "out.csv", *FORCE)
    cut = np.array([row.split(",")[1] == "cut" for row in (job.out / "out.csv").read_text().splitlines()[1:]])
    assert np.all(got[~cut] == 0) and (~cut).sum() > 5
    wrenches = np.array(GOOD)[:, 1:]
    first = cut & (at[:, 0] < 1e-9) & (at[:, 1] < 1e-9)  # the plunge: from a rapid without a row
    assert np.allclose(got[first], wrenches[0])
    along_x = cut & (at[:, 0] > 1e-9) & (at[:, 1] < 1e-9)
    t = at[along_x, 0] / 100
    assert len(np.unique(t.round(6))) > 8
    assert np.allclose(got[along_x], (1 - t)[:, None] * wrenches[0] + t[:, None] * wrenches[1], atol=2e-6)
    along_y = cut & (at[:, 1] > 1e-9)
    t = at[along_y, 1] / 60
    assert np.allclose(got[along_y], (1 - t)[:, None] * wrenches[1] + t[:, None] * wrenches[2], atol=2e-6)


GCODE = "G21 G90 (one)\nG0 X0 Y0 Z30\nG1 Z-1 F300\n\nG1 X40 F900\nG3 X60 Y20 R20\nG1 Y50\nG0 Z30\n"


def test_lines_of_another_path(tmp_path: Path) -> None:
    """Index is the line of the source file from 1; every pose of an arc or a long move takes its line's wrench."""
    rows = [[line, 10.0 * line, line**2, -line, 0.1 * line, 0, 0] for line in (3, 5, 6, 7, 200)]
    job = table_job(tmp_path, rows)
    nc = tmp_path / "path.nc"
    nc.write_text(GCODE)
    compensate_file(nc, job.cell, job.out / "out.csv")
    got, line = columns(job.out / "out.csv", *FORCE), columns(job.out / "out.csv", "source_line")[:, 0]
    expected = np.array([next((r[1:] for r in rows if r[0] == n), [0.0] * 6) for n in line])
    assert set(line) == {2, 3, 5, 6, 7, 8} and np.sum(line == 6) > 10
    assert np.allclose(got, expected)
    assert np.all(got[(line == 2) | (line == 8)] == 0)
    # a cutting line without a row
    write_csv(tmp_path / "wrenches.csv", HEADER, [r for r in rows if r[0] != 6])
    (job.out / "out.csv").unlink()
    with pytest.raises(CompensatorError, match=r"no row with index 6: line 6 of .*path\.nc cuts"):
        compensate_file(nc, job.cell, job.out / "out.csv")
    # beyond the last row
    write_csv(tmp_path / "wrenches.csv", HEADER, rows[:2])
    with pytest.raises(CompensatorError, match=r"no row with index 6"):
        compensate_file(nc, job.cell, job.out / "out.csv")
    assert job.left() == []


def test_a_table_in_the_tool_frame_with_a_free_turn(tmp_path: Path) -> None:
    """Lateral forces in the tool frame need a fixed turn, in a table as in a constant."""
    tool_frame = {"process": {**CELL["process"], "frame": "tool"}}
    text = refusal(table_job(tmp_path, GOOD, cell=tool_frame))
    assert re.search(r"cell\.toml: process\.frame = 'tool' with a lateral force", text)
    axial = [[k, 0.0, 0.0, 100.0 * k, 0.0, 0.0, 2.0] for k in (2, 3, 4)]
    job = table_job(tmp_path, axial, cell=tool_frame)
    preview_file(job.toolpath, job.cell, csv=job.out / "p.csv")
    force = columns(job.out / "p.csv", *FORCE)
    assert np.allclose(force[:, :2], 0) and force[:, 2].min() == pytest.approx(-400.0)  # TCP z points down in the base
    # a rapid's row does not count, whatever it says
    sideways = [[1, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0], *axial]
    job = table_job(tmp_path, sideways, cell=tool_frame)
    assert preview_file(job.toolpath, job.cell).report["n_cut"] > 0


def test_poses_of_the_path_are_rows(tmp_path: Path) -> None:
    """A row that sampling leaves alone takes its own wrench exactly, whichever rows lie around it."""
    job = table_job(tmp_path, GOOD)
    preview_file(job.toolpath, job.cell, csv=job.out / "p.csv")
    line = columns(job.out / "p.csv", "source_line")[:, 0]
    at = columns(job.out / "p.csv", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm")
    got = columns(job.out / "p.csv", *FORCE)
    for k in (2, 3, 4):
        here = np.flatnonzero((line == k + 2) & np.all(np.abs(at - np.array(ROWS[k][:3], dtype=float)) < 1e-6, axis=1))
        assert len(here) == 1
        assert np.allclose(got[here[0]], GOOD[k - 2][1:], atol=2e-6)
