"""What every kind of process keeps to: units, axes, rapids, deflected poses, poses put in later; on values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from compensator.cell.cell_file import load_cell
from compensator.cell.placement import placement_of
from compensator.errors import CellError
from compensator.path.added_poses import with_poses_before_corners, with_poses_between
from compensator.process.catalogue import PROCESSES
from compensator.process.process import Process, ProcessContext, ProcessLoad, ToolMotion, WrenchAxes
from tests.compensator.handmade_toolpaths import DOWN, toolpath
from tests.compensator.small_job import files
from toolpaths.finding import LEVELS, WARNING, Finding
from toolpaths.frame import Frame
from toolpaths.toolpath import CUT, Toolpath

AXES: tuple[WrenchAxes, ...] = get_args(WrenchAxes)
GIVEN = [-120.0, 80.0, -60.0, 4.0, -3.0, 2.0]
# down, a plunge, a quarter circle, a corner, off
ARC = np.radians(np.arange(0, 91, 10))
PLACES = [[60, 0, 40], [60, 0, 0], *np.column_stack([60 * np.cos(ARC), 60 * np.sin(ARC), 0 * ARC])[1:].tolist()]
PLACES += [[-40, 60, 0], [-40, 10, 0], [-40, 10, 50]]
KINDS = "rc" + "c" * 9 + "ccr"
WORK = Frame(Rotation.from_euler("xyz", [10, -20, 70], degrees=True).as_matrix(), np.array([1.4, -0.2, 0.7]))


def constant(folder: Path, axes: str) -> dict[str, Any]:
    return {"kind": "constant", "frame": axes, "wrench": GIVEN}


def table(folder: Path, axes: str) -> dict[str, Any]:
    rows = [f"{k},{','.join(f'{w * (1 + 0.1 * k):g}' for w in GIVEN)}" for k in range(len(PLACES))]
    (folder / "wrenches.csv").write_text("\n".join(["index,fx,fy,fz,mx,my,mz", *rows]) + "\n")
    return {"kind": "table", "frame": axes, "file": "wrenches.csv"}


def milling(folder: Path, axes: str) -> dict[str, Any]:
    cutter = {"shape": "flat", "diameter": 8.0, "flutes": 2, "length": 20.0}
    stock = {"box": [[-90.0, -90.0, -20.0], [90.0, 90.0, 3.0]]}
    coefficients = {"ktc": 700.0, "krc": 150.0, "kac": 200.0, "kte": 20.0, "kre": 20.0, "kae": 1.0}
    spindle = {"spindle_rpm": 6000.0, "spindle": "m3"}
    return {"kind": "milling", "coefficients": coefficients, "cutter": cutter, "stock": stock, **spindle}


SAMPLES: dict[str, Callable[[Path, str], dict[str, Any]]] = {"constant": constant, "table": table, "milling": milling}


class Chip(Process):
    """A member of tests alone, with all that the contract allows: it cuts what it is below z = 0 of the work object."""

    axes: WrenchAxes = "path"

    def load(self, motion: ToolMotion) -> ProcessLoad:
        cut = motion.toolpath.kind == CUT
        depth = np.where(cut, 2e-3 - motion.tcp.relative_to(motion.workobject).origin[:, 2], 0.0)
        wrench = np.zeros((len(motion), 6))
        wrench[:, :3] = 1e5 * depth[:, None] * motion.workobject.rotation[:, 2]
        path = motion.toolpath
        deep = np.flatnonzero(depth > 0.01)
        findings = (Finding(WARNING, f"{path.source}:{path.line[k]} (pose {k})", "deep") for k in deep)
        return ProcessLoad(wrench, tuple(findings), {"depth_mm": depth * 1e3})

    def description(self) -> str:
        return "chip"


def build(kind: str, folder: Path, axes: WrenchAxes) -> Process:
    if kind == "chip":
        return Chip()
    table_of = PROCESSES[kind].model_validate(SAMPLES[kind](folder, axes))
    return table_of.process(ProcessContext("cell.toml", folder))


def path_of() -> Toolpath:
    """The path, with a fixed orientation."""
    turned = Rotation.from_matrix(DOWN) * Rotation.from_euler("zy", [25, 4], degrees=True)
    quaternion = np.tile(turned.as_quat()[[3, 0, 1, 2]], (len(PLACES), 1))
    return toolpath(PLACES, KINDS, quaternion=quaternion)


def motion_of(path: Toolpath, work: Frame = WORK, deflected: Frame | None = None) -> ToolMotion:
    assert path.quaternion is not None
    rotation = Rotation.from_quat(path.quaternion[:, [1, 2, 3, 0]]).as_matrix()
    return ToolMotion(path, work, work.then(Frame(rotation, path.position)), deflected)


def turned(frame: Frame, wrench: np.ndarray) -> np.ndarray:
    """Wrenches (N, 6) with their vectors turned; they stay about the TCP."""
    return np.concatenate([frame.along(wrench[:, :3]), frame.along(wrench[:, 3:])], axis=1)


COMPUTED = [("chip", "path"), ("milling", "path")]
MEMBERS = [(kind, axes) for kind in ("constant", "table") for axes in AXES] + COMPUTED
each = pytest.mark.parametrize(("kind", "axes"), MEMBERS)


def test_every_process_is_here() -> None:
    """A new member has a sample; its table goes by the name in the catalogue."""
    assert set(SAMPLES) == set(PROCESSES)
    for kind, schema in PROCESSES.items():
        assert get_args(schema.model_fields["kind"].annotation) == (kind,)


@pytest.mark.parametrize("kind", PROCESSES)
def test_its_table_is_read_from_a_cell(tmp_path: Path, kind: str) -> None:
    """By kind; what the table does not know is refused with the name of the file."""
    given = SAMPLES[kind](tmp_path, "base")
    cell = load_cell(files(tmp_path, {"process": given}).cell)
    process = placement_of(cell).process
    assert type(process) is type(build(kind, tmp_path, "base"))
    assert process.axes == ("base" if "frame" in given else "path")
    with pytest.raises(CellError, match=r"cell\.toml: unknown key process\.more = 1; see docs"):
        load_cell(files(tmp_path, {"process": {**given, "more": 1}}).cell)
    unknown = r"process\.frame = 'flange'" if "frame" in given else r"unknown key process\.frame = 'flange'"
    with pytest.raises(CellError, match=rf"cell\.toml: {unknown}"):
        load_cell(files(tmp_path, {"process": {**given, "frame": "flange"}}).cell)


@each
def test_a_load_has_a_row_per_pose(tmp_path: Path, kind: str, axes: WrenchAxes) -> None:
    """(N, 6), finite, something at every cut and nothing at rapids; columns and findings fit the poses."""
    motion, process = motion_of(path_of()), build(kind, tmp_path, axes)
    load = process.load(motion)
    cut = motion.toolpath.kind == CUT
    assert load.wrench.shape == (len(motion), 6) and np.isfinite(load.wrench).all()
    assert (load.wrench[~cut] == 0).all() and (np.abs(load.wrench[cut]).max(axis=1) > 0).all()
    for name, column in load.columns.items():
        assert column.shape == (len(motion),) and "_" in name
    assert all(f.level in LEVELS and f.place for f in load.findings)
    assert process.axes == axes and "\n" not in process.description()


@each
def test_the_same_motion_gives_the_same_load(tmp_path: Path, kind: str, axes: WrenchAxes) -> None:
    """It has no memory, and leaves its argument as it is."""
    motion, process = motion_of(path_of()), build(kind, tmp_path, axes)
    for array in (motion.nominal.rotation, motion.nominal.origin):
        array.setflags(write=False)
    assert np.array_equal(process.load(motion).wrench, process.load(motion).wrench)
    at_nominal = replace(motion, deflected=motion.nominal)
    wrench = process.load(motion).wrench
    assert np.allclose(process.load(at_nominal).wrench, wrench, atol=1e-6 * np.abs(wrench).max())


@each
def test_the_wrench_moves_with_part_and_tool(tmp_path: Path, kind: str, axes: WrenchAxes) -> None:
    """Part and path put elsewhere in the base, turned: so is the wrench; but for one given in base axes."""
    move = Frame(Rotation.from_euler("zyx", [130, 20, -40], degrees=True).as_matrix(), np.array([0.3, 0.5, -0.1]))
    here, there = motion_of(path_of()), motion_of(path_of(), move.then(WORK))
    process = build(kind, tmp_path, axes)
    wrench = process.load(here).wrench
    expected = wrench if axes == "base" else turned(move, wrench)
    assert np.allclose(process.load(there).wrench, expected, atol=1e-9)


@each
def test_the_wrench_at_deflected_poses(tmp_path: Path, kind: str, axes: WrenchAxes) -> None:
    """The tool turns where it is: tool axes turn with it; work object and base do not; path axes keep their x about."""
    nominal, process = motion_of(path_of()), build(kind, tmp_path, axes)
    tilt = Frame(Rotation.from_euler("y", 0.2, degrees=True).as_matrix(), np.zeros(3))
    shifted = nominal.nominal.origin + np.array([1e-4, -2e-4, 3e-4])
    deflected = Frame(tilt.rotation @ nominal.nominal.rotation, shifted)
    before, after = process.load(nominal).wrench, process.load(replace(nominal, deflected=deflected)).wrench
    assert (after[nominal.toolpath.kind != CUT] == 0).all()
    if axes == "tool":
        assert np.allclose(after, turned(tilt, before), atol=1e-9)
    elif axes in ("base", "workobject"):
        assert np.array_equal(after, before)
    else:
        size = np.linalg.norm(before, axis=1).max()
        assert 0 < np.abs(after - before).max() < 0.2 * size


@pytest.mark.parametrize(("kind", "axes"), [m for m in MEMBERS if m[0] != "milling"])
def test_poses_put_in_later(tmp_path: Path, kind: str, axes: WrenchAxes) -> None:
    """What stood there keeps its wrench; between gentle neighbours it lies between, beyond a corner it jumps."""
    path, process = with_poses_before_corners(path_of()), build(kind, tmp_path, axes)
    known = process.load(motion_of(path))
    segments = np.arange(len(path) - 1)
    finer = with_poses_between(path, np.repeat(segments, 2), np.tile([0.25, 0.5], len(segments)))
    load = process.load_between(motion_of(finer), path, known)
    kept = np.isin(finer.row, path.row)
    assert load.wrench.shape == (len(finer), 6) and (load.wrench[finer.kind != CUT] == 0).all()
    if kind != "chip":
        assert np.allclose(load.wrench[kept], known.wrench, atol=1e-9 * np.abs(known.wrench).max())
    half = load.wrench[np.flatnonzero(kept)[:-1] + 2]
    mean = 0.5 * (known.wrench[:-1] + known.wrench[1:])
    gentle = slice(2, 10)  # inside the quarter circle
    assert np.allclose(half[gentle], mean[gentle], atol=1e-6 * np.abs(mean).max())


def test_milling_between_two_poses_that_are_known(tmp_path: Path) -> None:
    """Looked at inside of a segment the wrench lies between those of its ends; poses put in are walked to anew."""
    process, path = build("milling", tmp_path, "path"), path_of()
    known = process.load(motion_of(path))
    finer = with_poses_between(path, np.arange(len(path) - 1), np.full(len(path) - 1, 0.5))
    wrench = process.wrench_between(motion_of(finer), path, known)
    cut = finer.kind[1::2] == CUT
    assert np.allclose(wrench[1::2][cut], 0.5 * (known.wrench[:-1] + known.wrench[1:])[cut])
    assert np.allclose(wrench[::2], known.wrench)
    walked = process.load_between(motion_of(finer), path, known).wrench
    size = np.linalg.norm(known.wrench[3:10, :3], axis=1)
    assert np.allclose(np.linalg.norm(walked[6:20:2, :3], axis=1), size, rtol=0.1) and size.min() > 50


def test_what_a_process_finds_out_beside_the_wrench() -> None:
    """Findings name the pose; columns carry their unit; at deflected poses both are those of the deflected tool."""
    deep = motion_of(path_of())
    assert Chip().load(deep).findings == ()
    pushed = replace(deep, deflected=Frame(deep.nominal.rotation, deep.nominal.origin - 0.02 * WORK.rotation[:, 2]))
    load = Chip().load(pushed)
    assert len(load.findings) == int((deep.toolpath.kind == CUT).sum())
    assert load.findings[0].place == "test.csv:3 (pose 1)"
    assert np.allclose(load.columns["depth_mm"][deep.toolpath.kind == CUT], 22.0)
    with pytest.raises(ValueError, match="13 frames for 14 poses"):
        replace(deep, nominal=deep.nominal.take(slice(13)))
