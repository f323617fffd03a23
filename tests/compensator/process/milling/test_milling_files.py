"""Milling from files to files: the columns, signs and figures that scripts read; a slot worked out by hand."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import AXIS, Files, columns, files, milling

PAGE = Path(__file__).parents[4] / "docs" / "cutting.md"
HEADER = (
    "index,source_line,ap_mm,entry_deg,exit_deg,engaged_mm2,mrr_mm3_min,feed_per_tooth_mm,fx_n,fy_n,fz_n,mx_nm,my_nm,"
    "mz_nm,peak_n"
)
K = {"ktc": 796.0, "krc": 168.0, "kac": 222.0, "kte": 27.7, "kre": 30.8, "kae": 1.4}
CUTTER = {"shape": "flat", "diameter": 20.0, "flutes": 4, "length": 25.0, "helix": 30.0}
SLOT = [[-20, 0, 20, 0, 0, 1, 0, "rapid"], [-20, 0, -3, 0, 0, 1, 0, "rapid"], [60, 0, -3, 0, 0, 1, 2400, "cut"]]
FORCE = ("fx_n", "fy_n", "fz_n")


def slot(folder: Path, stock: list[list[float]], **changes: Any) -> Files:
    """The cutter goes along x of the work object, 3 mm deep; 6,000 1/min, 0.1 mm per tooth."""
    process = milling(
        folder, material=None, coefficients=K, cutter=CUTTER, stock={"file": None, "box": stock, "grid": 0.5}, **changes
    )
    return files(folder, {"process": process}, rows=SLOT, header=AXIS)


def in_path_axes(force: np.ndarray) -> np.ndarray:
    """From the base: the work object of the small job is turned by 20 deg about z; path y is -y of it, z is down."""
    return np.asarray(Rotation.from_euler("z", -20, degrees=True).apply(force) * [1, -1, -1])


@pytest.mark.parametrize(
    ("low", "high", "expected", "arc"),
    [
        (-30.0, 30.0, [-168.05, -344.61, 93.20], (-90, 90)),
        (-30.0, 0.0, [44.89, -247.17, 46.60], (0, 90)),
        (0.0, 30.0, [-212.94, -97.44, 46.60], (-90, 0)),
    ],
    ids=["slot", "climb", "up"],
)
def test_closed_forms(
    tmp_path: Path, low: float, high: float, expected: list[float], arc: tuple[int, int]
) -> None:
    """Steady poses inside the block, within 1 %; material on the right of the feed (-y here) is climb milled."""
    job = slot(tmp_path, [[0.0, low, -20.0], [100.0, high, 0.0]])
    out = job.out / "cut.csv"
    preview_file(job.toolpath, job.cell, engagement=out)
    force = in_path_axes(columns(out, *FORCE))[-1]
    assert np.linalg.norm(force - expected) < 0.01 * np.linalg.norm(expected)
    last = columns_of_last(out)
    assert (float(last["entry_deg"]), float(last["exit_deg"])) == pytest.approx(arc, abs=1.0)
    assert float(last["ap_mm"]) == pytest.approx(3.0, abs=0.01)
    assert float(last["feed_per_tooth_mm"]) == pytest.approx(0.1)


def columns_of_last(path: Path) -> dict[str, str]:
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))[-1]


def test_m4_mirrors(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    right = slot(tmp_path / "a", [[0.0, -30.0, -20.0], [100.0, 0.0, 0.0]])
    left = slot(tmp_path / "b", [[0.0, 0.0, -20.0], [100.0, 30.0, 0.0]], spindle="m4")
    found = []
    for job in (right, left):
        preview_file(job.toolpath, job.cell, engagement=job.out / "cut.csv")
        found.append(in_path_axes(columns(job.out / "cut.csv", *FORCE))[-1])
    assert found[1] == pytest.approx(found[0] * [1, -1, 1], rel=1e-6)
    both = [columns_of_last(j.out / "cut.csv") for j in (right, left)]
    assert both[0]["entry_deg"] == both[1]["entry_deg"] and both[0]["exit_deg"] == both[1]["exit_deg"]


def test_files_fit_together(tmp_path: Path) -> None:
    """Rows of --engagement are those of the csv beside it, with the same wrench; the JSON sums them up."""
    job = slot(tmp_path, [[0.0, -30.0, -20.0], [100.0, 30.0, 0.0]])
    cut, program, table = (job.out / n for n in ("cut.csv", "program.csv", "preview.csv"))
    done = compensate_file(job.toolpath, job.cell, program, engagement=cut, left=job.out / "left.stl")
    assert cut.read_text().splitlines()[0] == HEADER
    wrench = (*FORCE, "mx_nm", "my_nm", "mz_nm")
    np.testing.assert_allclose(columns(cut, "index", "source_line"), columns(program, "index", "source_line"))
    np.testing.assert_allclose(columns(cut, *wrench), columns(program, *wrench), atol=2e-6)
    report = done.report["cut"]
    assert list(report) == ["material", "coefficients", "grid_mm", "removed_mm3", "peak_n", "mean_n", "air_share"]
    assert report["coefficients"] == pytest.approx(K) and report["grid_mm"] == pytest.approx(0.5)
    force, peak = np.linalg.norm(columns(cut, *FORCE), axis=1), columns(cut, "peak_n")[:, 0]
    assert report["peak_n"] == pytest.approx(peak.max(), abs=1e-3) and np.all(peak >= 0.99 * force)
    assert report["mean_n"] == pytest.approx(force[force > 0].mean(), rel=1e-4)
    # the cutter's front is in the air for the first 10 of 80 mm; a pose stands every 10 mm
    assert report["air_share"] == pytest.approx(1 / 8, abs=1e-6)
    removed = 20.0 * 60.0 * 3.0 + np.pi * 100.0 / 2 * 3.0
    assert report["removed_mm3"] == pytest.approx(removed, rel=0.005)
    mesh = trimesh.load_mesh(job.out / "left.stl")
    assert mesh.is_watertight and mesh.volume == pytest.approx(100.0 * 60.0 * 20.0 - removed, rel=0.003)
    preview_file(job.toolpath, job.cell, csv=table)
    assert columns(table, *FORCE)[-1] == pytest.approx(columns(program, *FORCE)[-1], rel=1e-6)


def test_the_same_inputs_give_the_same_bytes(tmp_path: Path) -> None:
    job = slot(tmp_path, [[0.0, -30.0, -20.0], [100.0, 30.0, 0.0]])
    texts = []
    for name in ("a", "b"):
        out, left = job.out / f"{name}.csv", job.out / f"{name}.stl"
        preview_file(job.toolpath, job.cell, engagement=out, left=left)
        texts.append((out.read_bytes(), left.read_bytes()))
    assert texts[0] == texts[1]


def test_a_coupled_preview_cuts_less_where_the_tool_is_pushed_out(tmp_path: Path) -> None:
    """Climb milling pushes the tool off the wall; force and deflection agree, and differ from the nominal ones."""
    job = slot(tmp_path, [[0.0, -30.0, -20.0], [100.0, -8.0, 0.0]], coupled=True)
    done = preview_file(job.toolpath, job.cell, engagement=job.out / "cut.csv", csv=job.out / "p.csv")
    error = done.report["predicted_error_mm"]
    assert error["before"]["max"] > 0.01
    assert abs(error["before"]["max"] - error["uncoupled"]["max"]) > 0.01 * error["uncoupled"]["max"]
    exact = done.result.uncoupled
    assert exact is not None
    force = np.linalg.norm(done.result.wrench[-1, :3])
    assert force < 0.97 * np.linalg.norm(exact.wrench[-1, :3])  # 2 mm of radial depth are a tenth less
    assert not any("do not settle" in f.what for f in done.findings)


def test_standard_deviations_become_a_band(tmp_path: Path) -> None:
    """10 % of ktc alone: the band of the error is about 1.96 x 10 % of the part that ktc makes."""
    process = milling(tmp_path, cutter=CUTTER, stock={"file": None, "box": [[0.0, -30.0, -20.0], [100.0, 30.0, 0.0]]})
    sd = {"sd_nm_per_rad": [1e5, 1e5, 1e5, 1e4, 1e4, 1e3]}
    stiffness = {"k_nm_per_rad": [2.0e6, 1.7e6, 1.3e6, 2.8e5, 0.96e5, 0.37e5], **sd}
    model = {"effects": {"joint-stiffness": stiffness}}
    job = files(tmp_path, {"process": process}, model, rows=SLOT, header=AXIS)
    before = preview_file(job.toolpath, job.cell).report["predicted_error_mm"]["before"]
    band = before["band95"]
    for key in ("mean", "p95", "max"):
        low, high = band[key]
        assert low < before[key] < high
        assert 0.05 < (high - low) / 2 / before[key] < 0.4
    assert sum(band["share"].values()) == pytest.approx(1.0)
    assert 0.1 < band["share"]["material"] < 0.99 and band["share"]["joint-stiffness"] > 0.005


def test_gouges_and_rest_material_against_the_part(tmp_path: Path) -> None:
    """The part ends 2.5 mm below the top in the slot, so the cut of 3 mm gouges it; beside it 2.5 mm are left."""
    trimesh.creation.box(bounds=[[0.0, -30.0, -20.0], [100.0, 30.0, -2.5]]).export(tmp_path / "part.stl")
    stock = {"file": None, "box": [[0.0, -30.0, -20.0], [100.0, 30.0, 0.0]], "part": "part.stl"}
    process = milling(tmp_path, cutter=CUTTER, stock=stock)
    job = files(tmp_path, {"process": process}, rows=SLOT, header=AXIS)
    said = [f.what for f in preview_file(job.toolpath, job.cell).findings]
    assert any(w.startswith("cuts 0.500 mm into the finished part") for w in said)
    assert any("up to 2.500 mm of material are left on the finished part" in w for w in said)


def test_the_page_works_a_slot_by_hand(tmp_path: Path) -> None:
    """The numbers of docs/cutting.md: from the formulas there, and from the program."""
    f, ap, n = 0.1, 3.0, 4
    x = -n * ap / (2 * np.pi) * (K["krc"] * f * np.pi / 2 + 2 * K["kre"])
    y = -n * ap / (2 * np.pi) * (K["ktc"] * f * np.pi / 2 + 2 * K["kte"])
    z = n * ap / (2 * np.pi) * (2 * K["kac"] * f + np.pi * K["kae"])
    text = PAGE.read_text(encoding="utf-8")
    for value in (x, y, z):
        assert f"{value:.2f} N" in text
    pytest.importorskip("matplotlib")
    from docs.make_cut_picture import slot_force

    assert slot_force() == pytest.approx((x, y, z))
    job = slot(tmp_path, [[0.0, -30.0, -20.0], [100.0, 30.0, 0.0]])
    preview_file(job.toolpath, job.cell, engagement=job.out / "cut.csv")
    assert in_path_axes(columns(job.out / "cut.csv", *FORCE))[-1] == pytest.approx([x, y, z], rel=0.01)
