"""Real CAM files end to end: engagement, wrench, deflection, compensation, program; where ../shared is there."""

from __future__ import annotations

import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from compensator.errors import SolveError
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator.small_job import MODEL

DATA = Path(__file__).resolve().parents[5] / "shared" / "data" / "cam"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="no folder ../shared beside the checkout")
ALUMINIUM = "aluminium-6082-t6"


def flat(diameter: float, length: float, flutes: int = 3) -> dict[str, Any]:
    return {"shape": "flat", "diameter": diameter, "flutes": flutes, "length": length}


@dataclass(frozen=True)
class RealJob:
    """A file, its process, where its work object stands, and whether what it cuts is known to be free of errors."""

    file: str
    process: dict[str, Any]
    sound: bool = True
    workobject: dict[str, Any] = field(default_factory=lambda: {"xyz": [1500.0, -100.0, 800.0]})


JOBS = {
    "wall": RealJob(
        "gcode_fusion/1110_wall_265bit.nc",
        {
            "cutters": {"1": flat(2.65, 20.0, 2)},
            "stock": {"box": [[-6.0, -6.0, -14.0], [234.0, 76.0, 0.0]], "grid": 0.4},
        },
    ),
    "petri": RealJob(
        "apt_solidworkscam/SupPetriLED.apt",
        {
            "cutters": {"1": flat(14.0, 40.0), "16": flat(6.0, 30.0), "17": flat(4.0, 30.0)},
            "stock": {
                "box": [[0.0, 0.0, -30.0], [119.0, 119.0, -5.0]], "grid": 0.8,
                "part": str(DATA / "apt_solidworkscam/SupPetriLED.STL"),
            },
        },
    ),
    "5 axes": RealJob(
        "clsf_nx/ust_a.cls",
        {
            "cutters": {"2": {"shape": "bull", "diameter": 32.0, "corner_radius": 5.0, "flutes": 4, "length": 75.0}},
            "stock": {"box": [[20.0, 20.0, -60.0], [760.0, 180.0, 40.0]], "grid": 2.0},
            "spindle_rpm": 3000.0,
            "spindle": "m3",
        },
        workobject={"xyz": [1300.0, -400.0, 900.0], "rpy": [180.0, 0.0, 0.0]},
    ),
}  # fmt: skip


def cell_of(job: RealJob, folder: Path) -> Path:
    tool = {"xyz": [0.0, 0.0, 250.0], "mass": 30.0, "com": [0.0, 0.0, 110.0]}
    table = {
        "schema": "cell/1", "robot": "abb-irb6600-175-255", "tip": "tool0", "model": "model.toml",
        "gravity": "calibrated-out", "workobject": job.workobject, "solve": {"max_correction": 50.0},
        "tools": {n: {**tool, "name": f"T{n}"} for n in job.process["cutters"]},
        "process": {"kind": "milling", "material": ALUMINIUM, "coupled": False, **job.process},
    }  # fmt: skip
    (folder / "model.toml").write_text(tomli_w.dumps(MODEL))
    cell = folder / "cell.toml"
    cell.write_text(tomli_w.dumps(table))
    return cell


@pytest.mark.parametrize("name", JOBS)
def test_end_to_end(name: str, tmp_path: Path) -> None:
    job = JOBS[name]
    cell, out = cell_of(job, tmp_path), tmp_path / "out.csv"
    engagement, left = tmp_path / "cut.csv", tmp_path / "left.stl"
    if job.sound:
        done = compensate_file(DATA / job.file, cell, out, engagement=engagement, left=left)
        assert done.report["predicted_error_mm"]["after"]["max"] < 0.01
    else:
        done = preview_file(DATA / job.file, cell, csv=out, engagement=engagement, left=left)
        with pytest.raises(SolveError, match="the process is refused"):
            compensate_file(DATA / job.file, cell, tmp_path / "out.mod")
    cut = done.report["cut"]
    with open(engagement, newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [int(r["index"]) for r in rows] == list(range(done.report["n_poses"]))
    force = np.linalg.norm([[float(r[k]) for k in ("fx_n", "fy_n", "fz_n")] for r in rows], axis=1)
    air = np.array([r["entry_deg"] == "" for r in rows])
    assert np.all(force[air] == 0) and np.count_nonzero(force) > 100
    assert cut["removed_mm3"] > 1000 and 1 < cut["mean_n"] < 5000 and 0 <= cut["air_share"] < 1
    assert done.report["predicted_error_mm"]["before"]["max"] > 0
    assert left.stat().st_size > 10_000
