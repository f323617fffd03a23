"""The scene of a milled path: its cutter, the stock, what is left of it, and what a cut alone can be coloured by."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.report.html.path import path_page
from compensator.report.scene.posed_bodies import posed_bodies
from compensator.report.scene.scene import path_scene
from compensator.tasks.compensate import preview_file
from tests.compensator import small_job
from tests.compensator.report.test_scene import unpacked


def volume(body: dict[str, Any], station: int = 0) -> float:
    """m3, at a station as the page draws it."""
    if "stages" in body:
        vertices = body["low"] + unpacked(body["places"], "<u2").reshape(-1, 3) * np.array(body["unit"])
    else:
        vertices = unpacked(body["vertices"]).reshape(-1, 3).astype(float)
    faces = unpacked(body["faces"], "<u4" if body["wide"] else "<u2").reshape(-1, 3)
    if "stages" in body:
        count, first, end = np.array(body["stages"]["runs"]).reshape(-1, 3).T
        stage = unpacked(body["stages"]["stage"], "u1")[station]
        faces = faces[np.repeat((first <= stage) & (stage < end), count)]
    a, b, c = vertices[faces].transpose(1, 0, 2)
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
    left = [volume(bodies["left"], k) for k in range(scene["stations"]["count"])]
    assert left[0] == pytest.approx(volume(bodies["stock"]), rel=0.01)
    assert left[0] - left[-1] == pytest.approx(gone, rel=0.1)
    assert (np.diff(left) <= 1e-12).all() and len(set(left)) > 4
    assert path_page(done.result, done.report) == path_page(done.result, done.report)
    (still,) = [b for b in posed_bodies(done.result)[0] if b.kind == "left"]  # of pictures: what is left at the end
    a, b, c = still.vertices[still.faces].transpose(1, 0, 2)
    assert np.sum(np.cross(a, b) * c) / 6 == pytest.approx(left[-1], rel=1e-3)
    tip = unpacked(bodies["cutter"]["vertices"]).reshape(-1, 3)
    assert tip[:, 2].max() == pytest.approx(0.0, abs=1e-6) and tip[:, 2].min() == pytest.approx(-0.02, abs=1e-6)
    assert np.hypot(tip[:, 0], tip[:, 1]).max() == pytest.approx(0.006, rel=1e-4)
    colours = {c["key"]: unpacked(c["value"]) for c in scene["path"]["colours"]}
    assert np.nanmax(colours["depth"]) == pytest.approx(float(done.result.load.columns["ap_mm"].max()), rel=1e-5)
    assert np.nanmax(colours["band"]) > 0 and np.isnan(colours["band"][~done.result.cutting]).all()
