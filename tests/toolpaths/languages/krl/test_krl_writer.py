"""KRL against an independent reader, robodk's angles and hand-computed Status and Turn."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath

from tests.oracles import krl_reader
from tests.oracles.sample_programs import SPINDLE, changed, on_the_spot, random_program, small, two_tools
from toolpaths.files import write_program
from toolpaths.languages.krl.writer import status_and_turn


def written(program, tmp_path, name="part1.src"):
    write_program(program, tmp_path / name)
    return krl_reader.read(tmp_path / name)


def rotation_of(frame: dict) -> np.ndarray:
    return np.array(robomath.KUKA_2_Pose([0, 0, 0, frame["A"], frame["B"], frame["C"]]).rows)[:3, :3]


@pytest.mark.parametrize("n", [3, 900, 5001])
def test_the_start_and_the_turn_bits(n, tmp_path):
    program = random_program(n, n)
    state = written(program, tmp_path)
    start, lines = state.moves[0], state.moves[1:]
    assert start.word == "PTP" and [m.word for m in lines] == ["LIN"] * n
    np.testing.assert_allclose(list(start.target.values()), np.degrees(program.joints[0]), atol=0.51e-6)
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


def test_turning_on_the_spot_uses_the_orientation(tmp_path):
    state = written(on_the_spot(), tmp_path)
    assert [m.approximate for m in state.moves[1:]] == ["", "", *["C_ORI"] * 4, "", ""]
    assert [m.state["$APO.CORI"] for m in state.moves[3:7]] == [0.03, 0.03, 0.03, 0.1]


def test_tool_change_halts_and_takes_the_other_tool(tmp_path):
    state = written(two_tools(), tmp_path)
    assert state.halts == 1
    assert [m.state["$TOOL"]["Z"] for m in state.moves[1:]] == [250, 250, 250, 300, 300, 300, 300, 300]
    assert [m.approximate for m in state.moves[1:]] == ["", "C_DIS", "", "", "", "C_DIS", "C_DIS", ""]


def test_parts_start_alone(tmp_path):
    """Each part of a split program states speed and rounding before it needs them."""
    files = write_program(random_program(10001, 8), tmp_path / "big.src").files
    assert [f.name for f in files] == ["big.src", "big_001.src", "big_002.src", "big_003.src"]
    part = krl_reader.read(files[2])
    assert len(part.moves) == 5000
    assert "$VEL.CP" in part.moves[0].state and "$APO.CDIS" in part.moves[0].state


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    state = written(changed(p, configuration=None), tmp_path)
    assert all("S" not in m.target and "T" not in m.target for m in state.moves)


def test_large_programs_are_warned_about(tmp_path):
    found = write_program(random_program(50000, 1), tmp_path / "big.src").findings
    assert "5 MB of KRL: a KR C4 holds 4 to 8 MB" not in str(found) and "MB of KRL" in str(found[0])
