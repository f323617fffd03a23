"""RAPID in place: only pose numbers of cutting moves change."""

from __future__ import annotations

import difflib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.patience import not_hanging
from tests.oracles.robot_programs import RAPID, TAIL, target
from toolpaths.errors import ReadError, WriteError
from toolpaths.files import read_toolpath
from toolpaths.frame import Frame
from toolpaths.languages.rapid.filter import rewrite
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import Toolpath
from toolpaths.writing.marker import MARKER, refuse_compensated
from toolpaths.writing.program import Program

SHIFT = np.array([1.2e-4, -3.4e-4, 5.6e-4])
TURN = Rotation.from_rotvec([1e-3, -2e-3, 3e-3])


def commanded(path: Toolpath, shift: np.ndarray, turn: Rotation = TURN) -> Program:
    """The poses of a toolpath moved and turned, rapids as well: the filter must leave those."""
    position = np.nan_to_num(path.position) + shift
    quaternion = np.where(np.isfinite(path.quaternion), path.quaternion, [1.0, 0.0, 0.0, 0.0])
    rotation = (turn * Rotation.from_quat(quaternion, scalar_first=True)).as_matrix()
    n = len(path)
    return Program(
        "P", position, rotation, np.zeros((n, 6)), path.feed.copy(), path.kind.copy(), path.tool.copy(),
        path.line.copy(), {}, Frame.identity(), 0.5,
    )  # fmt: skip


def changed(old: bytes, new: bytes) -> tuple[list[str], list[str]]:
    """Lines that went, and lines that came."""
    a, b = old.decode("latin-1").split("\n"), new.decode("latin-1").split("\n")
    if len(b) == len(a) + 1:  # the marker alone came
        at = next(k for k, line in enumerate(b) if MARKER in line)
        pairs = [p for p in zip(a, b[:at] + b[at + 1 :], strict=True) if p[0] != p[1]]
        return [p[0] for p in pairs], [b[at], *(p[1] for p in pairs)]
    diff = list(difflib.unified_diff(a, b, n=0))[2:]
    return [d[1:] for d in diff if d[0] == "-"], [d[1:] for d in diff if d[0] == "+"]


def without_marker(text: bytes) -> bytes:
    """A rewritten program without the one comment line that came."""
    lines = text.splitlines(keepends=True)
    marked = [k for k, line in enumerate(lines) if MARKER.encode() in line]
    assert len(marked) == 1 and marked[0] < 12
    return b"".join(lines[: marked[0]] + lines[marked[0] + 1 :])


def whole(path: Toolpath) -> np.ndarray:
    return np.flatnonzero(np.abs(path.row - np.rint(path.row)) < 1e-9)


def filtered(file: Path, shift: np.ndarray = SHIFT, turn: Rotation = TURN) -> tuple[Toolpath, Rewritten]:
    path = read_toolpath(file)
    return path, rewrite(file.read_bytes(), commanded(path, shift, turn), path.row, file)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_nothing_changes_but_the_marker(tmp_path: Path, end: str) -> None:
    file = tmp_path / "part.mod"
    data = (RAPID.replace("! corner", "! Eck\u00fc, na so was") + "! the end").replace("\n", end).encode()
    file.write_bytes(data)
    _, out = filtered(file, 0 * SHIFT, Rotation.identity())
    lines = out.text.split(end.encode())
    assert lines.pop(5) == f"  ! {MARKER}".encode()
    assert end.encode().join(lines) == data and out.changes == ()
    with pytest.raises(ReadError, match="compensated already") as caught:
        refuse_compensated(out.text, "x.mod")
    assert caught.value.line == 6
    refuse_compensated(data, "x.mod")


def test_only_poses_of_cuts_change(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    file.write_bytes(RAPID.replace("\n", "\r\n").encode())
    path, out = filtered(file)
    gone, come = changed(file.read_bytes(), out.text)
    assert len(gone) == 7 and len(come) == 9  # 2 of the 9: marker, and the target that was split
    assert out.text.count(b"\r\n") == out.text.count(b"\n")
    file.write_bytes(out.text)
    again = read_toolpath(file)
    a, b, cut = whole(path), whole(again), path.kind[whole(path)] == 1
    assert len(a) == len(b)
    np.testing.assert_array_equal(again.position[b][~cut], path.position[a][~cut])
    np.testing.assert_allclose(again.position[b][cut], path.position[a][cut] + SHIFT, atol=6e-8)
    turned = Rotation.from_quat(path.quaternion[a][cut], scalar_first=True)
    back = Rotation.from_quat(again.quaternion[b][cut], scalar_first=True)
    assert ((TURN * turned).inv() * back).magnitude().max() < 3e-8
    np.testing.assert_array_equal(again.feed[b], path.feed[a])
    told = " ".join(f"{c.place}: {c.what}" for c in out.changes)
    assert "p10_c1 was declared beside it" in told and "Offs(p10,0,0,82) became numbers" in told
    assert b"MoveC [[120.1200,39.6600,-1.4400],[0,1,0,0]" in out.text


def test_a_target_of_several_moves_is_split_by_what_they_need(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    data = f"  CONST robtarget p:={target(1, 2, 3)}; ! here\n"
    body = "".join(f"MoveL p,v10,z1,{TAIL}\nMoveL {target(5, k, 6)},v10,z1,{TAIL}\n" for k in range(3))
    text = f"MODULE M\n{data}PROC main()\n{body}ENDPROC\nENDMODULE\n"
    file.write_text(text.replace(TAIL, "tool0;"))
    path = read_toolpath(file)
    shift = np.outer([1, 0, 2, 0, 1, 0], SHIFT)
    out = rewrite(file.read_bytes(), commanded(path, shift, Rotation.identity()), path.row, file).text.decode()
    lines = out.split("\n")
    assert lines[2] == f"  CONST robtarget p:={target('1.1200', '1.6600', '3.5600')}; ! here"
    assert lines[3] == f"  CONST robtarget p_c1:={target('1.2400', '1.3200', '4.1200')};"
    assert [line.split(",")[0] for line in lines if "MoveL p" in line] == ["MoveL p", "MoveL p_c1", "MoveL p"]


def test_a_line_that_runs_twice_takes_one_pose_only(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    loop = f"FOR i FROM 1 TO 2 DO\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDFOR"
    file.write_text(f"MODULE M\nPROC main()\n{loop}\nENDPROC\nENDMODULE\n")
    path = read_toolpath(file)
    same = rewrite(file.read_bytes(), commanded(path, SHIFT), path.row, file)
    assert same.text.count(b"1.1200") == 1
    with pytest.raises(WriteError, match=r"part\.mod:4.*several times"):
        rewrite(file.read_bytes(), commanded(path, np.outer([1, 2], SHIFT)), path.row, file)


def test_poses_put_in_become_lines_of_the_same_style(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    file.write_bytes(RAPID.encode())
    path = read_toolpath(file)
    index = np.array([0, 1, 1, *range(2, len(path))])
    row = path.row[index].copy()
    row[1] = 0.25
    program = commanded(path.take(index), SHIFT, Rotation.identity())
    lines = rewrite(file.read_bytes(), program, row, file).text.decode().split("\n")
    at = next(k for k, line in enumerate(lines) if "plunge" in line)
    pose = target("0.1200", "-0.3400", "-1.4400")
    assert lines[at] == f"    MoveL {pose},v100,fine,{TAIL} ! plunge"
    assert lines[at - 1] == f"    MoveL {pose},v100,z0,{TAIL}"  # fly-by: the arm does not stop there


def test_an_arc_that_is_none_any_more_becomes_lines(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    file.write_bytes(RAPID.encode())
    path = read_toolpath(file)
    arc = np.ceil(path.row - 1e-9) == 4
    shift = np.where(arc[:, None], 1e-4 * np.sin(40 * path.row)[:, None], 0.0) * [1.0, 1.0, 1.0]
    out = rewrite(file.read_bytes(), commanded(path, shift, Rotation.identity()), path.row, file)
    assert b"MoveC" not in out.text and any("short lines" in c.what for c in out.changes)
    file.write_bytes(out.text)
    again = read_toolpath(file)
    assert len(again) == len(path)
    cut = path.kind == 1
    np.testing.assert_allclose(again.position[cut], (path.position + shift)[cut], atol=6e-8)


def test_real_programs_come_back_word_by_word(shared: Path, tmp_path: Path) -> None:
    files = sorted((shared / "data/cam").rglob("*.mod"))
    assert len(files) >= 2
    for file in files:
        _, out = filtered(file, 0 * SHIFT, Rotation.identity())
        assert without_marker(out.text) == file.read_bytes()
        path, moved = filtered(file)
        gone, come = changed(file.read_bytes(), moved.text)
        assert len(gone) == len(come) - 1 == int((path.kind[whole(path)] == 1).sum())
        (tmp_path / "out.mod").write_bytes(moved.text)
        again = read_toolpath(tmp_path / "out.mod")
        cut = path.kind[whole(path)] == 1
        there = again.position[whole(again)][cut]
        np.testing.assert_allclose(there, path.position[whole(path)][cut] + SHIFT, atol=6e-8)


def test_calls_of_what_is_not_in_the_file_are_told(shared: Path) -> None:
    _, out = filtered(shared / "data/cam/robodk/Program.mod")
    told = [str(c) for c in out.changes]
    assert len(told) == 1 and "line 30: Subprog is not in this file" in told[0] and "not compensated" in told[0]


def bent(path: Toolpath, nominal: list[float], commanded: list[float]) -> Program:
    """Commanded poses with the same joint angles, deg, at every pose: by the program, and behind the correction."""
    n = len(path)
    angles = [np.radians(np.tile(q, (n, 1)).astype(float)) for q in (nominal, commanded)]
    return replace(shifted(path), nominal_joints=angles[0], joints=angles[1])


def shifted(path: Toolpath) -> Program:
    return commanded(path, SHIFT, Rotation.identity())


@pytest.mark.parametrize(
    ("said", "nominal", "command", "written"),
    [
        ("0,-1,1,1", [0.01, 0, 0, -0.01, 20, 90.01], [-0.01, 0, 0, 0.01, 20, 89.99], "-1,0,0,1"),
        ("0,3,-3,1", [0.01, 0, 0, -0.01, 20, 90.01], [0.02, 0, 0, 0.01, 20, 89.99], "0,4,-4,1"),  # other whole turns
        ("2,-2,-1,0", [0.01, 0, 0, -0.01, 20, 90.01], [-0.01, 0, 0, 0.01, 20, 89.99], "2,-2,-1,0"),  # not of this arm
        ("0,0,0,0", [0.01, 9, 9, 0.01, 20, 0.01], [89.9, -9, 99, 0.02, -20, 45], "0,0,0,0"),
    ],
)
def test_confdata_follows_an_axis_into_the_next_quarter(
    tmp_path: Path, said: str, nominal: list[float], command: list[float], written: str
) -> None:
    file = tmp_path / "part.mod"
    pose = f"[[1,2,3],[0,1,0,0],[{said}],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    moves = f"MoveJ {pose},v10,z1,tool0;\nMoveL {pose.replace('3]', '4]', 1)},v10,z1,tool0;\n"
    file.write_text(f"MODULE M\nPROC main()\n{moves}ENDPROC\nENDMODULE\n")
    path = read_toolpath(file)
    out = rewrite(file.read_bytes(), bent(path, nominal, command), path.row, file).text.decode()
    assert f"MoveJ {pose}" in out
    assert f"MoveL [[1.1200,1.6600,4.5600],[0,1,0,0],[{written}],[9E9" in out


def test_many_arcs(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    arc = f"MoveC {target(1, 1, 0)},{target(2, 0, 0)},v10,z1,tool0;\nMoveC {target(1, -1, 0)},{target(0, 0, 0)},"
    first = f"MoveL {target(0, 0, 0)},v10,z1,tool0;\n"
    file.write_text(f"MODULE M\nPROC main()\n{first}{f'{arc}v10,z1,tool0;{chr(10)}' * 3000}ENDPROC\nENDMODULE\n")
    path = read_toolpath(file, chord=1e-4)
    with not_hanging():  # for every arc all arcs were gone through once
        out = rewrite(file.read_bytes(), shifted(path), path.row, file)
    assert out.text.count(b"MoveC") == 6000


@pytest.mark.parametrize("sign", [1, -1])
def test_a_quaternion_stays_on_its_side(tmp_path: Path, sign: int) -> None:
    """Of q and -q, the same turn, the one near the old digits: a diff shows small changes."""
    file = tmp_path / "part.mod"
    old = sign * np.array([0.1, -0.7, 0.5, -0.5])
    pose = f"[[1,2,3],[{','.join(f'{v:.8f}' for v in old)}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    file.write_text(f"MODULE M\nPROC main()\nMoveL {pose},v10,z1,tool0;\nENDPROC\nENDMODULE\n")
    _, out = filtered(file)
    new = re.search(rb"\],\[(.*?)\],\[0,0,0,0\]", out.text)
    assert new and np.abs(np.array([float(v) for v in new[1].split(b",")]) - old).max() < 5e-3
