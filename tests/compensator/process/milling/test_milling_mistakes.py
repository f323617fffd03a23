"""Wrong input of a milled path: each refused with the file, the key, the value and what to do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from compensator.errors import CellError, CompensatorError, SolveError
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import AXIS, ROWS, Files, files, milling


def run(job: Files) -> Any:
    return preview_file(job.toolpath, job.cell)


def job_with(folder: Path, **changes: Any) -> Files:
    return files(folder, {"process": milling(folder, **changes)})


CUTTER = {"shape": "flat", "diameter": 12.0, "flutes": 3, "length": 20.0}
KEYS: list[tuple[str, dict[str, Any], str]] = [
    ("no cutter", {"cutter": None}, r"process: there is no cutter: give either \[process\.cutter\]"),
    ("zero flutes", {"cutter": {"flutes": 0}}, r"process\.cutter\.flutes = 0"),
    ("negative diameter", {"cutter": {"diameter": -12.0}}, r"process\.cutter\.diameter = -12\.0"),
    ("diameter in m", {"cutter": {"diameter": 0.012}}, r"diameter = 0\.012 mm: expected mm, this looks like metres"),
    ("helix of 90", {"cutter": {"helix": 90.0}}, r"process\.cutter\.helix = 90\.0"),
    ("unknown shape", {"cutter": {"shape": "conic"}}, r"process\.cutter\.shape = 'conic'"),
    ("bull without radius", {"cutter": {"shape": "bull"}}, "corner_radius is missing"),
    ("radius on a flat", {"cutter": {"corner_radius": 1.0}}, r"corner_radius = 1 with shape = 'flat'"),
    ("unknown key", {"cutter": {"teeth": 3}}, r"unknown key process\.cutter\.teeth = 3"),
    ("unknown material", {"material": "unobtainium"}, r"process\.material = 'unobtainium'.*aluminium-7075-t6"),
    ("material file gone", {"material": "gone.toml"}, r"process\.material = 'gone\.toml'"),
    ("no material", {"material": None}, "give material .*or coefficients"),
    ("both", {"coefficients": {"ktc": 700.0}}, "material and coefficients are both given"),
    ("no stock", {"stock": None}, r"process\.stock is missing"),
    ("box turned over", {"stock": {"file": None, "box": [[0.0, 0.0, 0.0], [9.0, 9.0, -9.0]]}}, "least corner first"),
    ("two stocks", {"stock": {"box": [[0.0, 0.0, -9.0], [9.0, 9.0, 0.0]]}}, "give one of file, box, cylinder"),
    ("stock file gone", {"stock": {"file": "gone.stl"}}, r"gone\.stl: cannot read the mesh"),
    ("no mesh", {"stock": {"file": "own.toml"}}, r"own\.toml: \.toml is no mesh that is read"),
    ("unknown unit", {"stock": {"units": "cm"}}, r"process\.stock\.units = 'cm'"),
    ("grid too coarse", {"stock": {"grid": 10.0}}, r"process\.stock\.grid = 10 mm: at most a quarter"),
    ("no speed", {"spindle_rpm": None}, r"path\.csv:4: no spindle speed.*process\.spindle_rpm"),
    ("zero speed", {"spindle_rpm": 0.0}, r"process\.spindle_rpm = 0\.0"),
    ("unknown sense", {"spindle": "m5"}, r"process\.spindle = 'm5'"),
    ("numbers with csv", {"cutter": None, "cutters": {"1": CUTTER}}, r"is a table without tool numbers"),
    ("longer than its tool", {"cutter": {"length": 300.0}}, r"cutter is longer than its stick-out"),
    ("long holder", {"cutter": {"holder": [{"diameter": 40.0, "length": 250.0}]}}, r"longer than its stick-out"),
]


@pytest.mark.parametrize(("changes", "message"), [k[1:] for k in KEYS], ids=[k[0] for k in KEYS])
def test_a_wrong_key_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(CellError, match=message) as refused:
        run(job_with(tmp_path, **changes))
    assert "cell.toml" in str(refused.value) or tmp_path.name in str(refused.value)


def opened(mesh: trimesh.Trimesh) -> None:
    mesh.update_faces(np.arange(len(mesh.faces)) != 3)


def inverted(mesh: trimesh.Trimesh) -> None:
    mesh.invert()


def in_metres(mesh: trimesh.Trimesh) -> None:
    mesh.apply_scale(1e-3)


def far_away(mesh: trimesh.Trimesh) -> None:
    mesh.apply_translation([5000.0, 0.0, 0.0])


MESHES: list[tuple[Callable[[trimesh.Trimesh], None], str]] = [
    (opened, r"cell\.toml: process\.stock\.file: .*stock\.stl: .*open"),
    (inverted, r"stock\.stl: its normals point inward"),
    (in_metres, r"stock\.stl: .*units = .m."),
    (far_away, r"stock\.stl: the path never meets the stock"),
]


@pytest.mark.parametrize(("spoil", "message"), MESHES, ids=[m[0].__name__ for m in MESHES])
def test_a_wrong_mesh_is_refused(
    tmp_path: Path, spoil: Callable[[trimesh.Trimesh], None], message: str
) -> None:
    job = job_with(tmp_path)
    mesh = trimesh.load_mesh(tmp_path / "stock.stl")
    spoil(mesh)
    mesh.export(tmp_path / "stock.stl")
    with pytest.raises(CellError, match=message):
        run(job)


def test_facets_that_are_no_numbers(tmp_path: Path) -> None:
    job = job_with(tmp_path)
    data = bytearray((tmp_path / "stock.stl").read_bytes())
    data[96:100] = np.float32(np.nan).tobytes()
    (tmp_path / "stock.stl").write_bytes(data)
    with pytest.raises(CellError, match=r"stock\.stl: facet 1 has a corner that is no number"):
        run(job)


def test_a_mesh_of_two_gigabytes_is_not_read(tmp_path: Path) -> None:
    job = job_with(tmp_path)
    with open(tmp_path / "stock.stl", "r+b") as stream:
        stream.truncate(2_000_000_000)  # a hole: no room is taken
    with pytest.raises(CellError, match=r"stock\.stl: 2\.0 GB; at most 1 GB"):
        run(job)


def gcode(folder: Path, *lines: str) -> Path:
    file = folder / "part.nc"
    file.write_text("\n".join(["G21 G90 G17", *lines, "M30"]) + "\n")
    return file


def test_a_tool_without_a_cutter_is_refused_by_line(tmp_path: Path) -> None:
    job = job_with(tmp_path, cutter=None, cutters={"1": CUTTER})
    file = gcode(tmp_path, "T2 M6", "S6000 M3", "G0 X-10 Y0 Z5", "G1 Z-2 F300", "X20 F600")
    with pytest.raises(CellError, match=r"part\.nc:5: tool 2 cuts, but .*give \[process\.cutters\.2\]"):
        preview_file(file, job.cell)


def test_an_s_word_wins_and_is_named(tmp_path: Path) -> None:
    job = job_with(tmp_path)
    file = gcode(tmp_path, "T1 M6", "S9000 M3", "G0 X-30 Y0 Z5", "G1 Z-2 F300", "X20 F600")
    done = preview_file(file, job.cell, engagement=tmp_path / "cut.csv")
    assert any("S 9000" in f.what and "spindle_rpm = 6000 is not used" in f.what for f in done.findings)
    rows = (tmp_path / "cut.csv").read_text().splitlines()
    last = dict(zip(rows[0].split(","), rows[-1].split(","), strict=True))
    assert float(last["feed_per_tooth_mm"]) == pytest.approx(600 / 9000 / 3, abs=1e-6)


def test_a_cut_with_a_spindle_that_stands_still(tmp_path: Path) -> None:
    job = job_with(tmp_path)
    file = gcode(tmp_path, "T1 M6", "S9000 M3", "G0 X-30 Y0 Z5", "G1 Z-2 F300", "X20 F600", "M5", "X40")
    done = preview_file(file, job.cell)
    (found,) = [f for f in done.findings if "stands still" in f.what]
    assert found.level == "error" and found.source_line == 8


def test_preview_shows_errors_and_compensate_refuses(tmp_path: Path) -> None:
    """A rapid through the block."""
    rows = [list(r) for r in ROWS]
    rows[1][2] = -2.0  # down into the material by a rapid
    job = files(tmp_path, {"process": milling(tmp_path)}, rows=rows, header=AXIS)
    assert any(f.level == "error" and "rapid goes through" in f.what for f in run(job).findings)
    with pytest.raises(SolveError, match=r"path\.csv:3 \(pose \d+\).*: a rapid goes through the material"):
        compensate_file(job.toolpath, job.cell, job.out / "a.mod")
    assert job.left() == []


def test_outputs_of_a_cut_need_a_stock(tmp_path: Path) -> None:
    job = files(tmp_path)
    for option in ("engagement", "left"):
        with pytest.raises(CellError, match=rf'--{option} needs \[process\] kind = "milling"'):
            preview_file(job.toolpath, job.cell, **{option: job.out / "a.stl"})  # type: ignore[arg-type]
    milled = job_with(tmp_path)
    with pytest.raises(CompensatorError, match=r"a\.dxf: the stock that remains is written as \.stl"):
        preview_file(milled.toolpath, milled.cell, left=job.out / "a.dxf")


def test_an_open_part_is_refused_by_its_key(tmp_path: Path) -> None:
    job = job_with(tmp_path, stock={"part": "part.stl"})
    mesh = trimesh.load_mesh(tmp_path / "stock.stl")
    opened(mesh)
    mesh.export(tmp_path / "part.stl")
    with pytest.raises(CellError, match=r"cell\.toml: process\.stock\.part: .*part\.stl: .*open"):
        run(job)


def test_a_force_that_jumps_between_wide_poses_is_noted(tmp_path: Path) -> None:
    """Into the block from the side: within 6 mm of the way all of the cutter is in, and poses are 10 mm apart."""
    rows = [[-60, 0, 20, 0, 0, 1, 0, "rapid"], [-60, 0, -2, 0, 0, 1, 0, "rapid"], [60, 0, -2, 0, 0, 1, 600, "cut"]]
    for spacing, count in ((10.0, 1), (1.0, 0)):
        job = files(tmp_path, {"process": milling(tmp_path), "sampling": {"spacing": spacing}}, rows=rows, header=AXIS)
        found = [f for f in run(job).findings if "enters or leaves material" in f.what]
        assert len(found) == count
        if found:
            assert found[0].level == "note" and "spacing = 1.5" in found[0].remedy and found[0].source_line == 4
