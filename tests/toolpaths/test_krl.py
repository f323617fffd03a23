"""KRL against an independent reader, robodk's angles and hand-computed Status and Turn."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath

from tests.oracles import krl_reader
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.frame import Frame
from toolpaths.languages.krl.writer import status_and_turn
from toolpaths.tool_frame import ToolFrame


def written(program, tmp_path, name="part1.src"):
    write_program(program, tmp_path / name)
    return krl_reader.read(tmp_path / name)


def rotation_of(frame: dict) -> np.ndarray:
    return np.array(robomath.KUKA_2_Pose([0, 0, 0, frame["A"], frame["B"], frame["C"]]).rows)[:3, :3]


@pytest.mark.parametrize("n", [3, 900, 5000, 5001, 11000])
def test_what_a_controller_reads(n, tmp_path):
    program = random_program(n, n)
    state = written(program, tmp_path)
    start, lines = state.moves[0], state.moves[1:]
    assert start.word == "PTP" and [m.word for m in lines] == ["LIN"] * n
    np.testing.assert_allclose(list(start.target.values()), np.degrees(program.joints[0]), atol=0.51e-6)
    xyz = [[m.target[k] for k in "XYZ"] for m in lines]
    np.testing.assert_allclose(xyz, program.position * 1e3, atol=0.51e-4)
    np.testing.assert_allclose([rotation_of(m.target) for m in lines], program.rotation, atol=3e-7)
    speed = np.where(program.kind == 1, program.feed, 0.5)
    np.testing.assert_allclose([m.state["$VEL.CP"] for m in lines], speed, atol=0.51e-8)
    turn = np.array([int(m.target["T"]) for m in lines])
    for axis in range(6):
        np.testing.assert_array_equal(turn >> axis & 1, program.joints[:, axis] < 0)


def test_status_and_turn_by_hand():
    """KSS 8.3: S bit 0 overhead area, 1 axis 3 bent forward, 2 axis 5 negative; T bit i-1 axis i < 0."""
    degrees = np.array([
        [0.0, -90.0, 90.0, 0.0, 0.0, 0.0],  # KUKA's home: only axis 2 negative
        [-10.0, -60.0, 80.0, 20.0, 30.0, -40.0],  # S 2, T 35 of many taught points
        [10.0, -60.0, 80.0, 20.0, -30.0, -40.0],  # S 6, T 50
        [-0.0, -1e-9, -5e-7, -6e-7, 1.0, 1.0],  # what prints as 0 is not negative
        [-1.0, -1.0, -1.0, -1.0, -1.0, -1.0],
    ])  # fmt: skip
    branch = np.array([0, 0, 1, 6, 7], dtype=np.int32)
    status, turn = status_and_turn(np.radians(degrees), branch)
    assert turn.tolist() == [2, 35, 50, 8, 63]
    assert status.tolist() == [2, 2, 6, 1, 5]


def test_frames(tmp_path):
    state = written(small(), tmp_path)
    base, tool = state.values["$BASE"], state.values["$TOOL"]
    assert [base[k] for k in "XYZABC"] == pytest.approx([1500, -200, 800, 30, -20, 10], abs=1e-5)
    assert [tool[k] for k in "XYZ"] == [10, -20, 250]
    np.testing.assert_allclose(rotation_of(tool), SPINDLE.frame.rotation, atol=2e-7)
    load = state.values["$LOAD"]
    assert load["M"] == 35 and [load["CM"][k] for k in "XYZ"] == [0, 5, 120]
    assert [m.word for m in state.moves[:2]] == ["PTP", "PTP"]
    assert list(state.moves[0].target.values()) == [0, -100, 100, 0, 45, 0]


def test_speed_and_rounding_hold_where_they_stand(tmp_path):
    state = written(small(), tmp_path)
    lines = [m for m in state.moves if m.word == "LIN"]
    assert [m.state["$VEL.CP"] for m in lines] == [0.5, 0.5, 0.005, 0.02, 0.02, 0.02, 0.03, 0.5]
    assert [m.approximate for m in lines] == ["", "C_DIS", "C_DIS", "C_DIS", "", "C_DIS", "C_DIS", ""]
    # the straight approach ends at half the 5 mm, corners at 0.01 mm, exact pose and both ends stop
    assert [m.state.get("$APO.CDIS") for m in lines if m.approximate] == [1, 0.01, 0.01, 0.005, 0.01]


def test_approximation_is_never_more_than_half_a_segment(tmp_path):
    p = random_program(6000, 5)
    scale = 10.0 ** np.random.default_rng(1).uniform(-3, 1, 6000)
    step = np.random.default_rng(2).normal(size=(6000, 3)) * scale[:, None] * 1e-3
    state = written(changed(p, position=np.cumsum(step, axis=0)), tmp_path)
    lines = state.moves[1:]
    at = np.array([[m.target[k] for k in "XYZ"] for m in lines])
    length = np.linalg.norm(np.diff(at, axis=0), axis=1)
    reach = np.array([m.state["$APO.CDIS"] if m.approximate == "C_DIS" else 0.0 for m in lines])
    assert (reach[1:-1] <= 0.5 * np.minimum(length[:-1], length[1:]) + 1.5e-4).all()
    assert (reach > 0).mean() > 0.5 and len(set(reach)) >= 6


def test_turning_on_the_spot_uses_the_orientation(tmp_path):
    p = random_program(8, 1, lock=False)
    turns = np.radians([0, 0, 0.1, 0.2, 0.3, 0.8, 1.3, 1.3])
    c, s, o, i = np.cos(turns), np.sin(turns), np.zeros(8), np.ones(8)
    rotation = np.array([[c, o, s], [o, i, o], [-s, o, c]]).transpose(2, 0, 1)
    xyz = np.array([[0, 0, 0]] + [[5, 0, 0]] * 6 + [[9, 0, 0]]) * 1e-3
    state = written(changed(p, position=xyz, rotation=rotation), tmp_path)
    assert [m.approximate for m in state.moves[1:]] == ["", "", *["C_ORI"] * 4, "", ""]
    assert [m.state["$APO.CORI"] for m in state.moves[3:7]] == [0.03, 0.03, 0.03, 0.1]


def test_tool_change_halts_and_takes_the_other_tool(tmp_path):
    other = ToolFrame("b", Frame(np.eye(3), np.array([0, 0, 0.3])))
    p = random_program(7, 2)
    p = changed(p, tools={1: SPINDLE, 2: other}, tool=np.array([1, 1, 1, 2, 2, 2, 2], dtype=np.int32))
    state = written(p, tmp_path)
    assert state.halts == 1
    assert [m.state["$TOOL"]["Z"] for m in state.moves[1:]] == [250, 250, 250, 300, 300, 300, 300]
    assert [m.approximate for m in state.moves[1:]] == ["", "C_DIS", "", "", "C_DIS", "C_DIS", ""]


def test_parts_start_alone(tmp_path):
    """Each part of a split program states speed and rounding before it needs them."""
    files = write_program(random_program(10001, 8), tmp_path / "big.src").files
    assert [f.name for f in files] == ["big.src", "big_001.src", "big_002.src", "big_003.src"]
    part = krl_reader.read(files[2])
    assert len(part.moves) == 5000
    assert "$VEL.CP" in part.moves[0].state and "$APO.CDIS" in part.moves[0].state


@pytest.mark.parametrize("stem", ["1110_wall", "a-b", "a" * 25, "circ", "größe", "a b"])
def test_names(stem, tmp_path):
    with pytest.raises(WriteError, match="is no KRL name"):
        write_program(small(), tmp_path / f"{stem}.src")
    assert list(tmp_path.iterdir()) == []


def test_longest_names(tmp_path):
    written(small(), tmp_path, "a" * 24 + ".src")
    with pytest.raises(WriteError, match="at most 20 characters"):
        write_program(random_program(5001, 1), tmp_path / ("a" * 21 + ".src"))


def test_speed_that_kuka_does_not_take(tmp_path):
    p = small()
    feed = p.feed.copy()
    feed[3] = 3.5
    with pytest.raises(WriteError, match=r"pose 3 \(part.nc:13\): faster than 3 m/s"):
        write_program(changed(p, feed=feed), tmp_path / "p.src")
    with pytest.raises(WriteError, match="rapid speed: faster than 3 m/s"):
        write_program(changed(p, rapid_speed=4.0), tmp_path / "p.src")


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    state = written(changed(p, configuration=None), tmp_path)
    assert all("S" not in m.target and "T" not in m.target for m in state.moves)
    with pytest.raises(WriteError, match="7 joints"):
        write_program(changed(p, joints=np.zeros((5, 7))), tmp_path / "seven.src")


def test_large_programs_are_warned_about(tmp_path):
    found = write_program(random_program(50000, 1), tmp_path / "big.src").findings
    assert "5 MB of KRL: a KR C4 holds 4 to 8 MB" not in str(found) and "MB of KRL" in str(found[0])


def test_comments_cannot_break_out(tmp_path):
    p = changed(small(), comments=((3, "x\r\nHALT"),), source="a\nHALT")
    assert written(p, tmp_path).halts == 0
