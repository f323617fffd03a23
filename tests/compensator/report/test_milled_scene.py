"""The scene of a milled path: its cutter, the stock, what is left of it, and what a cut alone can be coloured by."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.report.scene.scene import path_scene
from compensator.tasks.compensate import preview_file
from tests.compensator import small_job
from tests.compensator.report.test_scene import unpacked


def volume(body: dict[str, Any]) -> float:
    vertices = unpacked(body["vertices"]).reshape(-1, 3).astype(float)
    a, b, c = vertices[unpacked(body["faces"], "<u4" if body["wide"] else "<u2").reshape(-1, 3)].transpose(1, 0, 2)
    return float(np.sum(np.cross(a, b) * c) / 6)


def test_cutter_stock_and_what_is_left(tmp_path: Path) -> None:
    job = small_job.files(tmp_path, {"process": small_job.milling(tmp_path)})
    done = preview_file(tmp_path / "path.csv", job.cell)
    scene = path_scene(done.result, done.report, judged=done.judged)
    bodies = {body["kind"]: body for body in scene["bodies"]}
    assert bodies["stock"]["frame"] == bodies["left"]["frame"] == -1
    assert volume(bodies["stock"]) == pytest.approx(0.15 * 0.12 * 0.025, rel=1e-5)
    gone = done.report["cut"]["removed_mm3"] * 1e-9
    assert gone > 1e-6
    assert volume(bodies["stock"]) - volume(bodies["left"]) == pytest.approx(gone, rel=0.5)
    tip = unpacked(bodies["cutter"]["vertices"]).reshape(-1, 3)
    assert tip[:, 2].max() == pytest.approx(0.0, abs=1e-6) and tip[:, 2].min() == pytest.approx(-0.02, abs=1e-6)
    assert np.hypot(tip[:, 0], tip[:, 1]).max() == pytest.approx(0.006, rel=1e-4)
    colours = {c["key"]: unpacked(c["value"]) for c in scene["path"]["colours"]}
    assert np.nanmax(colours["depth"]) == pytest.approx(float(done.result.load.columns["ap_mm"].max()), rel=1e-5)
    assert np.nanmax(colours["band"]) > 0 and np.isnan(colours["band"][~done.result.cutting]).all()
