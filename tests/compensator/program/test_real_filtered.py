"""Real Fanuc and URScript programs of ../shared/data/cam through the whole product, in place."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from compensator.tasks.compensate import compensate_file
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath

FANUC = "fanuc_official_m710ic_50.urdf"
ROBOTS = {".ls": FANUC, ".script": "ur10"}
SOFT = {".ls": [1.2e6, 1.1e6, 8.0e5, 1.6e5, 9.0e4, 4.0e4], ".script": [2.0e5, 2.0e5, 1.0e5, 4.0e4, 4.0e4, 4.0e4]}
#: Where the work object stands of programs that only name it, from the remark of RoboDK.
FRAMES = {"Program.LS": [904.6, 0.0, 40.8]}
MARKS = (
    b"compensated by", b"toolpath-compensator", b":  !version", b" sha256:", b":  !predicted error",
    b"absolute accuracy",
)  # fmt: skip


def files(shared: Path) -> list[Path]:
    """Every one there is."""
    return sorted(p for p in (shared / "data" / "cam").rglob("*") if p.suffix.lower() in ROBOTS)


def job(folder: Path, shared: Path, program: Path, k: list[float], force: float) -> Path:
    """Cell and model; a robot of the shared data lies beside them."""
    robot = ROBOTS[program.suffix.lower()]
    if robot.endswith(".urdf"):
        (folder / robot).write_bytes((shared / "data" / "robots" / robot).read_bytes())
    model = {"schema": "model/1", "robot": robot, "effects": {"joint-stiffness": {"k_nm_per_rad": k}}}
    wrench = [-force, 0.6 * force, -0.5 * force, 0.0, 0.0, 0.0]
    cell: dict[str, Any] = {
        "schema": "cell/1", "robot": robot, "model": "model.toml", "gravity": "calibrated-out",
        "process": {"kind": "constant", "frame": "workobject", "wrench": wrench},
    }  # fmt: skip
    if program.name in FRAMES:
        cell["workobject"] = {"xyz": FRAMES[program.name]}
    if program.name == "Prog1.script":  # no set_tcp in front of its moves
        cell["tools"] = {"0": {"xyz": [0.0, 0.0, 0.0]}}
    (folder / "model.toml").write_text(tomli_w.dumps(model))
    (folder / "cell.toml").write_text(tomli_w.dumps(cell))
    return folder / "cell.toml"


def test_there_are_some(shared: Path) -> None:
    assert len(files(shared)) >= 4


@pytest.mark.parametrize("index", range(4))
def test_a_rigid_robot_gives_the_program_back_byte_by_byte(tmp_path: Path, shared: Path, index: int) -> None:
    source = files(shared)[index]
    out = tmp_path / ("c" + source.suffix)
    done = compensate_file(source, job(tmp_path, shared, source, [1e12] * 6, 0.0), out)
    lines = [line for line in out.read_bytes().splitlines(keepends=True) if not any(m in line for m in MARKS)]
    assert b"".join(lines) == source.read_bytes() and done.report["max_correction_mm"] < 1e-6
    assert all("is not beside" in c["what"] for c in done.report["changes"])


@pytest.mark.parametrize("index", range(4))
def test_a_soft_robot_changes_poses_and_nothing_else(tmp_path: Path, shared: Path, index: int) -> None:
    """What goes away are numbers of poses; what comes are those numbers, lines for poses put in, the mark."""
    source = files(shared)[index]
    suffix = source.suffix.lower()
    out = tmp_path / ("c" + source.suffix)
    done = compensate_file(source, job(tmp_path, shared, source, SOFT[suffix], 100.0), out)
    error = done.report["predicted_error_mm"]
    assert error["before"]["mean"] > 0.05 and error["after"]["max"] < 0.006
    before, after = (p.read_text("latin-1").splitlines() for p in (source, out))
    gone = [x[2:] for x in difflib.ndiff(before, after) if x.startswith("- ")]
    words = ("X =", "W =", "J1=") if suffix == ".ls" else ("movel(", "movec(", "movej(")
    assert gone and all(x.strip().startswith(words) for x in gone)
    assert sum("movej(" in x for x in gone) == sum("blend radius" in c["what"] for c in done.report["changes"])
    ends = [t.position[(t.kind == 1) & (t.row % 1 == 0)] for t in (read_toolpath(source), read_toolpath(out))]
    near = [np.linalg.norm(ends[1] - p, axis=1).min() for p in ends[0]]
    assert max(near) < 2.0 * error["before"]["max"] * 1e-3  # every pose is still there, moved by its deflection
    with pytest.raises(ReadError, match="compensated already"):
        compensate_file(out, tmp_path / "cell.toml", tmp_path / ("d" + source.suffix))
