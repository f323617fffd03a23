"""The stock in stages along a path: each is what a path that ends there leaves, drawn on the same nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from compensator.process.milling.mill import Cut, mill
from compensator.process.milling.path import MillingPath
from compensator.process.milling.stages import stock_stages
from compensator.process.milling.surface import nodes_around, surface
from compensator.report.scene import stock_stages as stock_stages_module
from compensator.report.scene.moments import Moments
from compensator.report.scene.solids import SolidMesh
from compensator.report.scene.stages import Stages
from compensator.report.scene.stock_stages import FEWEST, MOST, left_stages, stage_count, stage_poses
from tests.compensator.process.milling.milling_jobs import FLAT20, K7075, along_x, block, path

Floats = npt.NDArray[np.float64]
CELL = 2e-3
LOW, HIGH = (0, -40, -20), (80, 40, 0)


def two_levels() -> MillingPath:
    """A level of one straight run of 41 poses, a rapid, moves that fall, and a tool that tilts on the way back."""
    level = along_x(-12, 92, 2.6, y=-12, z=-5)
    falls = np.array([[92, -12, 30], [92, 8, 30], [92, 8, -2], [60, 14, -9], [30, 5, -9], [-15, 12, -12]], dtype=float)
    back = np.column_stack([np.linspace(-15, 95, 9), np.full(9, 25.0), np.full(9, -7.0)])
    points = np.concatenate([level, falls, back])
    tilt = np.concatenate([np.zeros(len(points) - 9), np.linspace(0.0, 0.5, 9)])
    axis = np.column_stack([np.sin(tilt), np.zeros(len(tilt)), np.cos(tilt)])
    rapid = np.isin(np.arange(len(points)), len(level) + np.arange(2))
    return path(points, FLAT20, axis=axis, rapid=rapid)


def until(whole: MillingPath, pose: int) -> MillingPath:
    """The path up to a pose."""
    end = slice(pose + 1)
    return MillingPath(
        whole.position[end].copy(), whole.axis[end].copy(), feed=whole.feed[end], spindle=whole.spindle[end],
        sense=whole.sense[end], rapid=whole.rapid[end].copy(), cutter=whole.cutter[end].copy(), cutters=whole.cutters,
    )  # fmt: skip


def volume(vertices: Floats, faces: npt.NDArray[np.int64]) -> float:
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.sum(np.cross(a, b) * c)) / 6


def of_stage(mesh: SolidMesh, stages: Stages, stage: int) -> npt.NDArray[np.int64]:
    """Faces as the page takes them."""
    count, first, end = stages.runs.T
    return mesh.faces[np.repeat((first <= stage) & (stage < end), count)]


@pytest.fixture(scope="module")
def cut() -> Cut:
    return mill(two_levels(), block(LOW, HIGH), K7075, cell=1e-3)


def test_a_stage_is_what_a_path_that_ends_there_leaves(cut: Cut) -> None:
    """In the middle of a straight run (one row of moves), in the air, along falling moves and a tilt."""
    assert cut.remains is not None
    nodes = nodes_around(cut.remains.stock.box, CELL)
    poses = [0, 17, 40, 42, 45, 46, 51, len(cut) - 1]
    stages = [volume(*surface(v, nodes)) for v in stock_stages(cut, cut.remains, nodes, poses)]
    stock = 80e-3 * 80e-3 * 20e-3
    assert stages[0] == pytest.approx(stock, rel=0.01)  # marching cubes round off the edges
    for pose, found in zip(poses[1:], stages[1:], strict=True):
        left = mill(until(cut.path, pose), block(LOW, HIGH), K7075, cell=1e-3).remains
        assert left is not None
        assert found == pytest.approx(volume(*left.mesh(CELL)), abs=1e-3 * stock)
    assert stages[-1] < 0.9 * stock


def test_stations_see_the_stock_shrink(cut: Cut) -> None:
    """The merged mesh has at every station what the stage that is over then has, closed; volumes only fall."""
    assert cut.remains is not None
    rows = np.arange(len(cut))
    mesh, stages = left_stages(cut, cut.remains, CELL, Moments(rows, (17,)))
    assert stages.stage[0] == 0 and len(set(stages.stage.tolist())) > 20
    volumes = np.array([volume(mesh.vertices, of_stage(mesh, stages, int(k))) for k in stages.stage])
    stock = 80e-3 * 80e-3 * 20e-3
    assert volumes[0] == pytest.approx(stock, rel=0.01)
    assert volumes[-1] == pytest.approx(volume(*cut.remains.mesh(CELL)), abs=1e-3 * stock)
    assert (np.diff(volumes) <= 1e-12).all()
    gone = cut.removed.sum() - np.cumsum(cut.removed)
    assert volumes - volumes[-1] == pytest.approx(gone, abs=0.08 * cut.removed.sum())
    wanted = mill(until(cut.path, 17), block(LOW, HIGH), K7075, cell=1e-3).remains
    assert wanted is not None
    assert volumes[17] == pytest.approx(volume(*wanted.mesh(CELL)), abs=1e-3 * stock)
    faces = of_stage(mesh, stages, int(stages.stage[30]))
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all()


def test_stages_are_even_in_poses_and_volume(cut: Cut) -> None:
    """Where nothing is taken away poses alone count: a good half of the path has a good quarter of the stages."""
    still = np.arange(len(cut)) > 20
    removed = np.where(still, 0.0, 1.0)
    poses = stage_poses(_with(cut, removed), 8)
    assert poses[0] == 0 and poses[-1] == len(cut) - 1 and len(poses) <= 10
    assert 2 <= int(np.sum(poses > 20)) <= 4
    assert {5, 33} <= set(stage_poses(_with(cut, removed), 8, (33, 5)).tolist())


def _with(cut: Cut, removed: Floats) -> Cut:
    return replace(cut, removed=removed)


def test_many_faces_leave_stages_out(cut: Cut, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many faces as a page can take; the last stage is still the last, and the first the stock."""
    assert cut.remains is not None
    rows = np.arange(len(cut))
    whole, every = left_stages(cut, cut.remains, CELL, Moments(rows))
    monkeypatch.setattr(stock_stages_module, "MOST_FACES", most := len(whole.faces) - 1000)
    mesh, stages = left_stages(cut, cut.remains, CELL, Moments(rows))
    assert len(mesh.faces) <= most
    assert 5 < len(np.unique(stages.stage)) < 0.6 * len(np.unique(every.stage))
    for k in (0, -1):
        found = volume(mesh.vertices, of_stage(mesh, stages, int(stages.stage[k])))
        assert found == pytest.approx(volume(whole.vertices, of_stage(whole, every, int(every.stage[k]))), rel=1e-9)


def test_a_fine_grid_has_fewer_stages() -> None:
    box = np.array([[0.0, 0.0, 0.0], [0.15, 0.11, 0.03]])
    assert stage_count(nodes_around(box, 2.5e-3)) == MOST
    cube = np.array([[0.0, 0.0, 0.0], [0.15, 0.15, 0.15]])
    assert stage_count(nodes_around(cube, 2.5e-3)) == FEWEST
    assert FEWEST < stage_count(nodes_around(cube, 3.5e-3)) < MOST
