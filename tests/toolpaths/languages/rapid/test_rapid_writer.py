"""RAPID against an independent reader, rapidchecker, and hand-computed configuration data."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles import rapid_reader
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small, two_tools
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.languages.rapid.writer import confdata
from toolpaths.tool_frame import ToolFrame


def written(program, tmp_path, name="part1.mod"):
    write_program(program, tmp_path / name)
    return rapid_reader.read(tmp_path / name)


def matrices(quaternions) -> np.ndarray:
    return Rotation.from_quat(np.array(quaternions), scalar_first=True).as_matrix()


@pytest.mark.parametrize("n", [3, 900, 5001])
def test_what_stands_beside_the_poses(n, tmp_path):
    program = random_program(n, n)
    moves, other = written(program, tmp_path)
    assert other == ["ConfJ on", "ConfL off", "SingArea off", "ConfL on"]
    start, lines = moves[0], moves[1:]
    assert start.word == "MoveAbsJ" and [m.word for m in lines] == ["MoveL"] * n
    np.testing.assert_allclose(start.target[0], np.degrees(program.joints[0]), atol=0.51e-6)
    np.testing.assert_allclose(matrices([m.target[1] for m in lines]), program.rotation, atol=3e-8)
    assert all(m.target[3] == [9e9] * 6 for m in moves[1:]) and start.target[1] == [9e9] * 6
    conf = np.array([m.target[2] for m in lines])
    np.testing.assert_array_equal(conf[:, :3], np.floor(np.degrees(program.joints[:, [0, 3, 5]]) / 90))
    np.testing.assert_array_equal(conf[:, 3], program.configuration)
    assert all(m.speed[1:] == [500, 5000, 1000] for m in moves)


def test_tool_and_work_object(tmp_path):
    moves, _ = written(small(), tmp_path)
    for move in moves:
        held, frame, load = move.tool
        assert held is True and frame[0] == [10.0, -20.0, 250.0]
        np.testing.assert_allclose(matrices(frame[1]), SPINDLE.frame.rotation, atol=2e-8)
        assert load == [35.0, [0.0, 5.0, 120.0], [1, 0, 0, 0], 0, 0, 0]
        robhold, ufprog, mechanical, user, in_user = move.wobj
        assert (robhold, ufprog, mechanical) == (False, True, '""')
        assert user[0] == [1500.0, -200.0, 800.0] and in_user == [[0, 0, 0], [1, 0, 0, 0]]
        np.testing.assert_allclose(matrices(user[1]), small().workobject.rotation, atol=2e-8)


@pytest.mark.parametrize(
    ("mass", "com", "load"),
    [
        (None, None, [0.001, [0, 0, 0.001]]),
        (0.0, None, [0.001, [0, 0, 0.001]]),  # ABB refuses a load of 0
        (12.5, None, [12.5, [5, -10, 125]]),
    ],
)
def test_loads_that_are_not_known(mass, com, load, tmp_path):
    tool = ToolFrame("t", SPINDLE.frame, mass, com)
    moves, _ = written(changed(small(), tools={1: tool}), tmp_path)
    assert moves[0].tool[2][:2] == load


def test_configuration_by_hand():
    degrees = np.array([
        [0.0, 0, 0, 0.0, 0, 0.0],  # at zero: quarter 0
        [89.9, 0, 0, -0.1, 0, 90.0],  # 90 is in quarter 1
        [90.1, 0, 0, -90.0, 0, -90.1],  # -90 is in quarter -1
        [-180.0, 0, 0, 179.9, 0, 180.0],
        [-0.0, 0, 0, -2e-7, 0, 359.9],  # prints as 0: quarter 0
        [0, 0, 0, -270.1, 0, -360.0],
    ])  # fmt: skip
    expected = [[0, 0, 0], [0, -1, 1], [1, -1, -2], [-2, 1, 2], [0, 0, 3], [0, -4, -4]]
    branches = np.array([0, 3, 5, 7, 6, 1], dtype=np.int32)
    found = confdata(np.radians(degrees), branches)
    np.testing.assert_array_equal(found[:, :3], expected)
    np.testing.assert_array_equal(found[:, 3], branches)
    np.testing.assert_array_equal(confdata(np.radians(degrees), None)[:, 3], 0)


def path_of(points_mm, **values):
    n = len(points_mm)
    p = random_program(n, 1, lock=False)
    return changed(
        p, position=np.array(points_mm, dtype=float) * 1e-3, kind=np.ones(n, dtype=np.uint8),
        feed=np.full(n, 0.02), rotation=np.tile(np.eye(3), (n, 1, 1)), **values,
    )  # fmt: skip


def zones(program, tmp_path) -> list[list]:
    moves, _ = written(program, tmp_path)
    return [m.zone for m in moves[1:]]


def test_zones_on_a_straight_line(tmp_path):
    """Half the shorter neighbour bounds them; no corner, so nothing else does."""
    xs = (0, 20, 40, 42, 44, 44.7, 45.4, 45.5, 45.6, 45.63, 45.66, 60)
    got = zones(path_of([(x, 0, 0) for x in xs]), tmp_path)
    radii = [z[1] for z in got]
    assert radii == [0, 5, 1, 1, 0.3, 0.3, 0.03, 0.03, 0.01, 0.01, 0.01, 0]
    assert got[0][0] is True and got[-1][0] is True and not any(z[0] for z in got[1:-1])


def test_zones_in_corners_keep_to_the_path(tmp_path):
    """r/2 sin(theta/2) at most 0.01 mm in cuts: 90 deg allows 0.028, 11 deg 0.2, 1 deg 2.3 mm."""
    bent = np.radians([90.0, 11.0, 1.0, 180.0])
    directions = np.cumsum(np.concatenate(([0.0], bent)))
    points = np.cumsum([(0, 0, 0)] + [(50 * np.cos(a), 50 * np.sin(a), 0) for a in directions], axis=0)
    assert [z[1] for z in zones(path_of(points), tmp_path)[1:-1]] == [0.01, 0.1, 1.0, 0.01]


def test_zones_of_random_paths_never_reach_beyond_half_a_segment(tmp_path):
    p = random_program(3000, 5)
    scale = 10.0 ** np.random.default_rng(1).uniform(-3, 1, 3000)
    step = np.random.default_rng(2).normal(size=(3000, 3)) * scale[:, None] * 1e-3
    p = changed(p, position=np.cumsum(step, axis=0))
    moves, _ = written(p, tmp_path)
    at = np.array([m.target[0] for m in moves[1:]])
    length = np.linalg.norm(np.diff(at, axis=0), axis=1)
    # pzone_tcp and pzone_ori, and no stop in zones
    reach = np.array([0.0 if m.zone[0] else max(m.zone[1], m.zone[2]) for m in moves[1:]])
    standing = np.maximum(length[:-1], length[1:]) < 0.0102  # turns on the spot: the zone is one of angle
    bound = 0.5 * np.minimum(length[:-1], length[1:]) + 1.5e-4
    assert (reach[1:-1] <= bound)[~standing].all() and standing.mean() < 0.1
    assert (reach > 0).mean() > 0.5 and len(set(reach)) >= 6
    turn = np.diff(at, axis=0) / np.maximum(length, 1e-9)[:, None]
    miss = 0.25 * np.linalg.norm(np.diff(turn, axis=0), axis=1) * reach[1:-1] * ~standing
    cut = (p.kind[1:-1] == 1) | (p.kind[2:] == 1)
    assert miss[cut].max() <= 0.0101 and miss.max() <= 0.501


def test_exact_poses_stop(tmp_path):
    exact = np.zeros(6, dtype=bool)
    exact[3] = True
    got = zones(path_of([(10 * x, 0, 0) for x in range(6)], exact=exact), tmp_path)
    assert [z[0] for z in got] == [True, False, False, True, False, True]


def test_turning_on_the_spot_does_not_stop_at_every_pose(tmp_path):
    turns = Rotation.from_rotvec(np.radians(np.outer([0, 0, 0.1, 0.2, 0.3, 0.8, 1.3, 1.3], [0, 1, 0]))).as_matrix()
    p = changed(path_of([(0, 0, 0)] + [(5, 0, 0)] * 6 + [(9, 0, 0)]), rotation=turns)
    got = zones(p, tmp_path)
    assert [z[0] for z in got] == [True, True, False, False, False, False, True, True]
    assert [z[4] for z in got[2:6]] == [0.03, 0.03, 0.03, 0.1]


def test_many_feeds_are_written_into_the_moves(tmp_path):
    p = random_program(1000, 4)
    feed = np.where(p.kind == 1, np.linspace(0.001, 0.05, 1000), np.nan)
    p = changed(p, feed=feed)
    moves, _ = written(p, tmp_path)
    cut = p.kind == 1
    np.testing.assert_allclose(np.array([m.speed[0] for m in moves[1:]])[cut], feed[cut] * 1e3, atol=0.51e-5)
    assert (tmp_path / "part1.mod").read_text().count("speeddata") == 2


def test_tool_change_stops_and_takes_the_other_tool(tmp_path):
    moves, words = written(two_tools("Fräser Ø6", 12), tmp_path)
    assert words.count("Stop") == 1
    assert [m.tool[1][0][2] for m in moves[1:]] == [250, 250, 250, 300, 300, 300, 300, 300]
    assert [m.zone[0] for m in moves[1:]] == [True, False, True, True, True, False, False, True]
    assert "mount tool 12 (Fraser ?6)" in (tmp_path / "part1.mod").read_text()


def test_names(tmp_path):
    for name, legal in [
        ("1110_wall 265", "P_1110_wall_265"), ("while", "while_P"), ("Größe-7", "Gro_e_7"), ("_", "P_"),
        ("a" * 40, "a" * 24), ("", "P"),
    ]:  # fmt: skip
        done = write_program(changed(small(), name=name), tmp_path / "x.mod")
        text = (tmp_path / "x.mod").read_text()
        assert re.search(r"^MODULE (.*)$", text, re.M)[1] == legal
        assert f"module is called {legal}" in str(done.findings[0])
        rapid_reader.read(tmp_path / "x.mod")


def test_longest_name_in_the_most_parts_stays_legal(tmp_path):
    p = random_program(5001, 1, name="A" * 24)
    files = write_program(p, tmp_path / "a.mod").files
    names = set(re.findall(r"[A-Za-z]\w*", "".join(f.read_text() for f in files)))
    assert 24 < max(map(len, names)) <= 32
    rapid_reader.read(files[0])


def test_file_names_that_a_pgf_cannot_spell(tmp_path):
    for name in ("größe.mod", "a&b.mod"):
        rapid_reader.read(write_program(small(), tmp_path / name).files[0])
        with pytest.raises(WriteError, match="cannot spell this name"):
            write_program(random_program(5001, 1), tmp_path / name)


def test_other_arms(tmp_path):
    p = random_program(5, 1)
    done = write_program(changed(p, configuration=None), tmp_path / "ur.mod")
    assert "cfx is written as 0" in str(done.findings[0])


def test_split_program_runs_in_order(tmp_path):
    program = random_program(10001, 8)
    files = write_program(program, tmp_path / "big.mod").files
    assert [f.name for f in files] == ["big.mod", "big_001.mod", "big_002.mod", "big_003.mod", "big.pgf"]
    assert [f.read_text().count("MoveL") for f in files] == [0, 5000, 5000, 1, 0]
    assert b"\r\n" in files[-1].read_bytes()
    moves, _ = rapid_reader.read(files[0])
    np.testing.assert_allclose([m.target[0] for m in moves[1:]], program.position * 1e3, atol=0.51e-4)


def check(text: str) -> list:
    """rapidchecker 0.1.5 on the module behind the header, which its grammar does not have.

    It checks syntax, indentation and upper-case keywords. It does not know types, names, aggregate shapes,
    name lengths, the arguments of an instruction or line ends: tests/oracles/rapid_reader.py does.
    """
    body = re.sub(r"^%%%\n.*?%%%\n\n", "", text.replace("\r\n", "\n"), flags=re.S)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # its use of pyparsing
        from rapidchecker.check import check_format

        return check_format(body)


def test_rapidchecker(tmp_path):
    """Heads of split programs and samples of moves: 25 ms a MoveL."""
    files = write_program(random_program(10001, 8), tmp_path / "big.mod").files
    for file in files[:-1]:
        text = file.read_text()
        moves = re.findall(r"^    MoveL.*\n", text, re.M)
        for dropped in moves[5:]:
            text = text.replace(dropped, "", 1)
        assert check(text) == []
    write_program(small(), tmp_path / "small.mod")
    assert check((tmp_path / "small.mod").read_text()) == []
    assert check((tmp_path / "small.mod").read_text().replace("ENDPROC", "ENDPRO")) != []
