"""Known traps of robot languages, over every language that is written: poses, angles, numbers.

What needs a reader of the language goes over READERS in tests/oracles/vendor_moves.py: a new robot language needs a
line there.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.samples import WRITTEN, to_write
from tests.oracles.sample_programs import SPINDLE, WORKOBJECT, changed, random_program, small
from tests.oracles.vendor_moves import READERS, in_base, moves_of
from toolpaths.errors import WriteError
from toolpaths.files import read_back, write_program
from toolpaths.frame import Frame
from toolpaths.tool_frame import ToolFrame
from toolpaths.toolpath import CUT


def test_every_robot_language_has_a_reader_here():
    """CSV is no robot's language; G-code is read by rs274 in its own test."""
    assert set(WRITTEN) - set(READERS) <= {"csv", "gcode"} and set(READERS) < set(WRITTEN)


# --- the whole program -------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", READERS)
@pytest.mark.parametrize("n", [1, 3, 900, 5000, 5001, 11000])
def test_what_a_controller_reads(language, n, tmp_path):
    """A third of the orientations is in gimbal lock or next to it."""
    program, sample = random_program(n, n), WRITTEN[language]
    lines = moves_of(program, to_write(tmp_path, language))
    assert len(lines) == n
    if lines[0].local is not None:
        local = np.array([line.local for line in lines])
        np.testing.assert_allclose(local[:, :3, 3], program.position * 1e3, atol=sample.position * 1e3)
        np.testing.assert_allclose(local[:, :3, :3], program.rotation, atol=sample.rotation)
    poses, wanted = np.array([line.pose for line in lines]), in_base(program)
    away = np.linalg.norm(poses[:, :3, 3] - wanted[:, :3, 3], axis=1)
    assert away.max() < max(sample.position * 1e3, 2e-4)  # mm: with what printing the work object loses
    np.testing.assert_allclose(poses[:, :3, :3], wanted[:, :3, :3], atol=min(sample.rotation + 1e-7, 1.6e-6))
    speed = np.where(program.kind == CUT, program.feed, 0.5) * 1e3
    np.testing.assert_allclose([line.speed for line in lines], speed, rtol=sample.feed)


# --- angles -----------------------------------------------------------------------------------------------


def awkward_rotations() -> np.ndarray:
    """Random ones, gimbal lock of both orders, next to it, half turns, tiny turns."""
    g = np.random.default_rng(11)
    angles = g.uniform(-180, 180, (120, 3))
    angles[:, 1] = g.choice([-90.0, 90.0], 120) + g.choice([0.0, 1e-12, 1e-9, 1e-6, 1e-4], 120) * g.normal(size=120)
    axis = g.normal(size=(60, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    turns = np.pi - g.choice([0.0, 1e-9, 1e-6], 60)
    return np.concatenate([
        Rotation.random(120, rng=g).as_matrix(),
        Rotation.from_euler("ZYX", angles, degrees=True).as_matrix(),
        Rotation.from_euler("XYZ", angles, degrees=True).as_matrix(),
        Rotation.from_rotvec(axis * turns[:, None]).as_matrix(),
        Rotation.from_rotvec(1e-7 * axis).as_matrix(),
        [np.diag(d) for d in ([1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1])],
    ])  # fmt: skip


@pytest.mark.parametrize("language", READERS)
@pytest.mark.parametrize("work", [np.eye(4), WORKOBJECT], ids=["at the base", "turned"])
def test_orientation_as_the_vendor_reads_it(language, work, tmp_path):
    """robodk's robomath turns the printed angles back into the orientation: 0.00005 deg is the coarsest print."""
    rotation = awkward_rotations()
    program = changed(random_program(len(rotation), 1), rotation=rotation, workobject=Frame.of(work))
    poses, wanted = np.array([line.pose for line in moves_of(program, to_write(tmp_path, language))]), in_base(program)
    # robodk's quaternion formula is good to 1e-8; Fanuc and KUKA print 0.00001 deg, INFORM 0.0001
    np.testing.assert_allclose(poses[:, :3, :3], wanted[:, :3, :3], atol=min(WRITTEN[language].rotation + 1e-7, 1.6e-6))


# --- numbers ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", READERS)
def test_a_position_loses_less_than_a_micrometre(language, tmp_path):
    """Far away, near zero, half way between two prints; what a controller makes of the file, in its base."""
    g = np.random.default_rng(2)
    p = random_program(400, 3)
    position = g.uniform(-2.5, 2.5, (400, 3))
    position[:100] = np.round(position[:100], 6) + g.choice([5e-7, 4.99999e-7, 5e-8], (100, 3))
    position[100:150] *= 1e-6
    p = changed(p, position=position)
    got, wanted = np.array([line.pose for line in moves_of(p, to_write(tmp_path, language))]), in_base(p)
    assert np.linalg.norm(got[:, :3, 3] - wanted[:, :3, 3], axis=1).max() < 1e-3
    back = read_back(to_write(tmp_path, language))
    assert np.linalg.norm(back.position - position, axis=1).max() < 1e-6


@pytest.mark.parametrize("language", WRITTEN)
def test_read_back_loses_less_than_a_micrometre(language, tmp_path):
    p = random_program(300, 4)
    write_program(p, to_write(tmp_path, language))
    back = read_back(to_write(tmp_path, language))
    assert np.linalg.norm(back.position - p.position, axis=1).max() < 1e-6
    told = slice(None) if WRITTEN[language].turns else slice(2, 3)  # G43.4 has the tool axis alone
    np.testing.assert_allclose(back.rotation[:, :, told], p.rotation[:, :, told], atol=1.7e-6)


@pytest.mark.parametrize("language", READERS)
def test_no_exponent_and_no_negative_zero(language, tmp_path):
    """Numbers that print as 0 from below, and tiny ones: controllers stumble over -0.000 and 1e-05."""
    n = 40
    p = random_program(n, 1, lock=False)
    tiny = np.full((n, 3), -1e-12)
    tiny[::2] = 1e-8
    joints = np.full((n, 6), -1e-12)
    rotation = Rotation.from_rotvec(tiny).as_matrix()
    little = np.full(3, -1e-12)
    tool = ToolFrame("t", Frame(Rotation.from_rotvec(100 * little).as_matrix(), little), 1e-5, little)
    work = np.eye(4)
    work[:3, 3] = -1e-12
    p = changed(p, position=tiny, joints=joints, rotation=rotation, tools={1: tool}, workobject=Frame.of(work))
    for f in write_program(p, to_write(tmp_path, language)).files:
        text = re.sub(r"!.*", "", f.read_text(encoding="ascii"))  # without remarks
        text = text.replace("9E9", "")  # ABB's word for no axis
        assert re.findall(r"(?<![\w.])-?\d+\.?\d*[eE][-+]?\d+(?!\w)", text) == []
        assert re.findall(r"(?<![\w.])-0(?:\.0*)?(?![\d.])", text) == []
        assert "nan" not in text.lower() and not re.search(r"\binf\b", text.lower())


NUMBERS = ["workobject", "start_joints", "tool xyz", "tool rotation", "tool mass", "tool com", "rapid_speed", "nominal"]


@pytest.mark.parametrize("language", WRITTEN)
@pytest.mark.parametrize("where", NUMBERS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused(language, where, value, tmp_path):
    """Poses, joints and feeds are in the suite over all writers; here everything else that carries a number."""
    p = small()
    spoilt = np.array([0.1, value, 0.2])
    if where.startswith("tool"):
        part = where.split()[1]
        frame = SPINDLE.frame
        rotated, moved = Frame(np.full((3, 3), value), frame.origin), Frame(frame.rotation, spoilt)
        new = {"mass": {"mass": value}, "com": {"com": spoilt}, "rotation": {"frame": rotated}, "xyz": {"frame": moved}}
        p = changed(p, tools={1: replace(SPINDLE, **new[part])})
    elif where == "workobject":
        frame = WORKOBJECT.copy()
        frame[1, 3] = value
        p = changed(p, workobject=Frame.of(frame))
    elif where == "start_joints":
        p = changed(p, start_joints=np.array([0.0, value, 0, 0, 0, 0]))
    elif where == "nominal":
        nominal = p.position.copy()
        nominal[5, 0] = value
        p = changed(p, nominal_position=nominal)
    else:
        p = changed(p, rapid_speed=value)
    with pytest.raises(WriteError, match=r"not a finite number|not above 0"):
        write_program(p, to_write(tmp_path, language))
    assert list(tmp_path.iterdir()) == []
