"""Fanuc .ls in place: a diff shows only poses; what is split, put in or straightened is listed."""

from __future__ import annotations

import difflib
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.sample_programs import SPINDLE
from tests.toolpaths.test_fanuc_reader import JOINTS, POSE, program
from toolpaths.errors import ReadError
from toolpaths.programs import Program
from toolpaths.programs.fanuc_filter import rewrite
from toolpaths.readers.fanuc import read

LINES = [
    "  !face ;mill",
    "J P[1] 20% FINE",
    "L P[1] 20mm/sec CNT10",
    "L P[2:edge] 20mm/sec CNT100",
    "  DO[1]=ON",
    "L P[3] 7cm/min FINE ACC50",
    "L P[2:edge] 20mm/sec CNT100",
    "L P[5] 5mm/sec FINE",
]


def record(n: int, x: float, y: float, z: float = 0.0, name: str = "") -> str:
    text = POSE.format(n=n, uf=1, ut=2, config="N U T, 0, 0, 1", x=x, y=y, z=z, w=-180, p=1.5, r=30.25, more="")
    return text.replace(f"P[{n}]", f'P[{n}:"{name}"]') if name else text


SOURCE = program(
    [x.replace(" ;", ",") for x in LINES],
    "".join(
        [record(1, 100, 0), record(2, 200, 0, name="edge"), record(3, 200, 50), record(4, 0, 0), record(5, 100, 50)]
    ),
)


def commanded(toolpath, index, shift, turn=(0, 0, 0), row=None) -> tuple[Program, np.ndarray]:
    """The toolpath's poses ``index``, moved by ``shift`` (m) and turned, as a program."""
    t = toolpath.take(index)
    known = np.isfinite(t.quaternion)
    t = replace(t, quaternion=np.where(known, t.quaternion, [1, 0, 0, 0]), position=np.nan_to_num(t.position, nan=0.5))
    rotation = Rotation.from_quat(t.quaternion, scalar_first=True)
    n = len(t)
    made = Program(
        name="P",
        position=t.position + shift,
        rotation=(Rotation.from_rotvec(turn) * rotation).as_matrix(),
        joints=np.zeros((n, 6)),
        feed=t.feed,
        kind=t.kind,
        tool=t.tool,
        line=t.line,
        tools={2: SPINDLE},
        workobject=np.eye(4),
        rapid_speed=1.0,
        configuration=np.zeros(n, dtype=np.int32),
        nominal_position=t.position,
        nominal_rotation=rotation.as_matrix(),
        source="test.ls",
    )
    return made, t.row if row is None else np.asarray(row)


def run(tmp_path, text, make, chord=1e-5):
    path = tmp_path / "test.ls"
    path.write_bytes(text.encode())
    t = read(path, "test.ls", chord)
    made, row = make(t)
    done = rewrite(text.encode(), made, row, path)
    return t, made, done


def again(tmp_path, done, chord=1e-5):
    path = tmp_path / "out.ls"
    path.write_bytes(done.text)
    made, row = commanded(read(path, "out.ls", chord), [0], 0.0)
    with pytest.raises(ReadError, match="compensated already") as caught:
        rewrite(done.text, made, row, path)
    assert caught.value.line == 5
    return read(path, "out.ls", chord)


@pytest.mark.parametrize("eol", ["\n", "\r\n"])
def test_nothing_changed_is_byte_identical(tmp_path, eol):
    text = SOURCE.replace("\n", eol)
    _, _, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 0.0))
    assert done.text == text.encode() and done.changes == ()


@pytest.mark.parametrize("eol", ["\n", "\r\n"])
def test_only_pose_numbers_change(tmp_path, eol):
    text = SOURCE.replace("\n", eol)
    shift = np.array([1.25e-4, -3.1e-5, 7.7e-5])
    t, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), shift, (1e-4, 2e-4, 0)))
    new = again(tmp_path, done)
    cut = t.kind == 1
    np.testing.assert_allclose(new.position[cut], made.position[cut], atol=0.51e-7)
    np.testing.assert_array_equal(new.position[~cut], t.position[~cut])
    got = Rotation.from_quat(new.quaternion, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got[cut], made.rotation[cut], atol=3e-7)
    for name in ("kind", "feed", "tool"):
        np.testing.assert_array_equal(getattr(new, name), getattr(t, name))
    assert new.setting.configuration.tolist() == t.setting.configuration.tolist()
    lines = list(difflib.ndiff(text.splitlines(), done.text.decode().splitlines()))
    gone = [x[2:] for x in lines if x.startswith("- ")]
    came = [x[2:] for x in lines if x.startswith("+ ")]
    # P[3], P[5]: two lines each; P[1] (also a joint move's) and P[2] (used twice) are split: three lines name new ones
    assert len(gone) == 2 * 2 + 3
    assert [x for x in came if x.startswith("    :")] == ["    :  !compensated by ;", "    :  !toolpath-compensator ;"]
    assert [x.split(":", 1)[1] for x in came if "L P" in x] == [
        "L P[6] 20mm/sec CNT10 ;",
        "L P[7] 20mm/sec CNT100 ;",
        "L P[8] 20mm/sec CNT100 ;",
    ]
    assert [len(x) for x in gone if x[0] == "\t"] == [len(x) for x in came if x[0] == "\t"][:4]
    assert [f.what.split(",")[0] for f in done.changes] == ["a position that other moves use"] * 3
    assert done.text.count(eol.encode()) == done.text.count(b"\n") and str(done.changes[0]).startswith(
        "warning: test.ls:7"
    )


def test_poses_put_in(tmp_path):
    """Two poses between P[2] and P[3]; only they are new, in a line like P[3]'s without a stop."""

    def make(t):
        at = np.arange(len(t))
        made, row = commanded(t, [*at[:4], 4 - 1, 4 - 1, *at[4:]], 0.0)
        position = made.position.copy()
        k = int(np.flatnonzero(row == 3)[0])
        position[k : k + 2] = position[k - 1] + np.array([[0.0, 0.01, 0.0], [1e-5, 0.02, 0.0]])
        rows = row.copy()
        rows[k : k + 2] = [2.25, 2.5]
        return replace(made, position=position), rows

    t, _, done = run(tmp_path, SOURCE, make)
    new = again(tmp_path, done)
    assert len(new) == len(t) + 2
    np.testing.assert_allclose(new.position[3:5], [[0.2, 0.01, 0], [0.20001, 0.02, 0]], atol=1e-9)
    np.testing.assert_allclose(np.delete(new.position, [3, 4], axis=0), t.position)
    text = done.text.decode()
    assert (
        "    :L P[6] 7cm/min CNT100 ACC50 ;\n    :L P[7] 7cm/min CNT100 ACC50 ;\n   6:L P[3] 7cm/min FINE ACC50 ;\n"
        in text
    )
    assert len(text) - len(SOURCE) == len(
        "".join(x[2:] + "\n" for x in difflib.ndiff(SOURCE.splitlines(), text.splitlines()) if x.startswith("+ "))
    )
    assert [(f.what, f.count) for f in done.changes] == [("poses were put in", 2)]


def test_an_arc_becomes_lines_or_stays(tmp_path):
    text = program(
        ["L P[1] 20mm/sec FINE", "C P[2]\n    :  P[3:end] 20mm/sec CNT50", "L P[4] 9mm/sec FINE"],
        "".join([record(1, 0, 0), record(2, 10, 10), record(3, 20, 0), record(4, 30, 0)]),
    )
    _, _, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 0.0), 1e-4)
    assert done.text == text.encode()
    shift = np.array([0.0, 0.0, 1e-4])
    t, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), shift), 1e-4)
    new = again(tmp_path, done, 1e-4)
    np.testing.assert_allclose(new.position, made.position, atol=0.51e-7)
    out = done.text.decode()
    assert "C P" not in out and "\n   2:L P[3:end] 20mm/sec CNT50 ;\n" in out and "    :L P[5] 20mm/sec CNT100 ;" in out
    assert [f.what for f in done.changes] == ["an arc became straight lines"] and len(new) == len(t) > 5


def test_a_straight_move_to_joint_angles(tmp_path):
    text = program(["L P[1] 20mm/sec FINE", "L P[3:home] 20mm/sec CNT50"], record(1, 0, 0) + JOINTS)

    def make(t):
        made, row = commanded(
            replace(
                t,
                position=np.nan_to_num(t.position, nan=0.3),
                quaternion=np.where(np.isnan(t.quaternion), [1, 0, 0, 0], t.quaternion),
            ),
            [0, 1],
            0.0,
        )
        return replace(made, joints=np.radians([[0] * 6, [0, 0, 0, 0, 5, 181]])), row

    _, _, done = run(tmp_path, text, make)
    new = again(tmp_path, done)
    np.testing.assert_allclose(new.position[1], 0.3)
    assert "CONFIG : 'F U T, 0, 0, 1'" in done.text.decode() and new.setting.joints == {}


def test_real_program(shared, tmp_path):
    path = tmp_path / "Fanuc_R30iA_test_post.ls"
    data = (shared / "data" / "cam" / "robodk_posts" / path.name).read_bytes()
    path.write_bytes(data)
    for call in ("TCP_On", "TCP_Off"):
        (tmp_path / f"{call}.LS").write_text(program(["  DO[1]=ON"]))
    t = read(path, path.name, 1e-5)
    index = np.flatnonzero(t.kind == 1)
    made, row = commanded(t, index, np.zeros(3))
    assert rewrite(data, made, row, path).text == data
    made, row = commanded(t, index, np.array([1e-4, 0, 0]))
    done = rewrite(data, made, row, path)
    assert done.changes == ()
    lines = [x for x in difflib.ndiff(data.decode().splitlines(), done.text.decode().splitlines()) if x[0] in "+-"]
    assert len(lines) == 2 + 2 * 8 and all("X =" in x or "!" in x for x in lines)
    path.write_bytes(done.text)
    np.testing.assert_allclose(read(path, "x", 1e-5).position[1:], made.position, atol=0.51e-7)
