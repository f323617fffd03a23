"""VAL3 against an independent reader, robodk's angles, and numbers made by hand."""

from __future__ import annotations

import numpy as np
import pytest
import robodk.robomath as robomath
from scipy.spatial.transform import Rotation

from tests.oracles import val3_reader
from tests.oracles.sample_programs import SPINDLE, WORKOBJECT, changed, random_program, small, two_tools
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame


def written(program, folder, name="part1.pgx"):
    write_program(program, folder / name)
    return val3_reader.read(folder / name.replace(".pgx", ".pjx"))


def staubli(value: dict) -> np.ndarray:
    """(4, 4) by robodk's formula."""
    return np.array(robomath.Staubli_2_Pose([value[k] for k in ("x", "y", "z", "rx", "ry", "rz")]).rows)


def test_files_of_an_application(tmp_path):
    files = write_program(small(), tmp_path / "part1.pgx").files
    assert [f.name for f in files] == ["part1.pgx", "part1.dtx", "part1.pjx", "start.pgx", "stop.pgx"]


@pytest.mark.parametrize("n", [1, 3, 900, 5001, 11000])
def test_what_stands_beside_the_poses(n, tmp_path):
    program = random_program(n, n)
    app = written(program, tmp_path)
    start, lines = app.moves[0], app.moves[1:]
    assert start.word == "movej" and [m.word for m in lines] == ["movel"] * n
    np.testing.assert_allclose(list(start.target.values()), np.degrees(program.joints[0]), atol=0.51e-6)
    poses = np.array([staubli(m.target) for m in lines])
    # the reader's own composition of rx, ry, rz is robodk's
    own = np.array([val3_reader.pose(app, m.target) for m in lines])
    np.testing.assert_allclose(own, poses, atol=1e-9)
    assert {m.target["fatherId"] for m in lines} == {"fWork[0]"}
    configs = {(m.target["shoulder"], m.target["elbow"], m.target["wrist"]) for m in lines}
    assert configs == {("ssame", "esame", "wsame")}


def test_angles_are_robodks(tmp_path):
    """Away from gimbal lock, digit by digit; in lock one angle is 0 by everybody's choice."""
    program = random_program(2000, 77, lock=False)
    g = np.random.default_rng(5)
    angles = g.uniform(-180, 180, (2000, 3))
    angles[:, 1] = g.choice([-90.0, 90.0], 2000) + g.choice([0.0, 1e-9, 1e-7, 1e-5, 1e-3], 2000) * g.normal(size=2000)
    rotation = program.rotation.copy()
    rotation[::3] = Rotation.from_euler("XYZ", angles[::3], degrees=True).as_matrix()  # the lock of moving axes x, y, z
    program = changed(program, rotation=rotation)
    app = written(program, tmp_path)
    lines = app.moves[1:]
    read = np.array([val3_reader.pose(app, m.target)[:3, :3] for m in lines])
    np.testing.assert_allclose(read, program.rotation, atol=3e-7)
    ours = np.array([[m.target[k] for k in ("rx", "ry", "rz")] for m in lines])
    matrices = np.tile(np.eye(4), (2000, 1, 1))
    matrices[:, :3, :3] = program.rotation
    theirs = np.array([robomath.Pose_2_Staubli(robomath.Mat(m.tolist()))[3:] for m in matrices])
    free = np.abs(ours[:, 1]) < 89.9
    assert 1000 < free.sum() < 2000
    turns = (ours - theirs + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(turns[free], 0.0, atol=2e-5)


def test_frames_and_start(tmp_path):
    app = written(small(), tmp_path)
    work, tool = app.data["fWork"][1][0], app.data["tTool1"][1][0]
    np.testing.assert_allclose(staubli(work)[:3, 3], [1500, -200, 800])
    np.testing.assert_allclose(staubli(work)[:3, :3], WORKOBJECT[:3, :3], atol=2e-8)
    assert work["fatherId"] == "world[0]" and tool["fatherId"] == "flange[0]"
    assert [tool[k] for k in ("x", "y", "z")] == [10, -20, 250]
    np.testing.assert_allclose(staubli(tool)[:3, :3], SPINDLE.frame.rotation, atol=2e-8)
    assert [m.word for m in app.moves[:3]] == ["movej", "movej", "movel"]
    assert list(app.moves[0].target.values()) == [0, -100, 100, 0, 45, 0]
    assert app.moves[0].mdesc["vel"] == 20 and app.moves[2].mdesc["vel"] == 100
    # the points in world, through the father frame
    first = val3_reader.in_world(app, app.moves[2].target)[:3, 3]
    np.testing.assert_allclose(first, (WORKOBJECT @ [0, 0, 0.05, 1])[:3] * 1e3, atol=1e-4)


def test_speed_and_rounding_hold_where_they_stand(tmp_path):
    lines = [m.mdesc for m in written(small(), tmp_path).moves if m.word == "movel"]
    assert [m["tmax"] for m in lines] == [500, 500, 5, 20, 20, 20, 30, 500]
    # the straight approach ends at half the 5 mm, corners at 0.01 mm, exact pose and both ends stop
    assert [m["leave"] for m in lines] == [0, 1, 0.01, 0.01, 0, 0.005, 0.01, 0]
    assert all(m["leave"] == m["reach"] and (m["blend"] == "off") == (m["leave"] == 0) for m in lines)


def test_tool_change_waits_for_a_key_and_takes_the_other_tool(tmp_path):
    app = written(two_tools('b"\\ ]]>'), tmp_path)
    ((at, text),) = app.said
    assert at == 1 + 3 and text == "mount tool 2 (b'/ ]] ), then press a key"
    assert [m.tool["z"] for m in app.moves[1:]] == [250, 250, 250, 300, 300, 300, 300, 300]
    stands = [m.mdesc["blend"] == "off" for m in app.moves[1:]]
    assert stands == [True, False, True, True, True, False, False, True]


def test_parts_are_programs_of_one_application(tmp_path):
    files = write_program(random_program(10001, 8), tmp_path / "big.pgx").files
    assert [f.name for f in files] == [
        "big.pgx", "big_001.pgx", "big_002.pgx", "big_003.pgx", "big.dtx", "big.pjx", "start.pgx", "stop.pgx",
    ]  # fmt: skip
    app = val3_reader.read(tmp_path / "big.pjx")
    assert [len(app.data[f"pMove{i:03d}"][1]) for i in (1, 2, 3)] == [5000, 5000, 1]
    assert len(app.programs["big_002"]) == 5000 and len(app.moves) == 10002


def test_another_applications_folder_is_left_alone(tmp_path):
    write_program(small(), tmp_path / "one.pgx")
    before = {f.name: f.read_bytes() for f in tmp_path.iterdir()}
    with pytest.raises(WriteError, match=r"start.pgx: another application's start program.*folder of its own"):
        write_program(small(), tmp_path / "two.pgx")
    assert {f.name: f.read_bytes() for f in tmp_path.iterdir()} == before
    write_program(small(), tmp_path / "one.pgx")


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    assert len(written(changed(p, configuration=None), tmp_path).moves) == 6


def test_what_the_user_has_to_know(tmp_path):
    found = [str(f) for f in write_program(small(), tmp_path / "part1.pgx").findings]
    said = "tool 1: a tool of VAL3 holds no payload: load 35 kg, centre mm 0 5 120 (flange). set it on the controller"
    assert any(said in f for f in found)
    unknown = changed(small(), tools={1: ToolFrame("pen", Frame(np.eye(3), np.zeros(3)))})
    assert not any("payload" in str(f) for f in write_program(unknown, tmp_path / "part1.pgx").findings)
    (tmp_path / "b").mkdir()
    found = write_program(random_program(55000, 1, lock=False), tmp_path / "b" / "big.pgx").findings
    assert any("about 10 MB of VAL3" in str(f) for f in found)
