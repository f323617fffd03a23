"""Fanuc .ls in: real programs, what is read, and what is refused in which line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.oracles.patience import not_hanging
from tests.oracles.sample_programs import random_program
from toolpaths.errors import ReadError
from toolpaths.files import write_program
from toolpaths.languages.fanuc.reader import read
from toolpaths.languages.fanuc.speeds import speed_texts
from toolpaths.writing.marker import refuse_compensated_remarks

POSE = """P[{n}]{{
   GP1:
	UF : {uf}, UT : {ut},		CONFIG : '{config}',
	X = {x:9.3f}  mm,	Y = {y:9.3f}  mm,	Z = {z:9.3f}  mm,
	W = {w:9.3f} deg,	P = {p:9.3f} deg,	R = {r:9.3f} deg{more}
}};
"""
JOINTS = """P[3:"home"]{
   GP1:
	UF : 1, UT : 2,
	J1=     0.000 deg,	J2=    30.000 deg,	J3=   -20.000 deg,
	J4=    10.000 deg,	J5=   -90.000 deg,	J6=     5.000 deg
};
"""


def pose(n: int, x: float, y: float = 0.0, z: float = 0.0, uf="1", ut="2", w=-180.0, more="") -> str:
    return POSE.format(n=n, uf=uf, ut=ut, config="N U T, 0, 0, 0", x=x, y=y, z=z, w=w, p=0.0, r=30.0, more=more)


def program(lines: list[str], records: str = "") -> str:
    body = "".join(f"{i:4d}:{line} ;\n" for i, line in enumerate(lines, 1))
    return f'/PROG  TEST\n/ATTR\nCOMMENT = "x";\n/MN\n{body}/POS\n{records}/END\n'


def read_text(tmp_path: Path, text: str | bytes, chord: float = 1e-5):
    path = tmp_path / "test.ls"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read(path, "test.ls", chord)


def plain(*lines: str) -> str:
    return program(list(lines), pose(1, 100) + pose(2, 200, 50) + JOINTS + pose(4, 300, 0))


def test_moves_and_what_they_carry(tmp_path):
    lines = [
        "  UFRAME_NUM=1",
        "  UTOOL_NUM=2",
        "J P[3:home] 20% FINE",
        "J P[1] 50% CNT50",
        "  !face 1",
        "  DO[1]=ON",
        "L P[2] 20mm/sec FINE",
        "L P[4] 7cm/min CNT100 ACC50",
        "L P[1] 2.8inch/min CR5",
        "L P[2] max_speed CNT100",
        "L P[4] 3.0sec CNT10 PTH",
    ]
    t = read_text(tmp_path, plain(*lines))
    assert t.language == "fanuc" and t.line.tolist() == [7, 8, 11, 12, 13, 14, 15]
    np.testing.assert_allclose(t.position[1:, 0], [0.1, 0.2, 0.3, 0.1, 0.2, 0.3])
    assert np.isnan(t.position[0]).all() and t.kind.tolist() == [0, 0, 1, 1, 1, 0, 1]
    np.testing.assert_allclose(t.feed[2:5], [0.02, 0.07 / 60, 2.8 * 0.0254 / 60])
    assert np.isnan(t.feed[[0, 1, 5, 6]]).all()
    np.testing.assert_allclose(t.setting.zones, [0, np.nan, 0, np.nan, 0.005, np.nan, np.nan])
    assert t.setting.configuration.tolist() == [-1] + [1] * 6
    np.testing.assert_allclose(np.degrees(t.setting.joints[0]), [0, 30, 10, 10, -90, 5])
    assert t.setting.workobject is None and t.setting.tools == {} and t.tool.tolist() == [2] * 7
    expected = Rotation.from_euler("xyz", [-180, 0, 30], degrees=True)
    got = Rotation.from_quat(t.quaternion[1], scalar_first=True)
    assert (expected.inv() * got).magnitude() < 1e-12
    np.testing.assert_allclose(t.axis[1], -expected.as_matrix()[:, 2], atol=1e-12)
    assert [(e.word, e.pose, e.line) for e in t.events] == [("face 1", 2, 9), ("DO[1]=ON", 2, 10)]


def test_frames_from_constants(tmp_path):
    def frame(word: str, number: int, values: str) -> list[str]:
        elements = [f"  PR[9,{i}]={v}" for i, v in enumerate(values.split(), 1)]
        return ["  PR[9]=LPOS", *elements, f"  {word}[{number}]=PR[9]", f"  {word}_NUM={number}"]

    lines = [
        *frame("UFRAME", 1, "1500.0 (-200.5) 800. 10.0 (-20.0) 30.0"),
        *frame("UTOOL", 2, "10.0 -20.0 250.0 0 30 0"),
    ]
    t = read_text(tmp_path, plain(*lines, "L P[1] 20mm/sec FINE"))
    expected = Rotation.from_euler("xyz", [10, -20, 30], degrees=True).as_matrix()
    np.testing.assert_allclose(t.setting.workobject.rotation, expected, atol=1e-12)
    np.testing.assert_allclose(t.setting.workobject.origin, [1.5, -0.2005, 0.8])
    np.testing.assert_allclose(t.setting.tools[2].frame.origin, [0.01, -0.02, 0.25])
    expected = Rotation.from_euler("y", 30, degrees=True).as_matrix()
    np.testing.assert_allclose(t.setting.tools[2].frame.rotation, expected, atol=1e-12)


def test_an_arc(tmp_path):
    text = program(
        ["L P[1] 20mm/sec FINE", "C P[2]\n    :  P[4] 20mm/sec CNT100"], pose(1, 0) + pose(2, 10, 10) + pose(4, 20)
    )
    t = read_text(tmp_path, text)
    np.testing.assert_allclose(np.hypot(t.position[:, 0] - 0.01, t.position[:, 1]), 0.01, atol=1e-12)
    assert len(t) > 20 and t.position[-1, 0] == 0.02 and t.row[-1] == 1 and (np.diff(t.row) > 0).all()
    assert set(t.line.tolist()) == {5, 6}


def test_frame_0_is_the_base_and_other_groups_pass(tmp_path):
    more = "\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1=   100.000  mm"
    t = read_text(tmp_path, program(["L P[1] 5mm/sec FINE"], pose(1, 7, uf="0", ut="F", more=more)))
    np.testing.assert_array_equal(t.setting.workobject.matrix, np.eye(4))
    assert t.position[0, 0] == 0.007
    t = read_text(tmp_path, program(["L P[1] 5mm/sec FINE"], pose(1, 7, more=",\n\tE1=   12.000 mm")))
    assert t.position[0, 0] == 0.007


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("L PR[1] 20mm/sec FINE", "not known before"),
        ("L P[R[1]] 20mm/sec FINE", "not known before"),
        ("L P[1] R[2:v]mm/sec FINE", "the speed R[2:v] is not known before"),
        ("L P[1] 20mm/sec CNT R[1]", "not known before"),
        ("L P[1] 20mm/sec CNT101", "CNT101 is above 100"),
        ("L P[1] 20mm/sec FINE Offset,PR[1]", "option 'Offset"),
        ("L P[1] 20mm/sec FINE Tool_Offset,PR[1]", "option"),
        ("L P[1] 20mm/sec FINE Skip,LBL[1]", "option"),
        ("L P[1] 20mm/sec FINE INC", "option"),
        ("L P[1] 20mm/sec FINE Wjnt", "option"),
        ("A P[1] 20mm/sec FINE", "not known before"),
        ("L P[9] 20mm/sec FINE", "P[9] is not in /POS"),
        ("L P[1] 0mm/sec FINE", "not above 0"),
        ("L P[1] P[2] 20mm/sec FINE", "two positions behind C"),
        ("C P[1] 20mm/sec FINE", "two positions behind C"),
        ("C P[3] P[1] 20mm/sec FINE", "joint angles"),
        ("L P[1] 1.2.3mm/sec FINE", "not a number"),
        ("  JMP LBL[1]", "'JMP LBL[1]' is not read"),
        ("  IF R[1]=1,JMP LBL[1]", "an IF decides about 'JMP LBL[1]'"),
        ("  IF (R[1:a,b]=1) THEN", "an IF (line 6) decides about 'L P[2] 20mm/sec FINE'"),
        ("  IF DI[1]=ON,UFRAME_NUM=2", "an IF decides about 'UFRAME_NUM=2'"),
        ("  ENDIF", "'ENDIF' is not read"),
        ("  FOR R[1]=1 TO 5", "is not read"),
        ("  SELECT R[1]=1,CALL A", "is not read"),
        ("  WAIT DI[1]=ON TIMEOUT,LBL[1]", "is not read"),
        ("J P[1] 50% FINE Skip,LBL[1]", "option 'Skip"),
        ("J PR[1] 50% FINE Skip,LBL[1]", "not known before"),
        ("J PR[1:home] 50% FINE", "starts where 'J PR[1:home] 50% FINE' (line 6) leads"),
        ("J P[1] 50% FINE Offset,PR[1]", "starts where 'J P[1] 50% FINE Offset,PR[1]' (line 6) leads"),
        ("L P[1] R[2]mm/sec FINE TB .10sec,CALL A", "the speed R[2] is not known"),
        ("L P[1] 20mm/sec FINE TB .10sec,JMP LBL[1]", "option 'TB"),
        ("  RUN OTHER", "is not read"),
        ("  UFRAME[1]=PR[4]", "PR[4] is not known"),
        ("  $MCR.$GENOVERRIDE=5", "not read"),
        ("  UFRAME_NUM=R[1]", "is not read"),
        ("  UFRAME_NUM=5", "UFRAME_NUM is 5"),
        ("  UTOOL[1]=PR[1]", "PR[1] is not known"),
        ("  PR[1,1]=1.2.3", "not a number"),
    ],
)
def test_refused_by_line(tmp_path, line, word):
    with pytest.raises(ReadError) as caught:
        read_text(tmp_path, plain("L P[1] 20mm/sec FINE", line, "L P[2] 20mm/sec FINE"))
    later = ("UFRAME_NUM=5", "THEN", "J PR[1:home]", "J P[1] 50% FINE Offset")
    assert caught.value.line == (7 if any(w in line for w in later) else 6) and word in str(caught.value)


MISTAKES = [
    ("", "empty"),
    (b"\x00\x01", "binary"),
    ("G0 X1\nG1 Y2 F100\n", "no /PROG: not a Fanuc program"),
    (plain("L P[1] 5mm/sec FINE").replace("/END\n", ""), "no /END"),
    ("<<<<<<< a\n/PROG\n", "merge-conflict"),
    (plain("L P[1] 5mm/sec FINE") * 2, "two programs in one file"),
    (plain("  UFRAME_NUM=1"), "no move"),
    (plain("L P[1] 5mm/sec FINE").replace("CONFIG : 'N", "CONFIG : 'X"), "CONFIG 'X U T'"),
    (plain("L P[1] 5mm/sec FINE").replace("  100.000", "********"), "never taught"),
    (plain("L P[1] 5mm/sec FINE") + pose(5, 1), "text behind /END"),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2) * 2), "P[1] stands twice"),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2) + "what is this\n"), "'what is this' is no position"),
    (
        program(["L P[1] 5mm/sec FINE", "L P[2] 5mm/sec FINE"], pose(1, 2) + pose(2, 1, uf="3", ut="F")),
        "UFRAME_NUM is 1",
    ),
    (program(["L P[1] 5mm/sec FINE"], pose(1, 2e6)), "beyond 1000 m"),
    (program(["L P[1] 5mm/sec FINE"]).replace(" ;", ""), "without ';'"),
    (
        plain("  UFRAME_NUM=1", "L P[1] 5mm/sec FINE", "  UFRAME_NUM=6", "J P[5] 5% FINE").replace(
            "/END", pose(5, 3, uf="6") + "/END"
        ),
        "frames 1 and 6 are not in the file",
    ),
]


MISTAKES += [
    (program(["L P[1] 5mm/sec FINE"], "P[1]{\n" * 100_000), "is no position"),
    (program(["  PR[9,1]=" + " " * 200_000 + "x"]), "no move"),
    (program(["L P[1]" + " " * 200_000 + "5mm/sec ACC5" + " " * 200_000 + "x"]), "not known before"),
    (program(["  !compensated by" + " " * 200_000 + "x"]), "no move"),
]


@pytest.mark.parametrize(("text", "word"), MISTAKES)
def test_mistakes(tmp_path, text, word):
    with not_hanging(), pytest.raises(ReadError, match=r"test\.ls") as caught:
        read_text(tmp_path, text)
    assert word in str(caught.value)


@pytest.mark.parametrize(
    ("name", "poses", "cutting"),
    [("robodk/Program.LS", 6, 4), ("robodk_posts/Fanuc_R30iA_test_post.ls", 9, 8)],
)
def test_real_programs(shared, tmp_path, name, poses, cutting):
    path = shared / "data" / "cam" / name
    t = read(path, path.name, 1e-5)
    assert len(t) == poses and t.kind.sum() == cutting and set(t.tool.tolist()) == {9}
    assert sum(e.word.startswith("CALL ") for e in t.events) == (1 if poses == 6 else 2)
    if poses == 9:
        np.testing.assert_allclose(t.position[1:3], [[0.2, 0.25, 0.348735], [0.2, 0.2, 0.262132]])
        np.testing.assert_allclose(t.setting.workobject.origin, [0.807767, -0.9637, 0.041479])
        np.testing.assert_allclose(np.degrees(t.setting.joints[0])[:3], [-46.184, -6.775, -20.549 - 6.775])
        np.testing.assert_allclose(t.feed[1:], 0.5)


def test_what_is_written_is_read(tmp_path):
    p = random_program(3000, 6)
    write_program(p, tmp_path / "p.ls")
    text = (tmp_path / "p.ls").read_bytes()
    with pytest.raises(ReadError, match="compensated already") as caught:
        refuse_compensated_remarks(text, "p.ls")
    assert caught.value.line == 22
    t = read_text(tmp_path, text)
    np.testing.assert_allclose(t.position[1:], p.position, atol=0.51e-7)
    np.testing.assert_allclose(t.setting.workobject.matrix, p.workobject.matrix, atol=2e-7)
    np.testing.assert_allclose(t.setting.tools[9].frame.rotation, p.tools[1].frame.rotation, atol=2e-7)
    assert t.setting.configuration[1:].tolist() == p.configuration.tolist()
    speed = np.where(p.kind == 1, p.feed, p.rapid_speed)
    np.testing.assert_allclose(t.feed[1:], speed_texts(speed)[1], rtol=1e-12)
    got = Rotation.from_quat(t.quaternion[1:], scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, p.rotation, atol=3e-7)


PIECES = [
    *plain("J P[3] 5% FINE", "C P[1]  P[4] 7cm/min CNT5", "  PR[9,1]=(-1.5)", "  UTOOL[2]=PR[9]").split(),
    "\n",
    "/POS",
    "/MN",
    "/END",
    ";",
    "P[1]{",
    "};",
    "9" * 400,
    "-",
    "********",
]


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_only_refusals_escape(tmp_path, data):
    whole = plain("J P[3] 5% FINE", "J P[4] 5% FINE", "C P[1]  P[2] 7cm/min CNT5", "L P[4] 5mm/sec FINE")
    at, to = sorted(data.draw(st.tuples(*[st.integers(0, len(whole))] * 2)))
    pieces = data.draw(st.lists(st.sampled_from(PIECES), max_size=12))
    glue = data.draw(st.sampled_from(["", " ", "\n"]))
    for text in (whole[:at] + glue.join(pieces) + whole[to:], glue.join(pieces), whole[:at]):
        try:
            t = read_text(tmp_path, text)
        except ReadError:
            continue
        assert len(t) > 0 and (np.diff(t.row) > 0).all()
        known = np.isfinite(t.position[:, 0])
        np.testing.assert_allclose(np.linalg.norm(t.axis[known], axis=1), 1, atol=1e-12)
