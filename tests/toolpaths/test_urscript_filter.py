"""URScript in place: a diff shows only poses; what is written out, put in or straightened is listed."""

from __future__ import annotations

import difflib
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles import urscript_reader
from tests.toolpaths.test_fanuc_filter import commanded
from toolpaths.errors import ReadError, WriteError
from toolpaths.languages.urscript.filter import rewrite
from toolpaths.languages.urscript.reader import read

SOURCE = """def part():
  f = p[1, 0, 0, 0, 0, 0.5]
  wp_1 = p[0.100000, 0.000000, 0.000000, 0.000000, 3.100000, 0.000000]
  wp_2 = p[0.300, 0.100, 0.000, 0, 3.1, 0]
  v_rapid = 0.5
  set_tcp(p[0, 0, 0.1, 0, 0, 0])
  movej([0, -1.5, 1.5, 0, 0.5, 0], a=1.4, v=0.35)
  movel(p[0.1, 0, 0.05, 0, 3.1, 0], v=v_rapid)
  # cut
  movel(wp_1, a=1.2, v=0.02, r=0.001)  # first
  movel(p[0.200000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.005)
  movel(wp_2, a=1.2, v=0.02)
  set_digital_out(1, True)
  movel(pose_trans(f, p[-0.7, 0.3, 0.01, 0, 0, 0]), a=1.2, v=0.02, r=0.002)
  movel(wp_2, a=1.2, v=0.03)
end

part()
"""


def run(tmp_path, text, make, chord=1e-5):
    path = tmp_path / "test.script"
    path.write_bytes(text.encode())
    t = read(path, "test.script", chord)
    made, row = make(t)
    return t, made, rewrite(text.encode(), made, row, path)


def again(tmp_path, done, chord=1e-5):
    path = tmp_path / "out.script"
    path.write_bytes(done.text)
    made, row = commanded(read(path, "out.script", chord), [0], 0.0)
    with pytest.raises(ReadError, match="compensated already") as caught:
        rewrite(done.text, made, row, path)
    assert caught.value.line == 2
    return read(path, "out.script", chord)


def without_marker(text: bytes) -> bytes:
    """The program without the comment that marks it, which has to be there once."""
    lines = text.splitlines(keepends=True)
    marks = [line for line in lines if line.strip() == b"# compensated by toolpath-compensator"]
    assert len(marks) == 1
    lines.remove(marks[0])
    return b"".join(lines)


@pytest.mark.parametrize("eol", ["\n", "\r\n"])
def test_nothing_changed_is_byte_identical(tmp_path, eol):
    text = SOURCE.replace("\n", eol)
    _, _, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 0.0))
    assert without_marker(done.text) == text.encode() and done.changes == ()


@pytest.mark.parametrize("eol", ["\n", "\r\n"])
def test_only_pose_numbers_change(tmp_path, eol):
    text = SOURCE.replace("\n", eol)
    shift = np.array([1.2345678e-4, -3.1e-5, 7.7e-5])
    t, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), shift, (1e-4, 2e-4, 0)))
    new = again(tmp_path, done)
    cut = t.kind == 1
    assert cut.tolist() == [False, False, True, True, True, True, True]
    np.testing.assert_allclose(new.position[cut], made.position[cut], atol=1e-7)
    np.testing.assert_allclose(new.position[1], t.position[1])
    got = Rotation.from_quat(new.quaternion[cut], scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, made.rotation[cut], atol=2e-8)
    for name in ("kind", "feed", "tool"):
        np.testing.assert_array_equal(getattr(new, name), getattr(t, name))
    np.testing.assert_array_equal(new.setting.zones, t.setting.zones)
    lines = list(difflib.ndiff(text.splitlines(), done.text.decode().splitlines()))
    gone = [x[2:].split("p[")[0] for x in lines if x.startswith("- ")]
    assert gone == [
        "  wp_1 = ",
        "  movel(",
        "  movel(wp_2, a=1.2, v=0.02)",
        "  movel(pose_trans(f, ",
        "  movel(wp_2, a=1.2, v=0.03)",
    ]
    came = [x[2:] for x in lines if x.startswith("+ ")]
    assert came[0] == "  # compensated by toolpath-compensator" and len(came) == 6
    assert came[1].startswith("  wp_1 = p[0.1001235, -0.0000310, 0.0000770, ")
    assert came[2].endswith("], 1.2, 0.02, 0, 0.005)") and came[4].endswith("]), a=1.2, v=0.02, r=0.002)")
    assert [(f.place, f.count) for f in done.changes] == [("test.script:12", 2)]  # and 15
    assert done.text.count(eol.encode()) == done.text.count(b"\n")


def test_the_vector_stays_next_to_the_old_one(tmp_path):
    """Beyond a half turn the file's vector is longer than pi, or points the other way: it stays so."""
    text = "def a():\n  movel(p[0, 0, 0, 0, 4.0, 0], v=0.1)\n  movel(p[0.1, 0, 0, 0, -3.14, 0.1], v=0.1)\nend\n"
    _, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 1e-3, (0, 3e-3, 0)))
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
    pose = "0.0000000, 0.000000, "
    assert "  movel(p[0.1010000, 0.000000, 0.000000, 2.200000, 2.250000, 0.010000], 1.2, 0.02, 0, 0.0004)\n" in text, (
        pose
    )
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


@pytest.mark.parametrize("time", ["a=1.2, t=2.0", "1.2, 0.02, t_cut"])
def test_a_move_by_time_is_not_divided(tmp_path, time):
    """Each part would take the whole time. Without poses put in it stays as it is."""
    text = SOURCE.replace("movel(wp_2, a=1.2, v=0.02)", f"movel(wp_2, {time})")
    text = text.replace("v_rapid =", "t_cut = 2.0\n  v_rapid =")
    with pytest.raises(WriteError, match=r"test\.script:13: a move by time cannot be divided\. Give it v instead of t"):
        run(tmp_path, text, lambda t: put_in(t, [[0.02, 0.02, 0]], 4, [3.5]))
    _, _, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 1e-4))
    assert f", {time})\n" in done.text.decode()


ARC = (
    "def a():\n  wp = p[0.01, 0.01, 0, 0, 0, 0]\n  movel(p[0, 0, 0, 0, 3, 0], v=0.1)\n"
    "  movec(p[0.01, 0.01, 0, 0, 0, 0], p[0.02, 0, 0, 0, 3, 0], 1.2, 0.02, 0.001)\n"
    "  movel(p[0.03, 0, 0, 0, 3, 0], v=0.1)\nend\n"
)


def test_an_arc_whose_poses_are_on_an_arc_again_stays_one(tmp_path):
    """Shifted as a whole, or grown: other numbers for via point and end; a named via point is written into the move."""
    _, _, done = run(tmp_path, ARC, lambda t: commanded(t, np.arange(len(t)), 0.0), 1e-4)
    assert without_marker(done.text) == ARC.encode()
    for text in (ARC, ARC.replace("movec(p[0.01, 0.01, 0, 0, 0, 0]", "movec(wp")):
        for shift in (lambda t: np.array([2e-5, 0.0, 1e-4]), lambda t: 0.01 * (t.position - [0.01, 0, 0])):
            t, made, done = run(tmp_path, text, lambda t, s=shift: commanded(t, np.arange(len(t)), s(t)), 1e-4)
            new = again(tmp_path, done, 1e-4)
            np.testing.assert_allclose(new.position, made.position, atol=4e-7)
            assert len(new) == len(t) > 5 and done.text.count(b"  movec(p[0.01") == 1
            assert b", 0, 0, 0], p[0.020" in done.text or text is not ARC
            assert len(done.changes) == (text is not ARC) and b"], 1.2, 0.02, 0.001)" in done.text


def test_an_arc_that_is_none_any_more_becomes_lines(tmp_path):
    def dented(t):
        made, row = commanded(t, np.arange(len(t)), np.array([0.0, 0.0, 1e-4]))
        position = made.position.copy()
        position[len(t) // 3, 2] += 2e-5
        return replace(made, position=position), row

    t, made, done = run(tmp_path, ARC, dented, 1e-4)
    new = again(tmp_path, done, 1e-4)
    np.testing.assert_allclose(new.position, made.position, atol=1e-7)
    assert b"movec" not in done.text and b", a=1.2, v=0.02, r=" in done.text and len(new) == len(t)
    assert [f.what for f in done.changes] == ["an arc became straight lines"]
    r = new.setting.zones
    assert (r[:-1] + r[1:] < np.linalg.norm(np.diff(new.position, axis=0), axis=1)).all()


def test_a_function_called_twice_is_refused(tmp_path):
    text = "def go():\n  movel(p[0, 0, 0, 0, 3, 0], v=0.1)\nend\ngo()\ngo()\n"
    with pytest.raises(WriteError, match=r"test\.script:2: this move runs more than once"):
        run(tmp_path, text, lambda t: commanded(t, [0, 1], 1e-4))


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
    _, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), 1e-4, (0, 1e-3, 0)))
    assert done.text.count(b"0.00000000, 3.14259265, 0.00000000]") == 2 and f"  {pose}\n" in done.text.decode()
    got = Rotation.from_quat(again(tmp_path, done).quaternion, scalar_first=True).as_matrix()
    np.testing.assert_allclose(got, made.rotation, atol=2e-8)


def test_real_program(shared, tmp_path):
    data = (shared / "data" / "cam" / "robodk" / "UniveralRobots.script").read_bytes()
    path = tmp_path / "u.script"
    path.write_bytes(data)
    t = read(path, "u.script", 1e-5)
    index = np.flatnonzero(t.kind == 1)
    made, row = commanded(t, index, np.zeros(3))
    assert without_marker(rewrite(data, made, row, path).text) == data
    made, row = commanded(t, index, np.array([1e-4, 0, 0]))
    done = rewrite(data, made, row, path)
    lines = [x for x in difflib.ndiff(data.decode().splitlines(), done.text.decode().splitlines()) if x[0] in "+-"]
    assert (
        len(lines) == 1 + 2 * 8 and all("movel(p[" in x or "# compensated" in x for x in lines) and done.changes == ()
    )
    path.write_bytes(done.text)
    np.testing.assert_allclose(read(path, "x", 1e-5).position[index], made.position, atol=1e-7)


def test_the_second_reader_takes_it(tmp_path):
    text = SOURCE.replace(", 1.2, 0.02, 0, 0.005)", ", a=1.2, v=0.02, r=0.005)").replace(
        "  set_digital_out(1, True)\n", ""
    )
    _, made, done = run(tmp_path, text, lambda t: commanded(t, np.arange(len(t)), np.array([1e-4, 0, 2e-4])))
    (tmp_path / "o.script").write_bytes(done.text)
    moves = urscript_reader.read(tmp_path / "o.script").moves
    np.testing.assert_allclose([m.target[:3, 3] for m in moves[2:]], made.position[2:], atol=1e-7)
