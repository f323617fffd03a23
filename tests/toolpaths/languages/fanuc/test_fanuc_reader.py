"""Fanuc .ls in: real programs, what is read, and what is refused in which line."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.read_text import read_text
from tests.oracles.sample_programs import random_program
from tests.oracles.tp_programs import plain, pose, program
from toolpaths.files import read_toolpath, write_program
from toolpaths.languages.fanuc.speeds import speed_texts

read = partial(read_text, "test.ls")


def test_moves_and_what_they_carry(tmp_path):
    lines = [
        "  UFRAME_NUM=1",
        "  UTOOL_NUM=2",
        "J P[3:home] 20% FINE",
        "J P[1] 50% CNT50",
        "  !face 1",
        "  DO[1]=ON",
        "L P[2] 20mm/sec FINE",
        "L P[4] 7cm/min CNT100 ACC50",
        "L P[1] 2.8inch/min CR5",
        "L P[2] max_speed CNT100",
        "L P[4] 3.0sec CNT10 PTH",
    ]
    t = read(tmp_path, plain(*lines))
    assert t.language == "fanuc" and t.line.tolist() == [7, 8, 11, 12, 13, 14, 15]
    np.testing.assert_allclose(t.position[1:, 0], [0.1, 0.2, 0.3, 0.1, 0.2, 0.3])
    assert np.isnan(t.position[0]).all() and t.kind.tolist() == [0, 0, 1, 1, 1, 0, 1]
    np.testing.assert_allclose(t.feed[2:5], [0.02, 0.07 / 60, 2.8 * 0.0254 / 60])
    assert np.isnan(t.feed[[0, 1, 5, 6]]).all()
    np.testing.assert_allclose(t.setting.zones, [0, np.nan, 0, np.nan, 0.005, np.nan, np.nan])
    assert t.setting.configuration.tolist() == [-1] + [1] * 6
    np.testing.assert_allclose(np.degrees(t.setting.joints[0]), [0, 30, 10, 10, -90, 5])
    assert t.setting.workobject is None and t.setting.tools == {} and t.tool.tolist() == [2] * 7
    expected = Rotation.from_euler("xyz", [-180, 0, 30], degrees=True)
    got = Rotation.from_quat(t.quaternion[1], scalar_first=True)
    assert (expected.inv() * got).magnitude() < 1e-12
    np.testing.assert_allclose(t.axis[1], -expected.as_matrix()[:, 2], atol=1e-12)
    assert [(e.word, e.pose, e.line) for e in t.events] == [("face 1", 2, 9), ("DO[1]=ON", 2, 10)]


def test_frames_from_constants(tmp_path):
    def frame(word: str, number: int, values: str) -> list[str]:
        elements = [f"  PR[9,{i}]={v}" for i, v in enumerate(values.split(), 1)]
        return ["  PR[9]=LPOS", *elements, f"  {word}[{number}]=PR[9]", f"  {word}_NUM={number}"]

    lines = [
        *frame("UFRAME", 1, "1500.0 (-200.5) 800. 10.0 (-20.0) 30.0"),
        *frame("UTOOL", 2, "10.0 -20.0 250.0 0 30 0"),
    ]
    t = read(tmp_path, plain(*lines, "L P[1] 20mm/sec FINE"))
    expected = Rotation.from_euler("xyz", [10, -20, 30], degrees=True).as_matrix()
    np.testing.assert_allclose(t.setting.workobject.rotation, expected, atol=1e-12)
    np.testing.assert_allclose(t.setting.workobject.origin, [1.5, -0.2005, 0.8])
    np.testing.assert_allclose(t.setting.tools[2].frame.origin, [0.01, -0.02, 0.25])
    expected = Rotation.from_euler("y", 30, degrees=True).as_matrix()
    np.testing.assert_allclose(t.setting.tools[2].frame.rotation, expected, atol=1e-12)


def test_an_arc(tmp_path):
    text = program(
        ["L P[1] 20mm/sec FINE", "C P[2]\n    :  P[4] 20mm/sec CNT100"], pose(1, 0) + pose(2, 10, 10) + pose(4, 20)
    )
    t = read(tmp_path, text)
    np.testing.assert_allclose(np.hypot(t.position[:, 0] - 0.01, t.position[:, 1]), 0.01, atol=1e-12)
    assert len(t) > 20 and t.position[-1, 0] == 0.02 and t.row[-1] == 1 and (np.diff(t.row) > 0).all()
    assert set(t.line.tolist()) == {5, 6}


def test_frame_0_is_the_base_and_other_groups_pass(tmp_path):
    more = "\n   GP2:\n\tUF : 0, UT : 1,\n\tJ1=   100.000  mm"
    t = read(tmp_path, program(["L P[1] 5mm/sec FINE"], pose(1, 7, uf="0", ut="F", more=more)))
    np.testing.assert_array_equal(t.setting.workobject.matrix, np.eye(4))
    assert t.position[0, 0] == 0.007
    t = read(tmp_path, program(["L P[1] 5mm/sec FINE"], pose(1, 7, more=",\n\tE1=   12.000 mm")))
    assert t.position[0, 0] == 0.007


@pytest.mark.parametrize(
    ("name", "poses", "cutting"),
    [("robodk/Program.LS", 6, 4), ("robodk_posts/Fanuc_R30iA_test_post.ls", 9, 8)],
)
def test_real_programs(shared, tmp_path, name, poses, cutting):
    path = shared / "data" / "cam" / name
    t = read_toolpath(path)
    assert len(t) == poses and t.kind.sum() == cutting and set(t.tool.tolist()) == {9}
    assert sum(e.word.startswith("CALL ") for e in t.events) == (1 if poses == 6 else 2)
    if poses == 9:
        np.testing.assert_allclose(t.position[1:3], [[0.2, 0.25, 0.348735], [0.2, 0.2, 0.262132]])
        np.testing.assert_allclose(t.setting.workobject.origin, [0.807767, -0.9637, 0.041479])
        np.testing.assert_allclose(np.degrees(t.setting.joints[0])[:3], [-46.184, -6.775, -20.549 - 6.775])
        np.testing.assert_allclose(t.feed[1:], 0.5)


def test_speeds_that_are_written_are_read(tmp_path):
    p = random_program(3000, 6)
    write_program(p, tmp_path / "p.ls")
    t = read_toolpath(tmp_path / "p.ls")
    speed = np.where(p.kind == 1, p.feed, p.rapid_speed)
    np.testing.assert_allclose(t.feed[1:], speed_texts(speed)[1], rtol=1e-12)
