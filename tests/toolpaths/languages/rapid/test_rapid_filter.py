"""RAPID in place: only pose numbers of cutting moves change."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.commanded import SHIFT, TURN, bent, commanded
from tests.oracles.patience import not_hanging
from tests.oracles.robot_programs import RAPID, TAIL, target
from toolpaths.errors import WriteError
from toolpaths.files import read_toolpath
from toolpaths.languages.rapid.filter import rewrite
from toolpaths.rewriting.filter import Rewritten
from toolpaths.toolpath import Toolpath


def filtered(file: Path, shift: np.ndarray = SHIFT, turn: Rotation = TURN) -> tuple[Toolpath, Rewritten]:
    path = read_toolpath(file)
    return path, rewrite(file.read_bytes(), *commanded(path, shift=shift, turn=turn.as_rotvec()), file)


def test_a_target_of_several_moves_is_split_by_what_they_need(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    data = f"  CONST robtarget p:={target(1, 2, 3)}; ! here\n"
    body = "".join(f"MoveL p,v10,z1,{TAIL}\nMoveL {target(5, k, 6)},v10,z1,{TAIL}\n" for k in range(3))
    text = f"MODULE M\n{data}PROC main()\n{body}ENDPROC\nENDMODULE\n"
    file.write_text(text.replace(TAIL, "tool0;"))
    path = read_toolpath(file)
    shift = np.outer([1, 0, 2, 0, 1, 0], SHIFT)
    out = rewrite(file.read_bytes(), *commanded(path, shift=shift), file).text.decode()
    lines = out.split("\n")
    assert lines[2] == f"  CONST robtarget p:={target('1.1200', '1.6600', '3.5600')}; ! here"
    assert lines[3] == f"  CONST robtarget p_c1:={target('1.2400', '1.3200', '4.1200')};"
    assert [line.split(",")[0] for line in lines if "MoveL p" in line] == ["MoveL p", "MoveL p_c1", "MoveL p"]


def test_a_line_that_runs_twice_takes_one_pose_only(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    loop = f"FOR i FROM 1 TO 2 DO\nMoveL {target(1, 2, 3)},v10,z1,tool0;\nENDFOR"
    file.write_text(f"MODULE M\nPROC main()\n{loop}\nENDPROC\nENDMODULE\n")
    path = read_toolpath(file)
    same = rewrite(file.read_bytes(), *commanded(path, shift=SHIFT), file)
    assert same.text.count(b"1.1200") == 1
    with pytest.raises(WriteError, match=r"part\.mod:4.*several times"):
        rewrite(file.read_bytes(), *commanded(path, shift=np.outer([1, 2], SHIFT)), file)


def test_poses_put_in_become_lines_of_the_same_style(tmp_path: Path) -> None:
    file = tmp_path / "part.mod"
    file.write_bytes(RAPID.encode())
    path = read_toolpath(file)
    program, row = commanded(path, [0, 1, 1, *range(2, len(path))], SHIFT)
    row = row.copy()
    row[1] = 0.25
    lines = rewrite(file.read_bytes(), program, row, file).text.decode().split("\n")
    at = next(k for k, line in enumerate(lines) if "plunge" in line)
    pose = target("0.1200", "-0.3400", "-1.4400")
    assert lines[at] == f"    MoveL {pose},v100,fine,{TAIL} ! plunge"
    assert lines[at - 1] == f"    MoveL {pose},v100,z0,{TAIL}"  # fly-by: the arm does not stop there


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
        out = rewrite(file.read_bytes(), *commanded(path, shift=SHIFT), file)
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
