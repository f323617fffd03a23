"""The scene of a milled path: its cutter, the stock, what is left of it, and what a cut alone can be coloured by."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compensator.report.html.path import path_page
from compensator.report.scene.posed_bodies import posed_bodies
from compensator.report.scene.scene import path_scene
from compensator.report.scene.stock_stages import MOST_FACES
from compensator.tasks.compensate import compensate_file, preview_file
from tests.compensator import small_job
from tests.compensator.report.page_reader import data_in
from tests.compensator.report.small_path import taken
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


def layers(count: int, lines: int) -> list[list[Any]]:
    """Rows of a csv toolpath that cuts a block down in layers of so many lines, every one to and fro."""
    rows: list[list[Any]] = [[-20, -30, 60, 0, 0, 1, 0, "rapid"]]
    for layer in range(1, count + 1):
        for k, y in enumerate(np.linspace(-30, 90, lines).round(3)):
            there = [[x, y, -2 * layer, 0, 0, 1, 1200, "cut"] for x in (-20, 130)]
            rows += there[:: -1 if k % 2 else 1]
    x, y = rows[-1][:2]
    return [*rows, [x, y, 60, 0, 0, 1, 0, "rapid"]]


def test_a_milled_page_of_a_hundred_thousand_poses_is_below_ten_megabytes(tmp_path: Path) -> None:
    """Compensated, with every colour; its stock changes everywhere: the stages have as many faces as they may."""
    job = small_job.files(tmp_path, {"process": small_job.milling(tmp_path, stock={"grid": 2.5})}, rows=layers(9, 7))
    done = compensate_file(job.toolpath, job.cell, tmp_path / "out.csv")
    c, judged = done.result, done.judged
    rows = np.sort(np.random.default_rng(3).integers(0, len(c), 100_000))
    long = taken(c, rows)
    sd = np.zeros(len(c))
    sd[c.cutting] = judged.open.sd
    of_all = replace(judged, open=replace(judged.open, sd=sd[rows][long.cutting]))
    text = path_page(long, done.report, np.zeros(len(long)), judged=of_all)
    assert len(text.encode()) < 10e6
    scene = data_in(text, "scene")
    (left,) = (body for body in scene["bodies"] if body["kind"] == "left")
    assert 0.9 * MOST_FACES < sum(left["stages"]["runs"][::3]) <= MOST_FACES
    assert unpacked(left["stages"]["stage"], "u1").max() > 10
    assert {"left", "depth", "engagement", "band"} <= {colour["key"] for colour in scene["path"]["colours"]}
