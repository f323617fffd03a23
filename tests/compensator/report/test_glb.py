"""The scene for other viewers: what is in it stands where the arm stands, upright, in metres."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import pytest
import trimesh

from compensator.report.scene.glb import glb_scene, tube
from compensator.report.scene.posed_bodies import worst_pose
from compensator.solve.compensation import Compensation

Run = tuple[Compensation, dict[str, Any]]


def test_it_is_read_back_with_the_tool_on_the_path(run: Run) -> None:
    c, _ = run
    data = glb_scene(c)
    scene = trimesh.load_scene(BytesIO(data), file_type="glb")
    assert data[:4] == b"glTF" and data == glb_scene(c)
    names = set(scene.geometry)
    assert sum(name.startswith("arm-") for name in names) == 7 and "path" in names
    x, y, z = c.path.tcp.origin[worst_pose(c)]
    cutter = next(scene.geometry[name] for name in names if name.startswith("cutter-"))
    (graph,) = [scene.graph[name][0] for name in scene.graph.nodes_geometry if name.startswith("cutter-")]
    points = trimesh.transform_points(cutter.vertices, graph)
    assert np.linalg.norm(points - [x, z, -y], axis=1).min() < 1e-3  # y upwards
    assert points[:, 1].min() == pytest.approx(z, abs=1e-3)
    tints = np.unique(scene.geometry["path"].visual.vertex_colors, axis=0)
    assert len(tints) > 20 and (tints[:, 3] == 255).all()


def test_a_tube_is_round_the_line() -> None:
    vertices, faces = tube(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 0.0, 2.0]]), 0.1)
    assert vertices.shape == (18, 3) and faces.shape == (18, 3) and faces.max() == 17
    assert np.hypot(vertices[:6, 0], vertices[:6, 1]) == pytest.approx(0.1)
    assert vertices[:6, 2].tolist() == [0.0] * 3 + [2.0] * 3
    assert np.isfinite(vertices).all()
