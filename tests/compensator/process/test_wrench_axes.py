"""The process wrench in its four frames, and the axes of the path, by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.cell.cell_file import load_cell
from compensator.cell.placement import placement_of
from compensator.path.free_turn import about_z
from compensator.process.constant import ConstantProcess
from compensator.process.path_axes import path_axes
from compensator.process.process import ProcessContext, ToolMotion
from compensator.tasks.compensate import preview_file
from tests.compensator.handmade_toolpaths import DOWN, toolpath
from tests.compensator.small_job import files
from toolpaths.frame import Frame

X, Y, Z = np.eye(3)


def axes(xyz: list[list[float]], rotation: np.ndarray | None = None) -> np.ndarray:
    """path_axes of a path in mm; the tool points down unless said otherwise."""
    turned = np.tile(DOWN, (len(xyz), 1, 1)) if rotation is None else rotation
    return path_axes(np.array(xyz, dtype=float) / 1e3, turned)


def test_a_corner() -> None:
    """At the corner the feed that LEAVES counts; the last pose keeps the last direction; y = z cross x."""
    got = axes([[0, 0, 0], [50, 0, 0], [50, 30, 0], [20, 30, 0]])
    assert np.allclose(got[:, :, 2], -Z)
    assert np.allclose(got[:, :, 0], [X, Y, -X, -X])
    assert np.allclose(got[:, :, 1], [-Y, X, Y, Y])  # -z cross x = -y
    assert np.allclose(np.linalg.det(got), 1)


def test_a_plunge_keeps_the_last_x() -> None:
    """Along the tool there is no direction across: the last one stays, and the first takes the next."""
    got = axes([[0, 0, 30], [0, 0, 0], [0, 40, 0], [0, 40, -5], [0, 40, 20], [-10, 40, 20]])
    assert np.allclose(got[:, :, 0], [Y, Y, Y, Y, -X, -X])


def test_slanted_moves_are_projected() -> None:
    """A ramp: x is the horizontal part, of length 1, whatever the slope; 1 nm across is a direction too."""
    got = axes([[0, 0, 0], [30, 40, -500], [30.5, 40, -2000], [30.5, 40.001, -2000], [30.5, 41, -2000]])
    assert np.allclose(got[:, :, 0], [[0.6, 0.8, 0], X, Y, Y, Y], atol=1e-9)


def test_repeated_poses_leave_with_the_next_move() -> None:
    """Standing still is no direction: the pose leaves where the next real move goes."""
    got = axes([[0, 0, 0], [0, 0, 0], [20, 0, 0], [20, 0, 0], [20, 0, 0], [20, -5, 0], [20, -5, 0]])
    assert np.allclose(got[:, :, 0], [X, X, -Y, -Y, -Y, -Y, -Y])


def test_a_tilted_tool() -> None:
    """z is the tool's, x the feed made normal to it, y completes; at 30 deg of tilt, by hand."""
    tilt = Rotation.from_euler("y", 30, degrees=True).as_matrix() @ DOWN
    z = np.array([-0.5, 0, -np.sqrt(3) / 2])
    got = axes([[0, 0, 0], [10, 0, 0], [10, 10, 0]], np.tile(tilt, (3, 1, 1)))
    assert np.allclose(got[:, :, 2], z)
    assert np.allclose(got[0, :, 0], [np.sqrt(3) / 2, 0, -0.5])
    assert np.allclose(got[1:, :, 0], Y)
    assert np.allclose(got[:, :, 1], np.cross(z, got[:, :, 0]))


def test_x_kept_over_a_change_of_tilt_stays_normal() -> None:
    """A plunge along a tool that then tilts: the kept x is made normal to the new z."""
    down, tilt = DOWN, Rotation.from_euler("y", 20, degrees=True).as_matrix() @ DOWN
    way = tilt[:, 2] * 10
    xyz = [[0, 0, 0], [30, 0, 0], (np.array([30, 0, 0]) + way).tolist()]
    got = axes(xyz, np.stack([down, tilt, tilt]))
    assert np.allclose(np.einsum("nij,nik->njk", got, got), np.eye(3), atol=1e-12)
    assert got[1, 0, 0] > 0.9 and got[2, 0, 0] > 0.9


def test_a_path_without_any_direction_across() -> None:
    """Drilling only: the TCP's own axes."""
    turned = np.tile(DOWN @ about_z(0.7), (3, 1, 1))
    assert np.allclose(axes([[0, 0, 10], [0, 0, 0], [0, 0, -10]], turned), turned)


@pytest.mark.parametrize("seed", range(5))
def test_frames_are_right_handed_whatever_the_path(seed: int) -> None:
    """Random paths with random tools: orthonormal, z the tool's, x with a forward part."""
    g = np.random.default_rng(seed)
    xyz = np.cumsum(g.normal(size=(200, 3)), axis=0)
    xyz[g.random(200) < 0.2] = xyz[0]
    rotation = Rotation.random(200, rng=g).as_matrix()
    got = axes(xyz.tolist(), rotation)
    assert np.allclose(np.swapaxes(got, 1, 2) @ got, np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(got), 1) and np.allclose(got[:, :, 2], rotation[:, :, 2])
    feed = np.diff(xyz, axis=0)
    moving = np.linalg.norm(feed, axis=1) > 1e-6
    assert np.all(np.sum(feed * got[:-1, :, 0], axis=1)[moving] > 0)


WRENCH = [-120.0, 80.0, -60.0, 4.0, -3.0, 2.0]


def in_base(tmp_path: Path, frame: str, **solve: Any) -> tuple[np.ndarray, np.ndarray]:
    """Wrenches of an L with a tool of known turn, in a work object turned by roll 20, pitch -10, yaw 90 deg."""
    cell = {
        "workobject": {"rpy": [20.0, -10.0, 90.0]},
        "process": {"kind": "constant", "frame": frame, "wrench": WRENCH},
        "solve": solve,
    }
    work = Rotation.from_euler("xyz", [20, -10, 90], degrees=True).as_matrix()
    path = toolpath(
        [[0, 0, 20], [0, 0, 0], [50, 0, 0], [50, 30, 0]], "rccc", quaternion=quaternions(DOWN @ about_z(0.4), 4)
    )
    rotation = np.tile(work @ DOWN @ about_z(0.4), (4, 1, 1))
    position = path.position @ work.T + [1.5, -0.15, 0.8]
    placement = placement_of(load_cell(files(tmp_path, cell).cell))
    motion = ToolMotion(path, placement.workobject, Frame(rotation, position))
    return placement.process.load(motion).wrench, work


def quaternions(rotation: np.ndarray, n: int) -> np.ndarray:
    """(n, 4) w, x, y, z."""
    return np.tile(Rotation.from_matrix(rotation).as_quat()[[3, 0, 1, 2]], (n, 1))


def twice(rotation: np.ndarray) -> np.ndarray:
    """The wrench of the cell, force and moment turned."""
    return np.concatenate([rotation @ WRENCH[:3], rotation @ WRENCH[3:]])


def test_the_four_frames(tmp_path: Path) -> None:
    """base, workobject, tool and path, at every cutting pose; rapids carry none."""
    base, work = in_base(tmp_path, "base")
    assert np.allclose(base, [[0.0] * 6, WRENCH, WRENCH, WRENCH])
    got, _ = in_base(tmp_path, "workobject")
    assert np.allclose(got[1:], twice(work)) and np.all(got[0] == 0)
    # yaw 90 alone would send x to y: the order is Rz Ry Rx
    assert np.allclose(work[:, 0], [0, np.cos(np.radians(10)), np.sin(np.radians(10))])
    got, _ = in_base(tmp_path, "tool", free_tool_axis=False)
    assert np.allclose(got[1:], twice(work @ DOWN @ about_z(0.4)))
    got, _ = in_base(tmp_path, "path")
    along_x, along_y = np.column_stack([X, -Y, -Z]), np.column_stack([Y, X, -Z])
    assert np.allclose(got[1], twice(work @ along_x)) and np.all(got[0] == 0)
    assert np.allclose(got[2:], twice(work @ along_y))


def test_orientations_in_the_file_fix_the_turn(tmp_path: Path) -> None:
    """Whatever free_tool_axis says, which is about what the file leaves open: robot programs always give them."""
    fixed, work = in_base(tmp_path, "tool", free_tool_axis=True)
    assert np.allclose(fixed[1:], twice(work @ DOWN @ about_z(0.4)))
    (tmp_path / "p.src").write_text(
        "DEF p()\n$TOOL={X 0,Y 0,Z 250,A 0,B 0,C 0}\n$BASE={X 1500,Y 0,Z 800,A 0,B 0,C 0}\n$VEL.CP=0.02\n"
        "PTP {X 0,Y 0,Z 50,A 30,B 0,C 180}\nLIN {X 0,Y 0,Z 0,A 30,B 0,C 180}\nLIN {X 50,Y 0,Z 0,A 30,B 0,C 180}\nEND\n"
    )
    process = {"kind": "constant", "frame": "tool", "wrench": WRENCH}
    cell = files(tmp_path, {"process": process, "tool": None, "workobject": None}).cell
    result = preview_file(tmp_path / "p.src", cell).result
    turn = Rotation.from_euler("ZYX", [30, 0, 180], degrees=True).as_matrix()
    assert np.allclose(result.wrench[result.cutting], twice(turn))


def test_the_wrench_stays_with_the_feed_up_to_the_end_of_a_cut(tmp_path: Path) -> None:
    """A rapid is no feed: the way it leaves does not turn the load on the last pose of the cut before it."""
    process = ConstantProcess(ProcessContext("cell.toml", tmp_path), "path", tuple(WRENCH))
    path = toolpath([[0, 0, 0], [50, 0, 0], [100, 0, 0], [100, 80, 0]], "rccr")
    base = Frame(np.eye(3), np.zeros(3))
    got = process.load(ToolMotion(path, base, Frame(np.tile(DOWN, (4, 1, 1)), path.position))).wrench
    assert np.allclose(got[1], twice(np.column_stack([X, -Y, -Z])))
    assert np.allclose(got[2], got[1])


def test_drilling_with_rapids_across(tmp_path: Path) -> None:
    """Where no feed goes across the tool the rapids between the holes are all there is."""
    kind = np.array([0, 1, 0, 0, 1], dtype=np.uint8)
    xyz = np.array([[0, 0, 10], [0, 0, 0], [0, 0, 10], [0, -20, 10], [0, -20, 0.0]]) / 1e3
    got = path_axes(xyz, np.tile(DOWN, (5, 1, 1)), kind)
    assert np.allclose(got[:, :, 0], -Y)


def test_rapids_do_not_turn_the_next_cut(tmp_path: Path) -> None:
    """The pose where a cut begins leaves with the cut; a pose that is left twice counts with its next move."""
    kind = np.array([0, 0, 1, 1, 0, 0, 1, 1], dtype=np.uint8)
    xyz = np.array(
        [[0, 0, 10], [0, 0, 1], [0, 0, 0], [50, 0, 0], [50, 0, 10], [50, 40, 10], [50, 40, 0], [50, 90, 0.0]]
    )
    got = path_axes(xyz / 1e3, np.tile(DOWN, (8, 1, 1)), kind)
    assert np.allclose(got[:, :, 0], [X, X, X, X, X, X, Y, Y])
