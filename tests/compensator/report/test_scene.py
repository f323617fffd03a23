"""The scene of a path: placements are those of the model, links stay together, long paths stay small."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from compensator.report.html.path import path_page
from compensator.report.scene.arm_bodies import arm_bodies, ends
from compensator.report.scene.drawn_body import FLOOR, WORK
from compensator.report.scene.flanks import UNKNOWN, WITHOUT, lamps, last_reversed
from compensator.report.scene.scene import first_factor, path_scene
from compensator.report.scene.shape_mesh import shape_mesh
from compensator.report.scene.solids import box, capsule, turned
from compensator.report.scene.stations import MOST_STATIONS, nearest, stations
from compensator.report.scene.work_bodies import fixture
from compensator.scene.body import Body
from compensator.scene.shape import BoxShape, MeshShape
from compensator.solve.compensation import Compensation
from compensator.solve.turnarounds import Turnaround
from tests.compensator.report.small_path import taken
from toolpaths.frame import Frame

Run = tuple[Compensation, dict[str, Any]]


def unpacked(text: str, kind: npt.DTypeLike = "<f4") -> npt.NDArray[Any]:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


@pytest.fixture(scope="module")
def scene(run: Run) -> dict[str, Any]:
    return path_scene(*run, np.zeros(len(run[0])), texts={8: "G1 X1 </script>", 999: "no pose"})


def placed(scene: dict[str, Any], side: str, factor: float) -> npt.NDArray[np.float64]:
    """(stations, links, 3, 4) as the page has them."""
    shape = (scene["stations"]["count"], scene["links"], 3, 4)
    nominal, added = (unpacked(scene["stations"][key]).astype(float).reshape(shape) for key in ("nominal", side))
    return nominal + factor * added


def test_the_tool_stands_where_the_model_has_it(run: Run, scene: dict[str, Any]) -> None:
    """Before: on the deflected path. With the program: on the nominal one. The controller takes the sag off link by
    link, so that a hundredth of the deflection is left open."""
    c, _ = run
    assert scene["stations"]["pose"] == list(range(len(c)))
    before, nominal = placed(scene, "before", 1.0)[:, -1, :, 3], placed(scene, "before", 0.0)[:, -1, :, 3]
    assert nominal == pytest.approx(c.path.tcp.origin, abs=2e-7)
    size = np.linalg.norm(c.error_before, axis=1).max()
    assert size > 3e-4
    assert before == pytest.approx(c.before, abs=0.01 * size)
    cut = c.cutting
    assert placed(scene, "after", 1.0)[cut, -1, :, 3] == pytest.approx(c.path.tcp.origin[cut], abs=0.01 * size)


@pytest.mark.parametrize("side", ["before", "after"])
def test_links_stay_together_however_large_the_deflection_is_drawn(run: Run, scene: dict[str, Any], side: str) -> None:
    robot = run[0].job.arm.robot
    drawn = placed(scene, side, 2000.0)
    for k in range(1, robot.n + 1):
        _, outer = ends(robot, k - 1)
        inner, _ = ends(robot, k)
        apart = [drawn[:, i, :, :3] @ point + drawn[:, i, :, 3] for i, point in ((k - 1, outer), (k, inner))]
        assert apart[0] == pytest.approx(apart[1], abs=1e-3)
    assert np.abs(drawn - placed(scene, side, 0.0)).max() > 0.1


def test_a_finding_knows_its_pose_and_its_line(run: Run) -> None:
    c, report = run
    pose = 40
    line = int(c.path.toolpath.line[pose])
    about = {"level": "warning", "kind": "path", "what": "w", "remedy": "", "count": 1}
    found = [
        {**about, "where": f"circle.csv:{line} (pose {pose})", "source_line": line},
        {**about, "where": "", "source_line": None},
        {**about, "where": "cell.toml", "source_line": 10**6},
    ]
    scene = path_scene(c, {**report, "findings": found})
    assert [f["station"] for f in scene["findings"]] == [pose, None, None]
    assert scene["stations"]["line"][pose] == line


def test_lines_of_the_source_are_those_of_the_stations(scene: dict[str, Any]) -> None:
    assert scene["texts"] == {"8": "G1 X1 </script>"}


def test_lamps_are_the_states_of_the_joints(run: Run) -> None:
    c, _ = run
    shown = lamps(c.job.arm, c.state)
    assert (shown[:, 4] == WITHOUT).all()  # its gap is 0
    known = c.state.known[:, 5]
    assert (shown[~known, 5] == UNKNOWN).all()
    assert shown[known, 5] == pytest.approx(100 * c.state.middle[known, 5] / 1.1e-4, abs=0.51)
    assert {-100, 100} <= set(shown[:, 5].tolist())


def test_the_joint_that_reversed_last() -> None:
    found = [Turnaround(3, 2, 1), Turnaround(6, 4, 1)]
    assert last_reversed(6, found).tolist() == [0, 0, 3, 3, 6, 6]


def test_stations_of_a_long_path() -> None:
    rows = stations(100_000, [77_777, 5, -3, 10**7])
    assert len(rows) <= MOST_STATIONS and {0, 5, 77_777, 99_999} <= set(rows.tolist())
    assert np.all(np.diff(rows) > 0) and np.diff(rows).max() < 260
    assert rows[nearest(rows, 77_776)] == 77_777
    assert stations(7).tolist() == list(range(7))


def test_the_first_factor_shows_the_deflection_without_tearing_the_arm_about() -> None:
    assert first_factor(0.3e-3, 2.5) == 500
    assert first_factor(0.0, 2.5) == 2000 and first_factor(1.0, 2.5) == 1


@pytest.mark.parametrize(
    ("mesh", "volume"),
    [
        (box(np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0])), 6.0),
        (turned(np.array([0.5, 0.5]), np.array([1.0, 3.0])), 0.25 * 2.0 * 24 / 2 * np.sin(2 * np.pi / 24)),
        (capsule(np.zeros(3), np.array([0.0, 2.0, 0.0]), 0.4), np.pi * 0.16 * (2.0 + 4 / 3 * 0.4)),
    ],
    ids=["box", "cylinder", "capsule"],
)
def test_solids_are_closed_and_look_outward(mesh: Any, volume: float) -> None:
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    assert np.sum(np.cross(a, b) * c) / 6 == pytest.approx(volume, rel=0.04)
    edges = {(int(f[i]), int(f[i - 1])) for f in mesh.faces for i in range(3)}
    assert len(edges) == 3 * len(mesh.faces) and all((y, x) in edges for x, y in edges)


def test_a_page_of_a_hundred_thousand_poses_is_below_ten_megabytes(run: Run) -> None:
    c, report = run
    long = taken(c, np.sort(np.random.default_rng(3).integers(0, len(c), 100_000)))
    text = path_page(long, report, np.zeros(len(long)))
    assert len(text.encode()) < 10e6


def test_equal_results_give_equal_scenes(run: Run, scene: dict[str, Any]) -> None:
    again = path_scene(*run, np.zeros(len(run[0])), texts={8: "G1 X1 </script>"})
    assert json.dumps(again) == json.dumps(scene)


def test_without_a_correction_there_is_no_second_side(preview: Run) -> None:
    scene = path_scene(*preview)
    assert "after" not in scene["stations"] and "commanded" not in scene["joints"]
    assert [k["key"] for k in scene["path"]["colours"]] == ["deflection", "force", "reversals"]


def body(name: str, carrier: Any, shape: Any, role: Any) -> Body:
    return Body(name, carrier, shape, Frame(np.eye(3), np.array([0.1, 0.2, 0.3])), role)


def test_links_are_drawn_as_their_shapes_and_as_capsules_without_one(run: Run) -> None:
    robot = run[0].job.arm.robot
    solid = capsule(np.zeros(3), np.zeros(3), 0.1)
    ball = MeshShape(solid.vertices, solid.faces)
    known = [body("base", "base", BoxShape(np.ones(3)), "link"), body("link-4", 4, ball, "link")]
    drawn = arm_bodies(robot, [*known, body("table", "world", BoxShape(np.ones(3)), "scene")])
    assert [b.frame for b in drawn] == [0, 4, 1, 2, 3, 5, 6]
    assert drawn[0].mesh.vertices.mean(axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert np.ptp(drawn[1].mesh.vertices, axis=0) == pytest.approx(0.2, abs=0.01)
    assert [b.frame for b in arm_bodies(robot, [])] == list(range(7))


@pytest.mark.parametrize(("carrier", "frame"), [("world", FLOOR), ("base", 0), ("workobject", WORK)])
def test_what_stands_around_goes_with_what_carries_it(carrier: Any, frame: int) -> None:
    assert fixture(body("vice", carrier, BoxShape(np.ones(3)), "scene")).frame == frame


def test_a_fine_mesh_is_thinned_and_keeps_its_size() -> None:
    turn = np.linspace(0, np.pi, 400)
    fine = turned(np.maximum(0.3 * np.sin(turn), 1e-6), 0.5 - 0.3 * np.cos(turn))
    drawn = shape_mesh(MeshShape(fine.vertices, fine.faces), 2000)
    assert 300 < len(drawn.faces) <= 2000 < len(fine.faces)
    assert drawn.vertices.min(axis=0) == pytest.approx([-0.3, -0.3, 0.2], abs=0.02)
    assert drawn.vertices.max(axis=0) == pytest.approx([0.3, 0.3, 0.8], abs=0.02)
