"""URScript in place: a diff shows only poses; what is written out, put in or straightened is listed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.languages.urscript import ARC, SOURCE
from tests.oracles import urscript_reader
from tests.oracles.commanded import changed_lines, commanded, read_again
from tests.oracles.commanded import run as run_filter

run, again = partial(run_filter, "test.script"), partial(read_again, "test.script")


def test_lines_that_change(tmp_path):
    """A named pose of one move stays named; the two of wp_2 are written into their moves."""
    shift = np.array([1.2345678e-4, -3.1e-5, 7.7e-5])
    _, _, done = run(tmp_path, SOURCE, lambda t: commanded(t, None, shift, (1e-4, 2e-4, 0)))
    gone, came = changed_lines(SOURCE.encode(), done.text)
    assert [x.split("p[")[0] for x in gone] == [
        "  wp_1 = ",
        "  movel(",
        "  movel(wp_2, a=1.2, v=0.02)",
        "  movel(pose_trans(f, ",
        "  movel(wp_2, a=1.2, v=0.03)",
    ]
    assert came[1].startswith("  wp_1 = p[0.1001235, -0.0000310, 0.0000770, ")
    assert came[2].endswith("], 1.2, 0.02, 0, 0.005)") and came[4].endswith("]), a=1.2, v=0.02, r=0.002)")
    assert [(f.place, f.count) for f in done.changes] == [("test.script:12", 2)]  # and 15


def test_the_vector_stays_next_to_the_old_one(tmp_path):
    """Beyond a half turn the file's vector is longer than pi, or points the other way: it stays so."""
    text = "def a():\n  movel(p[0, 0, 0, 0, 4.0, 0], v=0.1)\n  movel(p[0.1, 0, 0, 0, -3.14, 0.1], v=0.1)\nend\n"
    _, made, done = run(tmp_path, text, lambda t: commanded(t, None, 1e-3, (0, 3e-3, 0)))
    assert "4.00300000, 0" in done.text.decode() and ", -3.13" in done.text.decode()
    new = again(tmp_path, done)
    got = Rotation.from_quat(new.quaternion, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, made.rotation, atol=2e-8)


def put_in(t, steps, before, rows):
    """The toolpath with copies of pose ``before`` put in front of it, ``steps`` (K, 3) m behind the one before."""
    at = np.arange(len(t))
    made, row = commanded(t, [*at[:before], *[before] * len(steps), *at[before:]], 0.0)
    position, row = made.position.copy(), row.copy()
    position[before : before + len(steps)] = position[before - 1] + np.asarray(steps)
    row[before : before + len(steps)] = rows
    return replace(made, position=position), row


def test_poses_put_in_and_blends(tmp_path):
    """Blends shrink to 0.4 of the shorter segment beside them, also of the move in front."""
    steps = [[0.001, 0, 0], [0.05, 0, 0]]
    t, _, done = run(tmp_path, SOURCE, lambda t: put_in(t, steps, 3, [2.01, 2.5]))
    new = again(tmp_path, done)
    np.testing.assert_allclose(new.position[3:5, 0], [0.101, 0.15])
    np.testing.assert_allclose(np.delete(new.position, [3, 4], axis=0)[1:], t.position[1:])
    text = done.text.decode()
    assert "  movel(wp_1, a=1.2, v=0.02, r=0.0004)  # first\n" in text
    assert "  movel(p[0.1010000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.0004)\n" in text
    assert "  movel(p[0.1500000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.0196)\n" in text
    assert "  movel(p[0.200000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.005)\n" in text
    assert sorted((f.what[:12], f.count) for f in done.changes) == [("a blend radi", 1), ("poses were p", 2)]
    at, r = new.position[2:], new.setting.zones[2:]
    assert (r[:-1] + r[1:] < np.linalg.norm(np.diff(at, axis=0), axis=1)).all()


def test_a_move_without_a_radius_gets_one_for_what_is_put_in(tmp_path):
    _, _, done = run(tmp_path, SOURCE, lambda t: put_in(t, [[0.02, 0.02, 0]], 4, [3.5]))
    new = again(tmp_path, done)
    line = next(x for x in done.text.decode().splitlines() if "p[0.22" in x)
    assert line.startswith("  movel(p[0.22000000, 0.02000000, 0.00000000, ") and "], a=1.2, v=0.02, r=0.011" in line
    assert new.setting.zones[4] > 0 and new.setting.zones[5] == 0


def test_a_named_via_point_is_written_into_the_move(tmp_path):
    text = ARC.replace("movec(p[0.01, 0.01, 0, 0, 0, 0]", "movec(wp")
    t, made, done = run(tmp_path, text, lambda t: commanded(t, None, np.array([2e-5, 0.0, 1e-4])), 1e-4)
    new = again(tmp_path, done, 1e-4)
    np.testing.assert_allclose(new.position, made.position, atol=4e-7)
    assert len(new) == len(t) > 5 and done.text.count(b"  movec(p[0.01") == 1 and len(done.changes) == 1
    assert b"], 1.2, 0.02, 0.001)" in done.text


def test_lines_of_an_arc_blend_within_their_length(tmp_path):
    def dented(t):
        made, row = commanded(t, None, np.array([0.0, 0.0, 1e-4]))
        position = made.position.copy()
        position[len(t) // 3, 2] += 2e-5
        return replace(made, position=position), row

    _, _, done = run(tmp_path, ARC, dented, 1e-4)
    new = again(tmp_path, done, 1e-4)
    r = new.setting.zones
    assert b"movec" not in done.text and b", a=1.2, v=0.02, r=" in done.text
    assert (r[:-1] + r[1:] < np.linalg.norm(np.diff(new.position, axis=0), axis=1)).all()


def test_a_straight_move_to_joint_angles(tmp_path):
    text = "def go():\n  movel([0, 1, 0, 0, 0, 0], a=1, v=0.1)\nend\ngo()\n"

    def make(t):
        known = replace(t, position=np.full((1, 3), 0.3), quaternion=np.array([[0.0, 0, 1, 0]]))
        return commanded(known, [0], 0.0)

    _, _, done = run(tmp_path, text, make)
    new = again(tmp_path, done)
    np.testing.assert_allclose(new.position, 0.3)
    assert new.setting.joints == {} and b"], a=1, v=0.1)" in done.text


def test_what_is_put_in_misses_its_corner_by_less_than_a_hundredth(tmp_path):
    """A pose put in 0.1 mm beside the straight way is rounded within 0.01 mm, not by 0.4 of 50 mm."""
    _, _, done = run(tmp_path, SOURCE, lambda t: put_in(t, [[0.05, 1e-4, 0]], 3, [2.5]))
    new = again(tmp_path, done)
    at, r = new.position[2:5], new.setting.zones[3]
    out = [(b - a) / np.linalg.norm(b - a) for a, b in pairwise(at)]
    half = 0.5 * np.arccos(np.clip(out[0] @ out[1], -1, 1))
    assert r == pytest.approx(2 * 1e-5 / np.sin(half), rel=1e-3) and r * np.sin(half) / 2 <= 1e-5 and r < 0.02


def test_a_pose_written_into_its_move_keeps_the_way_its_vector_is_spelled(tmp_path):
    pose = "wp = p[0.1, 0, 0, 0, 3.14159265, 0]"
    text = f"def a():\n  {pose}\n  movel(wp, v=0.1)\n  movel(p[0, 0, 0, 0, 3, 0], v=0.1)\n  movel(wp, v=0.1)\nend\n"
    _, made, done = run(tmp_path, text, lambda t: commanded(t, None, 1e-4, (0, 1e-3, 0)))
    assert done.text.count(b"0.00000000, 3.14259265, 0.00000000]") == 2 and f"  {pose}\n" in done.text.decode()
    got = Rotation.from_quat(again(tmp_path, done).quaternion, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, made.rotation, atol=2e-8)


def test_the_second_reader_takes_it(tmp_path):
    text = SOURCE.replace(", 1.2, 0.02, 0, 0.005)", ", a=1.2, v=0.02, r=0.005)").replace(
        "  set_digital_out(1, True)\n", ""
    )
    _, made, done = run(tmp_path, text, lambda t: commanded(t, None, np.array([1e-4, 0, 2e-4])))
    (tmp_path / "o.script").write_bytes(done.text)
    moves = urscript_reader.read(tmp_path / "o.script").moves
    np.testing.assert_allclose([m.target[:3, 3] for m in moves[2:]], made.position[2:], atol=1e-7)
