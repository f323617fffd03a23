"""KRL in: .src with .dat, inline forms, frames, what is refused; docs/krl.md."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.patience import not_hanging
from tests.oracles.robot_programs import KRL, KRL_DAT, KRL_ENDS, KRL_LINES, source
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.toolpath import Toolpath

POSE = "{X 1,Y 2,Z 3,A 10,B 20,C 30}"


def read(tmp_path: Path, text: str, dat: str = "") -> Toolpath:
    file = tmp_path / "PART.src"
    file.write_bytes(text.encode())
    if dat:
        file.with_suffix(".dat").write_bytes(dat.encode())
    return read_toolpath(file)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_moves_of_a_program(tmp_path: Path, end: str) -> None:
    path = read(tmp_path, KRL.replace("\n", end), KRL_DAT.replace("\n", end))
    whole = np.abs(path.row - np.rint(path.row)) < 1e-9
    expected = np.array(KRL_ENDS)
    np.testing.assert_allclose(path.position[whole] * 1e3, expected[:, :3], atol=1e-9)
    np.testing.assert_array_equal(path.kind[whole], expected[:, 3])
    np.testing.assert_array_equal(path.line[whole], KRL_LINES)
    np.testing.assert_allclose(path.feed[path.kind == 1], 0.2)
    np.testing.assert_allclose(path.axis, [[0, 0, 1]] * len(path), atol=1e-12)
    setting = path.setting
    assert list(setting.tools) == [3] and np.isnan(setting.zones[0]) and setting.zones[4] == 0
    np.testing.assert_allclose(setting.tools[3].frame.origin, [0.03, -0.02, 0.24])
    np.testing.assert_allclose(
        setting.tools[3].frame.rotation, Rotation.from_euler("y", 25, degrees=True).as_matrix(), atol=1e-12
    )
    np.testing.assert_allclose(setting.workobject.origin, [1.5, -0.15, 0.8])
    assert setting.configuration[:3].tolist() == [0, 0, -1]  # S 2: wrist point in front of the lower arm


def test_frames_and_the_geometric_operator(tmp_path: Path) -> None:
    body = (
        "$BASE=BASE_DATA[1]:{X 10,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL=$NULLFRAME\n$VEL.CP=0.05\n$APO.CDIS=0.5\n"
        "P={X 5,Y 6,Z 7,A 40,B 50,C 60}\nLIN P:{X 1,Y 2,Z 3,A -10,B 20,C 30} C_DIS\nP.X=P.X+2*3\nLIN P"
    )
    text = "DEF PART()\nBASE_DATA[1]={X 1,Y 2,Z 3,A 90,B 0,C 0}\nDECL E6POS P\n" + body + "\nEND\n"
    path = read(tmp_path, text)
    first = Rotation.from_euler("ZYX", [40, 50, 60], degrees=True)
    np.testing.assert_allclose(path.position[0] * 1e3, first.apply([1, 2, 3]) + np.array([5, 6, 7]), atol=1e-9)
    expected = first * Rotation.from_euler("ZYX", [-10, 20, 30], degrees=True)
    assert (Rotation.from_quat(path.quaternion[0], scalar_first=True).inv() * expected).magnitude() < 1e-9
    np.testing.assert_allclose(path.position[1] * 1e3, [11, 6, 7], atol=1e-9)
    np.testing.assert_allclose(path.setting.workobject.origin * 1e3, [1, 12, 3], atol=1e-9)
    np.testing.assert_allclose(path.setting.zones * 1e3, [0.5, 0])
    np.testing.assert_allclose(path.feed, 0.05)


def test_what_the_controller_alone_knows_stays_open(tmp_path: Path) -> None:
    path = read(tmp_path, source(f"BAS(#TOOL,7)\nBAS(#BASE,2)\nPTP HOME\nLIN {POSE}\nLIN {{X 9}}"))
    assert path.setting.workobject is None and path.setting.tools == {} and path.tool.tolist() == [7, 7]
    np.testing.assert_allclose(path.position * 1e3, [[1, 2, 3], [9, 2, 3]], atol=1e-12)


def test_spline_lines_with_their_own_frames(tmp_path: Path) -> None:
    line = (
        "SLIN XP1 WITH $VEL=SVEL_CP(0.3, , LCPDAT1), $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO), "
        "$IPO_MODE=SIPO_MODE(FP1.IPO_FRAME), $ORI_TYPE=SORI_TYP(LCPDAT1) C_SPL"
    )
    data = "TOOL_DATA[3]={X 30,Y -20,Z 240,A 0,B 25,C 0}\nBASE_DATA[4]={X 1500,Y -150,Z 800,A 20,B 0,C 0}\n"
    text = source(data + line + "\nSPTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 -5}")
    path = read(tmp_path, text, KRL_DAT)
    np.testing.assert_allclose(path.feed, [0.3, np.nan])
    assert path.tool[0] == 3 and path.setting.workobject.origin[0] == 1.5
    np.testing.assert_allclose(np.degrees(path.setting.joints[1]), [0, -90, 90, 0, 10, -5])


def test_constant_choices(tmp_path: Path) -> None:
    one, other = (f"LIN {{X {k},Y 2,Z 3,A 0,B 0,C 180}}\n" for k in (1, 9))
    body = f"M=2\nSWITCH 2*M\nCASE 1,3\n{other}CASE 5,4\n{one}CASE 4\n{other}DEFAULT\n{other}ENDSWITCH\n"
    body += f"SWITCH M ; why\n; so\nDEFAULT\n{one}ENDSWITCH\n"
    body += "SWITCH $MODE_OP\nCASE #T1\n$OUT[1]=TRUE\nENDSWITCH"
    assert read(tmp_path, source(body)).position[:, 0].tolist() == [1e-3, 1e-3]


def test_relative_moves_in_tool_and_base(tmp_path: Path) -> None:
    steps = ["LIN_REL {X 1,Z 5} C_DIS #TOOL", "LIN_REL {Y 2} #BASE", "lin_rel {x 3} C_DIS"]
    path = read(tmp_path, source("\n".join(["LIN {X 10,Y 20,Z 30,A 90,B 0,C 180}", *steps])))
    np.testing.assert_allclose(path.position[1:] * 1e3, [[10, 21, 25], [10, 23, 25], [13, 23, 25]], atol=1e-12)


def test_two_bases_that_only_the_controller_knows(tmp_path: Path) -> None:
    lines = [f"$BASE=BASE_DATA[{k}]\nLIN {POSE}\n" for k in (7, 7, 8)]
    assert read(tmp_path, source("".join(lines[:2]))).setting.workobject is None
    with pytest.raises(ReadError, match="another frame") as caught:
        read(tmp_path, source("".join(lines)))
    assert caught.value.line == 7


def test_long_lines_do_not_take_longer_than_their_length(tmp_path: Path) -> None:
    wide = " " * 50_000
    relative = ("LIN_REL {X 1}%sx", "LIN_REL {X 1}%s#BASE%sx")
    for line in (*relative, "PTP%sx", "LIN {X 1}%sC_DIS%sx", "SLIN {X 1} WITH%sC_A%s"):
        with not_hanging(), contextlib.suppress(ReadError):
            assert len(read(tmp_path, source(f"LIN {POSE}\n{line.replace('%s', wide)}"))) > 0


def test_calls_and_labels(tmp_path: Path) -> None:
    path = read(tmp_path, source(f'SPINDLE_ON(8000,#CW,"x",TRUE)\nLAB1:\nMSG()\n$VEL.CP=3\nLIN {POSE}'))
    assert path.line.tolist() == [6] and path.feed.tolist() == [3.0]
    assert [e.word for e in path.events] == ['SPINDLE_ON(8000,#CW,"x",TRUE)', "MSG()"]


def test_a_cut_that_starts_where_nobody_knows(tmp_path: Path) -> None:
    """HOME is the controller's: a LIN from there is no line from the pose before; where the arm stands anyway it is."""
    with pytest.raises(ReadError, match=r"starts where PTP HOME \(line 3\) leads") as caught:
        read(tmp_path, source(f"LIN {POSE}\nPTP HOME\nLIN {POSE}"))
    assert caught.value.line == 4
    assert len(read(tmp_path, source(f"PTP HOME\nLIN {POSE}\nPTP HOME\nPTP {POSE}\nLIN {POSE}\nPTP HOME"))) == 3
    assert len(read(tmp_path, source(f"LIN {POSE}\nPTP $POS_ACT\nLIN {POSE}"))) == 2


def test_a_start_that_was_taught_can_be_given_as_numbers(shared: Path, tmp_path: Path) -> None:
    text = (shared / "data/cam/krl_waam/Hollow_Box_cleaned.src").read_text()
    path = read(tmp_path, text.replace("= $POS_ACT", "= {X 10,Y 20,Z 30,A 40,B 5,C 180}"))
    offsets = [[float(v) for v in found] for found in re.findall(r"OFFSET_POS = {X (\S+), Y (\S+), Z (\S+),", text)]
    cut = path.kind == 1
    np.testing.assert_allclose(path.position[cut][:-1] * 1e3 - [10, 20, 30], offsets, atol=1e-9)


def test_parts_and_two_programs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="END is missing"):
        read(tmp_path, KRL[: KRL.index("PTP XP2")], KRL_DAT)
    with pytest.raises(ReadError, match="two programs in one file"):
        read(tmp_path, KRL + KRL.replace("PART", "OTHER"), KRL_DAT)
    (tmp_path / "SUB.src").write_text(source(f"LIN {POSE}").replace("PART", "SUB"))
    assert len(read(tmp_path, source(f"LIN {POSE}\nSUB()"))) == 2
    (tmp_path / "SUB.src").write_text(source(f"LIN {POSE}").replace("PART()", "SUB(N:IN)"))
    with pytest.raises(ReadError, match=r"SUB\(\.\.\.\) is a subprogram with arguments"):
        read(tmp_path, source(f"LIN {POSE}\nSUB(1)"))
    with pytest.raises(ReadError, match=r"PART\.dat:2"):
        read(tmp_path, source("LIN XP1"), "DEFDAT PART\nDECL E6POS XP1={X 1,,Y 2}\nENDDAT\n")


def test_real_programs(shared: Path) -> None:
    folder = shared / "data/cam/krl_waam"
    path = read_toolpath(folder / "circle4_cleaned.src")
    with open(folder / "circle4_cleaned.gcode") as stream:  # the same circles, moved by the slicer's origin
        gcode = [re.match(r"G1 X(\S+) Y(\S+) E", line) for line in stream]
    points = np.array([[float(m[1]), float(m[2])] for m in gcode if m]) + np.array([22.122, 4.122])
    n = 40
    np.testing.assert_allclose(path.position[1 : n + 1, :2] * 1e3, points[:n], atol=2e-3)
    for name in ("line3_cleaned.src", "Hollow_Box_cleaned.src"):
        with pytest.raises(ReadError, match=r"\$POS_ACT"):
            read_toolpath(folder / name)
    assert len(read_toolpath(shared / "data/cam/robodk_posts/KUKA_KRC4_test_post.src")) == 9
    with pytest.raises(ReadError, match="END is missing"):
        read_toolpath(shared / "data/cam/robodk_posts/KUKA_KRC2_test_post.src")
