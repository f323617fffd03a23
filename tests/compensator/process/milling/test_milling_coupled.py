"""Force and deflection together: where they settle, what is said where they do not; effects of a process on a cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from compensator.process.milling import first_run
from compensator.solve import coupled
from compensator.tasks.compensate import preview_file
from tests.compensator.process.milling.milling_jobs import arc_force
from tests.compensator.process.milling.test_milling_files import FORCE, in_path_axes, slot
from tests.compensator.small_job import MODEL, columns, files, milling

WALL = [[0.0, -30.0, -20.0], [100.0, -8.0, 0.0]]  # 2 mm of radial depth, on the climb side


def test_they_agree_with_the_closed_form_of_the_deflected_cut(tmp_path: Path) -> None:
    """The tool stands aside by d: the radial depth is 2 mm + d y, the axial one 3 mm + d z, and the closed form of that
    arc is the force under which the arm deflects by d."""
    job = slot(tmp_path, WALL, coupled=True)
    done = preview_file(job.toolpath, job.cell, engagement=job.out / "cut.csv")
    d = in_path_axes(done.result.error_before[-1]) * 1e3
    assert d[1] < -0.02  # pushed off the wall
    arc = (np.arcsin(1 - (2.0 + d[1]) / 10.0), np.pi / 2)
    expected = arc_force(*arc, ap=(3.0 + d[2]) * 1e-3, feed=1e-4, teeth=4)
    force = in_path_axes(columns(job.out / "cut.csv", *FORCE))[-1]
    assert np.linalg.norm(force - expected) < 0.02 * np.linalg.norm(expected)
    exact = arc_force(np.arcsin(0.8), np.pi / 2, ap=3e-3, feed=1e-4, teeth=4)
    assert np.linalg.norm(exact - expected) > 0.03 * np.linalg.norm(expected)


def test_what_does_not_settle_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After one round the plain fixed point is still off."""
    monkeypatch.setattr(coupled, "ROUNDS", 1)
    job = slot(tmp_path, WALL, coupled=True)
    (found,) = [f for f in preview_file(job.toolpath, job.cell).findings if "do not settle" in f.what]
    assert found.level == "warning" and found.count >= 5
    assert "unstable" in found.remedy  # along a straight wall it is not the place


def test_an_effect_of_the_process_changes_a_cut_and_keeps_its_files(tmp_path: Path) -> None:
    """It holds for the cutter by its name; forces of a straight cut grow by what it says, in path axes."""
    forces, effect = [], {"change": [0.5, 0.25, 0.1], "material": "own.toml", "cutter": "mill 12"}
    for name, told in (("plain", {}), ("worn", {"cutting-force": effect})):
        folder = tmp_path / name
        folder.mkdir()
        process = milling(folder, cutter={"name": "mill 12"})
        job = files(folder, {"process": process}, {"effects": {**MODEL["effects"], **told}})
        done = preview_file(job.toolpath, job.cell, engagement=job.out / "cut.csv", left=job.out / "left.stl")
        assert not any("cutting-force" in f.what for f in done.findings)
        forces.append(columns(job.out / "cut.csv", *FORCE))
    tool = done.result.path.tcp.rotation
    way = np.diff(done.result.path.tcp.origin, axis=0, prepend=np.nan)
    corner = np.flatnonzero(np.linalg.norm(forces[0], axis=1) > 50)
    checked = 0
    for k in corner:
        z = tool[k, :, 2]
        x = way[k] - z * (way[k] @ z)
        if np.linalg.norm(x) < 1e-6:
            continue
        x /= np.linalg.norm(x)
        axes = np.stack([x, np.cross(z, x), z])
        np.testing.assert_allclose(axes @ forces[1][k], (axes @ forces[0][k]) * [1.5, 1.25, 1.1], rtol=1e-3, atol=0.01)
        checked += 1
    assert checked > 5


def test_a_first_run_says_that_it_compiles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    monkeypatch.setattr(first_run.walk.stats.__class__, "cache_path", str(tmp_path), raising=False)
    job = files(tmp_path, {"process": milling(tmp_path)})
    preview_file(job.toolpath, job.cell, say=said.append)
    assert first_run.ONCE in said
