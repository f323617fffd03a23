"""RAPID in: moves, frames, constants, what is refused; docs/rapid.md."""

from __future__ import annotations

import contextlib
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.patience import not_hanging
from tests.oracles.read_text import read_text
from tests.oracles.robot_programs import RAPID, RAPID_ENDS, RAPID_LINES, TAIL, TOOL, WORK, module, target
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import Toolpath

read = partial(read_text, "part.mod")


def ends(path: Toolpath) -> np.ndarray:
    return np.abs(path.row - np.rint(path.row)) < 1e-9


@pytest.mark.parametrize("dress", ["plain", "crlf", "bom", "upper"])
def test_moves_of_a_program(tmp_path: Path, dress: str) -> None:
    text = {"crlf": RAPID.replace("\n", "\r\n"), "bom": "\ufeff" + RAPID, "upper": RAPID.upper()}.get(dress, RAPID)
    path = read(tmp_path, text)
    whole = ends(path)
    expected = np.array(RAPID_ENDS)
    np.testing.assert_allclose(path.position[whole] * 1e3, expected[:, :3], atol=1e-9)
    np.testing.assert_array_equal(path.kind[whole], expected[:, 3])
    np.testing.assert_array_equal(path.line[whole], RAPID_LINES)
    np.testing.assert_allclose(path.feed[whole], [1, 0.1, 0.02, 0.02, 0.02, 1, 1, 0.1, 0.03])
    np.testing.assert_allclose(path.axis, [[0, 0, 1]] * len(path), atol=1e-12)
    assert path.language == "rapid" and not path.quaternion.flags.writeable
    assert [e.word for e in path.events][:1] == ["plunge".upper() if dress == "upper" else "plunge"]


def test_tool_work_object_and_zones(tmp_path: Path) -> None:
    setting = read(tmp_path, RAPID).setting
    tool = setting.tools[1]
    assert (tool.name, tool.mass) == ("spindle", 30.0)
    np.testing.assert_allclose(tool.frame.origin, [0.03, -0.02, 0.24])
    np.testing.assert_allclose(tool.frame.rotation, Rotation.from_euler("y", 25, degrees=True).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(setting.workobject.origin, [1.5, -0.15, 0.8])
    turn = Rotation.from_euler("z", 20, degrees=True).as_matrix()
    np.testing.assert_allclose(setting.workobject.rotation, turn, atol=1e-12)
    np.testing.assert_allclose(setting.zones * 1e3, [10, 0, 1, 1, 1, 10, 10, 0, 2])
    np.testing.assert_array_equal(setting.configuration, [0] * 9)


def test_an_arc_is_round_within_the_chord(tmp_path: Path) -> None:
    path = read(tmp_path, RAPID, chord=1e-6)
    arc = np.ceil(path.row - 1e-9) == 4
    off = np.linalg.norm(path.position[arc][:, :2] - [0.1, 0.04], axis=1) - 0.02
    assert arc.sum() > 100 and np.abs(off).max() < 1e-12
    assert path.position[arc][:, 0].min() >= 0.1 - 1e-12  # by way of x = 120
    step = np.linalg.norm(np.diff(path.position[arc], axis=0), axis=1)
    assert (step**2 / (8 * 0.02)).max() < 1e-6


def test_user_frame_times_object_frame_and_a_second_work_object(tmp_path: Path) -> None:
    other = '[FALSE,TRUE,"",[[10,20,30],[0.5,0.5,0.5,0.5]],[[1,2,3],[0.707106781,0,0,0.707106781]]]'
    data = f"PERS tooldata spindle:={TOOL};\nPERS wobjdata table:={WORK};\nPERS wobjdata b:={other};\n"
    place = target(5, 6, 7)
    body = f"MoveL {place},v10,z1,{TAIL}\nMoveL {place},v10,z1,{TAIL}\nMoveL {place},v10,z1,spindle\\WObj:=b;\n"
    path = read(tmp_path, module(body, data))
    user = Rotation.from_quat([0.5, 0.5, 0.5, 0.5])
    thing = Rotation.from_euler("z", 90, degrees=True).apply([5, 6, 7]) + np.array([1, 2, 3])
    base = user.apply(thing) + np.array([10, 20, 30])
    table = Rotation.from_euler("z", 20, degrees=True)
    np.testing.assert_allclose(path.position[2] * 1e3, table.inv().apply(base - [1500, -150, 800]), atol=1e-5)
    np.testing.assert_allclose(path.position[0] * 1e3, [5, 6, 7], atol=1e-12)


def test_constants_offsets_loops_and_calls(tmp_path: Path) -> None:
    body = """FOR i FROM 1 TO 3 DO
      IF i = 2 THEN
        MoveL Offs(p, i * 10, -step / 2, 0), v10, z1, tool0;
      ELSE
        MoveL RelTool(p, 1, 2, 3 \\Rx:=10 \\Ry:=20 \\Rz:=30), v10, z1, tool0;
      ENDIF
    ENDFOR
    p.trans.z := p.trans.z + 1;
    MoveL p, v10, z1, tool0;
    MoveL a{2}, v10, z1, tool0;"""
    down = target(10, 20, 30)
    data = f"VAR robtarget p := {down};\nCONST num step := 2*(3+1);\n"
    data += f"CONST robtarget a{{2}} := [{down},{target(1, 2, 3)}];\n"
    path = read(tmp_path, module(body, data))
    turn = Rotation.from_quat([1, 0, 0, 0])  # x, y, z, w: half a turn about x
    shift = turn.apply([1, 2, 3])
    np.testing.assert_allclose(path.position[0] * 1e3, shift + np.array([10, 20, 30]), atol=1e-9)
    np.testing.assert_allclose(path.position[1] * 1e3, [30, 16, 30], atol=1e-9)
    np.testing.assert_allclose(path.position[3:] * 1e3, [[10, 20, 31], [1, 2, 3]], atol=1e-9)
    read_turn = Rotation.from_quat(path.quaternion[0], scalar_first=True)
    expected = turn * Rotation.from_euler("XYZ", [10, 20, 30], degrees=True)
    assert (read_turn.inv() * expected).magnitude() < 1e-9


def test_a_loop_that_never_runs(tmp_path: Path) -> None:
    move = f"MoveL {target(1, 2, 3)},v10,z1,tool0;"
    assert len(read(tmp_path, module(f"FOR i FROM 1 TO 5 STEP -1 DO\n{move}\nENDFOR\n{move}"))) == 1


def test_joint_moves_are_left_to_the_robot(tmp_path: Path) -> None:
    joints = "[[10,-20,30,40,50,-60],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    path = read(tmp_path, module(f"MoveAbsJ j,v100,fine,tool0;\nMoveL {target(1, 2, 3)},v10,z1,tool0;",
                                 f"CONST jointtarget j:={joints};\n"))  # fmt: skip
    assert np.isnan(path.position[0]).all() and path.kind.tolist() == [0, 1]
    np.testing.assert_allclose(np.degrees(path.setting.joints[0]), [10, -20, 30, 40, 50, -60])


CALLS = """MODULE M
PROC main()
  SpindleOn 8000\\Cw,"a;b";  SpindleOff;
  Warm 3;
  start:
  IF di1=1 SetDO do1,1;
  IF (TRUE AND NOT FALSE) OR 3 DIV 2=1 MoveL [[1,2,3],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,z1,tool0;
  IF FALSE MoveL [[9,9,9],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,z1,tool0;
  MoveL [[4,5,6],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v10,z1,tool0;
ENDPROC
PROC Warm(num minutes)
  ! nothing moves
  IF di2=1 THEN
    SetAO ao1,minutes;
  ENDIF
ENDPROC
ENDMODULE
"""


def test_calls_labels_and_short_conditions(tmp_path: Path) -> None:
    path = read(tmp_path, CALLS)
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 3], [4, 5, 6]])
    assert path.line.tolist() == [7, 9]
    assert [e.word for e in path.events][:4] == ['SpindleOn 8000\\Cw,"a;b";', "SpindleOff;", "Warm 3;", "start"]


def test_constant_choices(tmp_path: Path) -> None:
    one, other = (f"MoveL {target(k, 2, 3)},v10,z1,tool0;\n" for k in (1, 9))
    body = f"TEST 2*m\nCASE 1, 3:\n{other}CASE 5,4 :\n{one}CASE 4:\n{other}DEFAULT:\n{other}ENDTEST\n"
    body += f"TEST m DEFAULT:\n{one}ENDTEST\nTEST m\nENDTEST\n"
    body += "TEST di1\nCASE 1: Set do1;\nDEFAULT: ! nothing\nENDTEST\n"
    assert read(tmp_path, module(body, "CONST num m:=2;\n")).position[:, 0].tolist() == [1e-3, 1e-3]


LONG = ["IF di=1 SetDO x,1;\n", "lab:\n", "c{};\n", "TEST n CASE 1: Set x; ENDTEST\n", "IF x ", " "]


@pytest.mark.parametrize("text", LONG)
def test_long_files_do_not_take_longer_for_each_line(tmp_path: Path, text: str) -> None:
    body = "".join(text.replace("{}", str(k)) for k in range(20_000))
    for code in (body, f"TEST {body}", f"IF {body}"):
        with not_hanging(), contextlib.suppress(ReadError):
            assert len(read(tmp_path, module(f"MoveL {target(1, 2, 3)},v10,z1,tool0;\n{code}"))) == 1


def test_two_work_objects_that_only_the_controller_knows(tmp_path: Path) -> None:
    """Where one lies in the other is not known: the poses of the two cannot be put together."""
    lines = [f"MoveL {target(k, 2, 3)},v10,z1,tool0\\WObj:=w{w};\n" for k, w in ((1, 1), (2, 1), (3, 2))]
    assert read(tmp_path, module("".join(lines[:2]))).setting.workobject is None
    with pytest.raises(ReadError, match="another frame") as caught:
        read(tmp_path, module("".join(lines)))
    assert caught.value.line == 5


def test_routines_of_a_module_beside(tmp_path: Path) -> None:
    """They are run; where their file cannot be read, those that move are refused: their moves would be missing."""
    text = module(f"Wash;\nMoveL {target(1, 2, 3)},v10,z1,tool0;\n")
    (tmp_path / "cell.sys").write_text("MODULE Cell\nPROC Wash()\nSetDO do1,1;\nENDPROC\nENDMODULE\n")
    assert len(read(tmp_path, text)) == 1
    other = f"MODULE Two\n  PROC Wash( )\n    MoveL {target(1, 2, 3)},v10,z1,tool0;\n  ENDPROC\nENDMODULE\n"
    (tmp_path / "two.MOD").write_text(other)
    (tmp_path / "cell.sys").unlink()
    assert len(read(tmp_path, text)) == 2
    (tmp_path / "two.MOD").write_text(other.replace("MODULE Two", "MODULE Two\n  PROC x()\n    GOTO a;\n  ENDPROC"))
    with pytest.raises(ReadError, match=r"Wash moves the arm, and its file .*two\.MOD:3: GOTO") as caught:
        read(tmp_path, text)
    assert caught.value.line == 3
    (tmp_path / "two.MOD").write_text("MODULE Two\n  PROC Wash()\n    Stop;\n    GOTO a;\n  ENDPROC\nENDMODULE\n")
    assert len(read(tmp_path, text)) == 1  # it moves nothing


def test_frames_that_are_no_numbers_and_tables(tmp_path: Path) -> None:
    for old, new in (("[[1500,", "[[1e999,"), ("[[30,-20,240]", "[[30,-1e999,240]")):
        with pytest.raises(ReadError, match="not a finite number"):
            read(tmp_path, RAPID.replace(old, new, 1))
    held = RAPID.replace('[FALSE,TRUE,"",[[1500', '[TRUE,TRUE,"",[[1500')
    with pytest.raises(ReadError, match="held by the arm"):
        read(tmp_path, held)
    turning = read(tmp_path, RAPID.replace('[FALSE,TRUE,"",[[1500', '[FALSE,FALSE,"STN1",[[1500'))
    assert turning.setting.workobject is None  # where the table stands is the cell's to say


def test_two_programs_and_a_part_of_one_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="Two programs"):
        read(tmp_path, RAPID + RAPID)
    with pytest.raises(ReadError, match=r"cut off|missing"):
        read(tmp_path, RAPID[: RAPID.index("    cut2;")])
    with pytest.raises(ReadError, match="declared twice, first in line 6"):
        read(tmp_path, RAPID.replace("wobjdata table", "wobjdata spindle"))
    held = RAPID.replace("tooldata spindle:=[TRUE", "tooldata spindle:=[FALSE")
    with pytest.raises(ReadError, match="robhold FALSE"):
        read(tmp_path, held)


def test_real_programs(shared: Path) -> None:
    path = read_toolpath(shared / "data/cam/robodk/Program.mod")
    np.testing.assert_allclose(path.setting.workobject.origin, [0.399855, 0, 0.1])
    assert len(path) == 6 and path.kind.tolist() == [0, 0, 1, 1, 1, 1]
    np.testing.assert_allclose(path.position[2] * 1e3, [18.715 - 399.855, 147.321, 458.168 - 100], atol=1e-9)
    np.testing.assert_allclose(path.position[3] * 1e3, [3.281, 147.321, 294.993], atol=1e-9)
    post = read_toolpath(shared / "data/cam/robodk_posts/ABB_RAPID_IRC5_test_post.mod")
    assert ends(post).sum() == 12 and post.setting.tools[1].frame.origin.tolist() == [0.38, 0, 0.2]
    np.testing.assert_allclose(post.feed[2:], 0.1)
