"""Fanuc .ls against an independent reader, robodk's angles and CONFIG as measured on ROBOGUIDE."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath

from tests.oracles import fanuc_reader
from tests.oracles.sample_programs import SPINDLE, WORKOBJECT, changed, on_the_spot, random_program, small, two_tools
from toolpaths.errors import WriteError
from toolpaths.files import read_back, write_program
from toolpaths.languages.fanuc.config import bits_of, config_texts, controller_joints, model_joints
from toolpaths.languages.fanuc.speeds import speed_texts


def written(program, tmp_path, name="part1.ls"):
    write_program(program, tmp_path / name)
    return fanuc_reader.read(tmp_path / name)


def rotation_of(values) -> np.ndarray:
    return np.array(robomath.Fanuc_2_Pose([0, 0, 0, *values]).rows)[:3, :3]


def orientation(move) -> np.ndarray:
    return rotation_of([move.position[k] for k in "WPR"])


@pytest.mark.parametrize("n", [3, 900, 5001])
def test_the_start_and_the_configuration(n, tmp_path):
    program = random_program(n, n)
    state = written(program, tmp_path)
    start, lines = state.moves[0], state.moves[1:]
    assert start.word == "J" and start.position == lines[0].position and [m.word for m in lines] == ["L"] * n
    assert [bits_of(" ".join(m.position["letters"])) for m in lines] == program.configuration.tolist()
    turns = np.array([m.position["turns"] for m in lines])
    degrees = np.degrees(program.joints[:, [0, 3, 5]])
    assert (np.abs(degrees - 360 * turns) <= 180 + 1e-3).all() and len(np.unique(turns)) == 3


def test_angles_are_those_of_robodk(tmp_path):
    """Next to gimbal lock, where robomath puts W to 0 within 1e-5 rad, only the rotations are the same."""
    program = random_program(400, 4)
    for move, r in zip(written(program, tmp_path).moves[1:], program.rotation, strict=True):
        expected = robomath.Pose_2_Fanuc(robomath.Mat([[*row, 0.0] for row in r.tolist()] + [[0, 0, 0, 1]]))[3:]
        locked = abs(abs(expected[1]) - 90) < 2e-3
        np.testing.assert_allclose(orientation(move), rotation_of(expected), atol=3e-5 if locked else 3e-7)
        if not locked:
            ours = [move.position[k] for k in "WPR"]
            np.testing.assert_allclose((np.subtract(ours, expected) + 180) % 360 - 180, 0, atol=2e-5)


# joints 1, 4, 5, 6 in deg and the CONFIG that ROBOGUIDE gives: turn 0 is open at +-180
CONFIGS = [
    ((0, 0, -90, 0), 1, "N U T, 0, 0, 0"), ((0, 0, 90, 0), 0, "F U T, 0, 0, 0"),
    ((0, 0, -90, 180), 1, "N U T, 0, 0, 1"), ((0, 0, -90, -180), 1, "N U T, 0, 0, -1"),
    ((0, 0, -90, 179.999), 1, "N U T, 0, 0, 0"), ((0, 0, -90, 179.9997), 1, "N U T, 0, 0, 1"),
    ((185, -302.548, -90, 539.9), 1, "N U T, 1, -1, 1"), ((-185, 540, 90, -541), 6, "F D B, -1, 2, -2"),
    ((-0.0, 1e-9, 0, 0), 5, "N U B, 0, 0, 0"),
]  # fmt: skip


@pytest.mark.parametrize(("angles", "bits", "expected"), CONFIGS)
def test_config(angles, bits, expected):
    q = np.radians([[angles[0], 10.0, 20.0, *angles[1:]]])
    assert config_texts(q, np.array([bits], dtype=np.int32)) == [expected]
    assert bits_of(expected.split(",")[0]) == bits


def test_joint_3_counts_from_the_horizontal():
    """Forearm pitch of the ROS URDF is q2 - q3, that of the controller -J3 (ROBOGUIDE)."""
    q = np.radians([1.0, 30.0, -20.0, 4.0, 5.0, 6.0])
    np.testing.assert_allclose(np.degrees(controller_joints(q)), [1, 30, -50, 4, 5, 6], atol=1e-12)
    np.testing.assert_allclose(model_joints(controller_joints(q)), q, atol=1e-15)


def test_frames_and_start(tmp_path):
    state = written(small(), tmp_path)
    frame, tool = state.moves[-1].frame, state.moves[-1].tool
    assert frame == pytest.approx([1500, -200, 800, 10, -20, 30], abs=1e-5)
    np.testing.assert_allclose(rotation_of(frame[3:]), WORKOBJECT[:3, :3], atol=2e-7)
    assert tool[:3] == [10, -20, 250]
    np.testing.assert_allclose(rotation_of(tool[3:]), SPINDLE.frame.rotation, atol=2e-7)
    assert [m.word for m in state.moves[:3]] == ["J", "J", "L"]
    assert [state.moves[0].position[f"J{i}"] for i in range(1, 7)] == [0, -100, 200, 0, 45, 0]
    assert "PAYLOAD to set: 35.000 kg" in state.remarks and "centre mm 0.0 5.0 120.0" in state.remarks
    np.testing.assert_allclose(np.degrees(read_back(tmp_path / "part1.ls").start_joints), [0, -100, 100, 0, 45, 0])
    found = write_program(small(), tmp_path / "again.ls").findings
    assert len(found) == 1 and "J3 of the start" in str(found[0])
    assert write_program(changed(small(), start_joints=None), tmp_path / "again.ls").findings == ()


def test_speeds_and_terminations(tmp_path):
    lines = [m for m in written(small(), tmp_path).moves if m.word == "L"]
    assert [m.speed for m in lines] == [f"{v}mm/sec" for v in (500, 500, 5, 20, 20, 20, 30, 500)]
    # corners of a right angle in a cut are stood at; the straight approach and the straight run are not
    assert [m.termination for m in lines] == ["FINE", "CNT100", "FINE", "FINE", "FINE", "CNT100", "FINE", "FINE"]


@pytest.mark.parametrize(
    ("speed", "text", "value"),
    [
        (0.02, "20mm/sec", 0.02), (0.07 / 60, "7cm/min", 0.07 / 60), (1.0, "1000mm/sec", 1.0),
        (0.2 / 60, "20cm/min", 0.2 / 60), (0.00118533, "2.8inch/min", 0.00118533), (1e-5, "0.1inch/min", 4.2333e-5),
    ],
)  # fmt: skip
def test_speed_units(speed, text, value):
    texts, said = speed_texts(np.array([speed, np.nan]))
    assert texts == [text, ""] and said[0] == pytest.approx(value, rel=1e-4) and np.isnan(said[1])


def test_every_usual_feed_is_near():
    feeds = np.arange(10, 60000, 10) / 60e3  # multiples of 10 mm/min are whole cm/min
    np.testing.assert_allclose(speed_texts(feeds)[1], feeds, rtol=6e-5)
    feeds = np.random.default_rng(1).uniform(130, 60000, 3000) / 60e3
    np.testing.assert_allclose(speed_texts(feeds)[1], feeds, rtol=0.0101)


def test_feeds_that_cannot_be_said(tmp_path):
    p = small()
    slow, fast = p.feed.copy(), p.feed.copy()
    slow[3], fast[3] = 0.000012, 2.001
    with pytest.raises(WriteError, match=r"pose 3 \(part.nc:13\): faster than 2000 mm/sec"):
        write_program(changed(p, feed=fast), tmp_path / "p.ls")
    found = write_program(changed(p, feed=slow), tmp_path / "p.ls").findings
    assert any("pose 3 (part.nc:13): the feed 0.72 mm/min becomes 0.1inch/min" in str(f) for f in found)


def test_cnt_keeps_the_corner_within_its_tolerance(tmp_path):
    """Zigzags of every angle: what CNT may leave out, from speed and deceleration, misses the corner by 0.01 mm."""
    n = 4001
    g = np.random.default_rng(7)
    heading = np.cumsum(g.normal(size=n) * 10.0 ** g.uniform(-4, 0.3, n))
    step = 10.0 ** g.uniform(-1, 1.5, n)[:, None] * np.column_stack((np.cos(heading), np.sin(heading), 0 * heading))
    p = random_program(n, 5)
    feed = np.full(n, 0.02)
    p = changed(p, position=np.cumsum(step, axis=0) * 1e-3, feed=feed, kind=np.ones(n, dtype=np.uint8))
    lines = written(p, tmp_path).moves[1:]
    cnt = np.array([0.0 if m.termination == "FINE" else float(m.termination[3:]) for m in lines])
    xyz = np.array([[m.position[k] for k in "XYZ"] for m in lines])
    d = np.diff(xyz, axis=0)
    length = np.linalg.norm(d, axis=1)
    reach = np.minimum(cnt[1:-1] / 100 * 0.5 * 0.4 * 20.0, 0.5 * np.minimum(length[:-1], length[1:]))
    turn = 0.5 * np.linalg.norm(np.diff(d / length[:, None], axis=0), axis=1)
    assert (0.5 * reach * turn <= 0.0101).all()
    assert set(cnt) == {0, 5, 10, 25, 50, 75, 100}


def test_turning_on_the_spot(tmp_path):
    state = written(on_the_spot(), tmp_path)
    found = [m.termination for m in state.moves[1:]]
    assert found == ["FINE", "FINE", "CNT100", "CNT100", "CNT100", "FINE", "FINE", "FINE"]


def test_tool_change_pauses_and_takes_the_other_tool(tmp_path):
    state = written(two_tools(), tmp_path)
    assert state.pauses == 1 and [m.tool[2] for m in state.moves[1:]] == [250, 250, 250, 300, 300, 300, 300, 300]
    assert [m.termination == "FINE" for m in state.moves[1:]][2:5] == [True, True, True]


def test_parts(tmp_path):
    """Positions count from 1 in every file; files end behind rapids where there are any."""
    p = random_program(10001, 8)
    files = write_program(p, tmp_path / "big.ls").files
    assert [f.name for f in files] == ["big.ls", *(f"big_{i:03d}.ls" for i in range(1, len(files)))]
    state = fanuc_reader.read(files[0])
    counts = {m.program: 0 for m in state.moves[1:]}
    for m in state.moves[1:]:
        counts[m.program] += 1
    assert sum(counts.values()) == 10001 and max(counts.values()) <= 5000
    ends = np.cumsum(list(counts.values()))[:-1]
    assert (p.kind[ends - 1] == 0).all()
    assert not any("ends in the cut" in str(f) for f in write_program(p, tmp_path / "big.ls").findings)
    p = changed(p, kind=np.ones(10001, dtype=np.uint8), feed=np.full(10001, 0.02))
    found = [str(f) for f in write_program(p, tmp_path / "big.ls").findings]
    assert any("pose 5000 (random.nc:5001) (and 1 more places): a part of the split program" in f for f in found)


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    with pytest.raises(WriteError, match="no spherical wrist: the CONFIG"):
        write_program(changed(p, configuration=None), tmp_path / "p.ls")


def test_line_numbers_of_five_digits(tmp_path):
    p = changed(random_program(5000, 3), comments=tuple((i % 5000, f"c{i}") for i in range(5100)))
    write_program(p, tmp_path / "p.ls")
    text = (tmp_path / "p.ls").read_text()
    assert "\n9999:" in text and "\n10000:" in text
    assert len(read_back(tmp_path / "p.ls").position) == 5000
