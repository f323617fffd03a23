"""INFORM against an independent reader, robodk's angles and hand-computed RCONF."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath

from tests.oracles import inform_reader
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small, two_tools
from tests.oracles.vendor_moves import in_base
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.frame import Frame
from toolpaths.languages.inform.moves import rconf


def written(program, folder, name="part1.jbi"):
    write_program(program, folder / name)
    return inform_reader.read(folder / name)


def lines_of(run):
    return [m for m in run.moves if m.word == "MOVL"]


def motoman(position) -> np.ndarray:
    return np.array(robomath.Motoman_2_Pose([*position.xyz, *position.angles]).rows)


@pytest.mark.parametrize("n", [1, 3, 900, 5000, 5001, 11000])
def test_what_stands_beside_the_poses(n, tmp_path):
    program = random_program(n, n)
    run = written(program, tmp_path)
    start, lines = run.moves[0], run.moves[1:]
    assert start.word == "MOVJ" and [m.word for m in lines] == ["MOVL"] * n
    poses, wanted = np.array([motoman(m.position) for m in lines]), in_base(program)
    # 0.00005 deg on each of three angles that are at right angles to each other
    np.testing.assert_allclose(poses[:, :3, :3], wanted[:, :3, :3], atol=1.55e-6)
    own = np.array([inform_reader.pose(m.position) for m in lines])
    np.testing.assert_allclose(own, poses, atol=1e-9)
    np.testing.assert_array_equal(motoman(start.position), poses[0])
    speed = np.where(program.kind == 1, program.feed, 0.5) * 1e3
    np.testing.assert_allclose([m.speed for m in lines], speed, atol=0.0501)
    assert start.position.rconf == lines[0].position.rconf


def test_angles_are_robodks(tmp_path):
    program = random_program(2000, 77)
    lines = lines_of(written(program, tmp_path))
    ours = np.array([m.position.angles for m in lines])
    wanted = in_base(program)
    theirs = np.array([robomath.Pose_2_Motoman(robomath.Mat(m.tolist()))[3:] for m in wanted])
    free = np.abs(ours[:, 1]) < 60.0
    assert 500 < free.sum() < 2000
    turns = (ours - theirs + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(turns[free], 0.0, atol=1.6e-4)
    np.testing.assert_allclose(turns[free][:, 0], 0.0, atol=0.501e-4)


def test_gimbal_lock_in_the_robot_frame(tmp_path):
    """Work object at the base, so that lock stays lock: Rx is 0, nothing is lost."""
    program = changed(random_program(900, 3), workobject=Frame.identity())
    lines = lines_of(written(program, tmp_path))
    poses = np.array([motoman(m.position) for m in lines])
    np.testing.assert_allclose(poses[:, :3, :3], program.rotation, atol=1.55e-6)
    angles = np.array([m.position.angles for m in lines])
    locked = np.abs(angles[:, 1]) == 90.0
    assert locked.sum() > 100


def test_rconf_by_hand():
    """DX100 4.1.3: flip, upper arm, front, R, T, S within 180 deg are 0; YMConnect: no flip where B is negative."""
    degrees = np.array([
        [0.0, -10.0, 20.0, 0.0, -90.0, 0.0],  # tool down in front: RCONF 1,0,0,0,0,0 in most jobs that controllers save
        [0.0, -10.0, 20.0, 170.0, 90.0, 180.0],
        [0.0, -10.0, 20.0, 90.0, 30.0, 180.001],
        [0.0, -10.0, 20.0, -180.0, -30.0, -180.0],
        [0.0, -10.0, 20.0, -179.999, 0.0, -179.999],
        [181.0, -10.0, 20.0, 271.0, -1e-9, 0.0],  # prints as 0: not negative
        [-180.0, -10.0, 20.0, -90.0, -0.001, 0.0],
        [0.0, -10.0, 20.0, 0.0, 30.0, 0.0],
        [0.0, -10.0, 20.0, 0.0, 30.0, 0.0],
        [0.0, -10.0, 20.0, 0.0, -30.0, 0.0],
    ])  # fmt: skip
    branch = np.array([1, 0, 0, 1, 0, 0, 1, 2, 4, 7], dtype=np.int32)
    program = changed(random_program(10, 1), joints=np.radians(degrees), configuration=branch)
    expected = [
        "1,0,0,0,0,0", "0,0,0,0,0,0", "0,0,0,0,1,0", "1,0,0,1,1,0", "0,0,0,0,0,0",
        "0,0,0,1,0,1", "1,0,0,0,0,1", "0,1,0,0,0,0", "0,0,1,0,0,0", "1,1,1,0,0,0",
    ]  # fmt: skip
    assert rconf(program, slice(0, 10)) == [e + ",0" * 18 for e in expected]


def test_head(tmp_path):
    run = written(small(), tmp_path)
    assert run.names == ["PART1"]
    text = " ".join(run.comments)
    assert "Compensated program PART1 for a robot" in text and "Source: part.nc" in text
    assert "Tool 1 spindle-a X 10 Y -20 Z 250 mm Rx 0 Ry 30 Rz 0 deg" in text
    assert "Work object in the robot frame X 1500 Y -200 Z 800 mm Rx 10 Ry -20 Rz 30 deg" in text
    assert text.endswith("T1 M6 S12000 M3 ? Frasen")
    assert [m.word for m in run.moves[:2]] == ["MOVJ", "MOVL"] and run.moves[0].speed == 10.0


def test_speeds_and_stops(tmp_path):
    lines = lines_of(written(small(), tmp_path))
    assert [m.speed for m in lines] == [500, 500, 5, 20, 20, 20, 30, 500]
    # ends, corners that half a segment of rounding would cut by more than 0.01 mm, and the exact pose stand still
    assert [m.level for m in lines] == [0, None, 0, 0, 0, None, 0, 0]


def test_a_pose_is_passed_only_where_half_a_segment_may_be_rounded(tmp_path):
    """0.01 mm in cuts: arcs in steps of 1 mm with 0.3 and 3 deg of turn; a parabola of half a segment misses by
    L/4 sin(theta/2): 0.65 um and 6.5 um pass, 5 deg (10.9 um) does not."""
    for degrees, passes in ((0.3, True), (3.0, True), (5.0, False)):
        p = random_program(60, 1, lock=False)
        heading = np.radians(degrees) * np.arange(60)
        step = np.column_stack((np.cos(heading), np.sin(heading), 0 * heading)) * 1e-3
        p = changed(p, position=np.cumsum(step, axis=0), kind=np.ones(60, dtype=np.uint8), feed=np.full(60, 0.02))
        (tmp_path / str(degrees)).mkdir()
        found = write_program(p, tmp_path / str(degrees) / "part1.jbi").findings
        stands = [f for f in found if "stands in the cut" in f.what]
        assert [(f.place, f.count) for f in stands] == ([] if passes else [("pose 1 (random.nc:2)", 58)])
        levels = [m.level for m in lines_of(written(p, tmp_path / str(degrees)))]
        assert levels == [0] + [None if passes else 0] * 58 + [0]


def test_feeds_that_v_cannot_say(tmp_path):
    p = small()
    for value, at in ((5e-5, 3), (1.6, 4)):
        feed = p.feed.copy()
        feed[at] = value
        with pytest.raises(WriteError, match=rf"pose {at} \(part.nc:{10 + at}\): V takes 0.1 to 1500 mm/s"):
            write_program(changed(p, feed=feed), tmp_path / "p.jbi")
    with pytest.raises(WriteError, match="rapid speed: V takes"):
        write_program(changed(p, rapid_speed=2.0), tmp_path / "p.jbi")
    feed = p.feed.copy()
    feed[3] = 0.00125  # 1.25 mm/s becomes 1.2
    found = write_program(changed(p, feed=feed), tmp_path / "p.jbi").findings
    assert any("pose 3" in str(f) and "more than 1 %" in str(f) for f in found)


def test_tool_change_pauses_and_takes_the_other_tool(tmp_path):
    write_program(two_tools(), tmp_path / "p.jbi")
    run = inform_reader.read(tmp_path / "p.jbi")
    assert run.pauses == [1 + 3] and "mount tool 2 (b), then go on" in run.comments
    assert [m.position.tool for m in run.moves] == [1, 1, 1, 1, 2, 2, 2, 2, 2]
    assert [run.moves[k].level for k in (3, 4, 5)] == [0, 0, 0]


def test_tools_and_start_are_said(tmp_path):
    found = [str(f) for f in write_program(small(), tmp_path / "p.jbi").findings]
    tool = "X 10 Y -20 Z 250 mm, Rx 0 Ry 30 Rz 0 deg, load 35 kg, centre mm 0 5 120"
    assert any(f"tool file 1 of the controller has to be {tool}" in f for f in found)
    assert any("[start] is not written" in f for f in found)
    assert any("pose 5 (part.nc:15) (and 2 more places): the arm reaches behind its axis 1" in f for f in found)
    p = small()
    with pytest.raises(WriteError, match="a number from 0 to 63"):
        write_program(changed(p, tools={64: SPINDLE}, tool=np.full(8, 64, dtype=np.int32)), tmp_path / "q.jbi")


def test_split_jobs(tmp_path):
    """A job ends behind a rapid where it can: the arm stands where one job calls the next."""
    p = random_program(10001, 8)
    kind = np.ones(10001, dtype=np.uint8)
    kind[[0, 4000, 7500, 10000]] = 0
    p = changed(p, kind=kind, feed=np.full(10001, 0.02))
    written = write_program(p, tmp_path / "big.jbi")
    assert [f.name for f in written.files] == ["big.jbi", "big_001.jbi", "big_002.jbi", "big_003.jbi"]
    assert inform_reader.read(written.files[0]).names == ["BIG", "BIG_001", "BIG_002", "BIG_003"]
    lengths = [len(inform_reader.read(f).moves) for f in written.files]
    assert lengths == [10002, 4001, 3500, 2500]
    assert not any("ends in the cut" in str(f) for f in written.findings)
    found = write_program(changed(p, kind=np.ones(10001, dtype=np.uint8)), tmp_path / "big.jbi").findings
    assert any("ends in the cut" in str(f) for f in found)


def test_too_many_lines(tmp_path):
    p = random_program(4000, 1)
    comments = tuple((i, "x" * 60) for i in range(4000))  # two lines each
    with pytest.raises(WriteError, match=r"pose 0 .*more than 9999 lines"):
        write_program(changed(p, comments=comments), tmp_path / "p.jbi")
    found = write_program(changed(p, comments=comments[:2900]), tmp_path / "p.jbi").findings
    assert not any("9999" in str(f) for f in found)
    assert len(inform_reader.lines_of(tmp_path / "p.jbi")) > 9800


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    found = write_program(changed(p, configuration=None), tmp_path / "p.jbi").findings
    assert any("no spherical wrist" in str(f) for f in found)


def test_names_in_capitals(tmp_path):
    assert written(small(), tmp_path, "a" * 32 + ".jbi").names == ["A" * 32]
    assert written(small(), tmp_path, "1110-wall_2.jbi").names == ["1110-WALL_2"]
