"""URScript against an independent reader and robodk's rotation vectors."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import robodk.robomath as robomath
from scipy.spatial.transform import Rotation

from tests.oracles import urscript_reader
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small, two_tools
from toolpaths.files import read_back, write_program
from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame


def written(program, tmp_path, name="part1.script"):
    """All moves of all files, in the order in which an operator runs them."""
    files = write_program(program, tmp_path / name).files
    return [urscript_reader.read(f) for f in files]


def lines_of(runs):
    return [m for run in runs for m in run.moves if m.word == "movel"]


@pytest.mark.parametrize("n", [3, 900, 2500, 2501, 6000])
def test_parts_and_the_start(n, tmp_path):
    program = random_program(n, n)
    runs = written(program, tmp_path)
    assert len(lines_of(runs)) == n and len(runs) == (n > 2500) + (n > 5000) + 1
    assert [m.word for m in runs[0].moves[:2]] == ["movej", "movel"]
    np.testing.assert_allclose(runs[0].moves[0].target, program.joints[0], atol=1e-9)


def test_rotation_vectors_are_those_of_robodk(tmp_path):
    """Half turns and nearly half turns too, where the sign of the vector is free."""
    g = np.random.default_rng(3)
    axis = g.normal(size=(300, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = np.pi - g.choice([0.0, 1e-9, 1e-7, 1e-5, 1e-3, 1.0], 300)
    rotation = Rotation.from_rotvec(axis * angle[:, None]).as_matrix()
    program = changed(random_program(300, 1), rotation=rotation, workobject=Frame.identity())
    for m, r in zip(lines_of(written(program, tmp_path)), rotation, strict=True):
        np.testing.assert_allclose(m.target[:3, :3], r, atol=2e-8)
        assert np.linalg.norm(Rotation.from_matrix(m.target[:3, :3]).as_rotvec()) <= np.pi + 1e-9
        pose = robomath.Mat([[*row, 0.0] for row in r.tolist()] + [[0, 0, 0, 1]])
        theirs = np.array(robomath.UR_2_Pose(robomath.Pose_2_UR(pose)).rows)[:3, :3]
        # robomath itself loses digits next to half turns (angle by arccosine)
        np.testing.assert_allclose(m.target[:3, :3], theirs, atol=3e-4)


def test_vector_and_printed_digits(tmp_path):
    program = changed(random_program(200, 9, lock=False), workobject=Frame.identity())
    write_program(program, tmp_path / "p.script")
    text = (tmp_path / "p.script").read_text()
    for row, r in zip([x for x in text.splitlines() if "movel" in x], program.rotation, strict=True):
        ours = [float(v) for v in row.split("p[")[1].split("]")[0].split(",")][3:]
        pose = robomath.Mat([[*line, 0.0] for line in r.tolist()] + [[0, 0, 0, 1]])
        np.testing.assert_allclose(ours, robomath.Pose_2_UR(pose)[3:], atol=2e-6)


def test_frames_and_start(tmp_path):
    (run,) = written(small(), tmp_path)
    first = run.moves[0]
    np.testing.assert_allclose(first.tcp[:3, 3], [0.01, -0.02, 0.25], atol=1e-12)
    np.testing.assert_allclose(first.tcp[:3, :3], SPINDLE.frame.rotation, atol=2e-9)
    assert first.payload == (35.0, (0.0, 0.005, 0.12))
    assert [m.word for m in run.moves[:3]] == ["movej", "movej", "movel"]
    np.testing.assert_allclose(np.degrees(first.target), [0, -100, 100, 0, 45, 0], atol=1e-6)
    np.testing.assert_allclose(np.degrees(read_back(tmp_path / "part1.script").start_joints)[:2], [0, -100], atol=1e-6)


def test_speed_and_blend(tmp_path):
    lines = lines_of(written(small(), tmp_path))
    assert [m.v for m in lines] == [0.5, 0.5, 0.005, 0.02, 0.02, 0.02, 0.03, 0.5]
    assert [m.r for m in lines] == [0, 0.001, 1e-5, 1e-5, 0, 0, 1e-5, 0]


def test_blends_never_overlap(tmp_path):
    p = random_program(6000, 5)
    scale = 10.0 ** np.random.default_rng(1).uniform(-3, 1, 6000)
    step = np.random.default_rng(2).normal(size=(6000, 3)) * scale[:, None] * 1e-3
    runs = written(changed(p, position=np.cumsum(step, axis=0)), tmp_path)
    for run in runs:
        lines = [m for m in run.moves if m.word == "movel"]
        at = np.array([m.target[:3, 3] for m in lines])
        r = np.array([m.r for m in lines])
        assert (r[:-1] + r[1:] < np.linalg.norm(np.diff(at, axis=0), axis=1))[r[:-1] + r[1:] > 0].all()
        assert r[-1] == 0 and len(set(r)) >= 6 and (r > 0).mean() > 0.4


def test_parts_follow_each_other(tmp_path):
    """A part begins, without moving, where the one before it ended; tool and payload are stated again."""
    program = random_program(6000, 8)
    runs = written(program, tmp_path)
    assert [f.name for f in sorted(tmp_path.iterdir())] == ["part1.script", "part1_002.script", "part1_003.script"]
    done = 0
    for before, run in pairwise(runs):
        done += sum(m.word == "movel" for m in before.moves)
        assert [m.word for m in run.moves[:2]] == ["movej", "movel"]
        np.testing.assert_allclose(run.moves[0].target, program.joints[done - 1], atol=1e-9)
        assert program.kind[done - 1] == 0 and run.moves[0].payload == runs[0].moves[0].payload
    found = [str(f) for f in write_program(program, tmp_path / "part1.script").findings]
    assert len(found) == 1 and "3 programs to be run one after the other" in found[0]
    cut = changed(program, kind=np.ones(6000, dtype=np.uint8), feed=np.full(6000, 0.02))
    assert any("ends in the cut" in str(f) for f in write_program(cut, tmp_path / "part1.script").findings)


def test_tool_change_asks_and_takes_the_other_tool(tmp_path):
    (run,) = written(two_tools('b "9"', mass=2.0), tmp_path)
    assert run.popups == ["mount tool 2 (b '9'), then go on"]
    lines = lines_of([run])
    assert [m.tcp[2, 3] for m in lines] == [0.25, 0.25, 0.25, 0.3, 0.3, 0.3, 0.3]
    assert lines[-1].payload == (2.0, (0.0, 0.0, 0.15)) and lines[2].r == lines[3].r == 0


@pytest.mark.parametrize(("name", "function"), [("1110_wall", "P_1110_wall"), ("while", "while_P"), ("a b", "a_b")])
def test_names(name, function, tmp_path):
    found = write_program(changed(small(), name=name), tmp_path / "p.script").findings
    assert any(f"the function is called {function}" in str(f) for f in found)
    text = (tmp_path / "p.script").read_text()
    assert f"def {function}():" in text and text.endswith(f"end\n\n{function}()\n")
    urscript_reader.read(tmp_path / "p.script")


def test_an_arm_without_a_spherical_wrist(tmp_path):
    assert len(lines_of(written(changed(random_program(5, 1), configuration=None), tmp_path))) == 5


def test_load_that_is_not_known(tmp_path):
    tool = ToolFrame("bare", SPINDLE.frame)
    found = write_program(changed(small(), tools={1: tool}), tmp_path / "p.script").findings
    assert any("mass is not known" in str(f) for f in found)
    assert "set_payload" not in (tmp_path / "p.script").read_text()
