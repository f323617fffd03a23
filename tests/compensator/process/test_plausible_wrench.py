"""Numbers beyond the usual range get a word that states the range, in the summary; usual ones get none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import CELL, ROWS, files, merged
from toolpaths.finding import WARNING

CUTTING = {"kind": "constant", "frame": "path"}


def warnings(folder: Path, cell: dict[str, Any], rows: list[list[Any]] = ROWS) -> list[str]:
    """Of a preview."""
    folder.mkdir(exist_ok=True)
    job = files(folder, cell, rows=rows)
    return [str(f) for f in preview_file(job.toolpath, job.cell).findings if f.level == WARNING]


def wrench(*values: float) -> dict[str, Any]:
    return {"process": {**CUTTING, "wrench": list(values)}}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((-0.12, 0.08, -0.06, 0.0, 0.0, 0.0), "the largest force is 0.156 N (usual are 1 to 20,000 N). Forces are in"),
        ((-12e3, 8e3, -20e3, 0.0, 0.0, 0.0), "the largest force is 2.47e+04 N (usual are 1 to 20,000 N)"),
        ((-120.0, 80.0, -60.0, 0.0, 0.0, 4000.0), "is 4000 N*m, that of 156 N at 25.6 m from the TCP (usual"),
        ((0.0, 0.0, 0.0, 0.0, 0.0, 4000.0), "is 4000 N*m (usual is less than 100 N*m). Moments are in N*m"),
        ((120.0, 80.0, 60.0, 0.0, 0.0, 0.0), "along its feed (72% of it, in the mean) and into the work (38%)"),
    ],
)
def test_an_unusual_wrench(tmp_path: Path, values: tuple[float, ...], words: str) -> None:
    """kN, N*mm, and the force on the part."""
    loose = {"solve": {"max_correction": 100.0}}
    found = warnings(tmp_path, merged(wrench(*values), loose))
    assert len(found) == 1 and words in found[0], found
    assert "cell.toml: process: " in found[0]


@pytest.mark.parametrize(
    "values",
    [
        (-120.0, 80.0, -60.0, 0.0, 0.0, 0.0), (40.0, 80.0, -60.0, 0.0, 0.0, 5.0), (-40.0, 10.0, 60.0, 0.0, 0.0, 5.0),
        (0.0, 0.0, -15000.0, 0.0, 0.0, 60.0), (-3.0, 0.0, -4.0, 0.0, 0.0, 0.0), (0.0,) * 6,
    ],
)  # fmt: skip
def test_a_usual_wrench(tmp_path: Path, values: tuple[float, ...]) -> None:
    """Milling up and down, a helix that draws in, friction stir welding, polishing, none at all."""
    assert warnings(tmp_path, wrench(*values)) == []


def test_a_drill_that_is_drawn_in(tmp_path: Path) -> None:
    """There the feed is the tool axis."""
    hole = [[0, 0, 80, 0, 0, 1, 0, "rapid"], [0, 0, 5, 0, 0, 1, 0, "rapid"], [0, 0, -20, 0, 0, 1, 300, "cut"]]
    assert warnings(tmp_path, wrench(0.0, 0.0, -400.0, 0.0, 0.0, -2.0), hole) == []
    (found,) = warnings(tmp_path, wrench(0.0, 0.0, 400.0, 0.0, 0.0, 2.0), hole)
    assert "along its feed (100% of it, in the mean) and into the work (100%)" in found


def test_a_table_is_looked_at_too(tmp_path: Path) -> None:
    (tmp_path / "w.csv").write_text("index,fx,fy,fz,mx,my,mz\n2,-.1,0,-.2,0,0,0\n3,-.1,0,-.2,0,0,0\n4,0,0,-.3,0,0,0\n")
    (found,) = warnings(tmp_path, {"process": {"kind": "table", "frame": "path", "file": "w.csv"}})
    assert "the largest force is 0.3 N" in found


def test_a_path_in_metres(tmp_path: Path) -> None:
    """Extent of what is cut, and feeds."""
    small = [[*(v / 1e3 for v in row[:3]), *row[3:]] for row in ROWS]
    (found,) = warnings(tmp_path, {}, small)
    assert "all cutting poses lie within 0.117 mm (usual is more than 5 mm). Columns are in mm: were these" in found
    slow = [[*row[:6], row[6] / 60e3, row[7]] for row in ROWS]
    (found,) = warnings(tmp_path, {}, slow)
    assert "the median feed of the cuts is 0.02 mm/min (usual are 5 to 60,000 mm/min)" in found


def test_a_tool_without_length(tmp_path: Path) -> None:
    (found,) = warnings(tmp_path, {"tool": {"xyz": [0.0, 0.0, 0.0]}})
    assert found == (
        "warning: tool tool: xyz is 0 0 0, the TCP is the flange (a spindle with its cutter is usually 100 to 600 mm "
        "long). Is the length of the tool missing?"
    )


def test_the_job_itself_is_usual(tmp_path: Path) -> None:
    """And what is written warns of the same as what is previewed."""
    assert warnings(tmp_path / "a", CELL) == []
    job = files(tmp_path, wrench(-0.12, 0.08, -0.06, 0.0, 0.0, 0.0))
    done = compensate_file(job.toolpath, job.cell, job.out / "a.mod")
    assert [f.what for f in done.findings if f.level == WARNING] == [
        "the largest force is 0.156 N (usual are 1 to 20,000 N)"
    ]
