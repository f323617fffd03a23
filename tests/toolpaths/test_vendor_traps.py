"""Known traps of robot languages, over every language that is written.

Numbers and refusals go over all of them; what needs a reader of the language (names, zones, tools, angles) goes over
READERS in tests/oracles/vendor_moves.py: a new robot language needs a line there.
"""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.oracles.sample_programs import SPINDLE, WORKOBJECT, changed, random_program, small
from tests.oracles.vendor_moves import READERS
from toolpaths.errors import WriteError
from toolpaths.files import read_back, write_program
from toolpaths.finding import ERROR, WARNING, Finding, merged
from toolpaths.frame import Frame
from toolpaths.languages import table
from toolpaths.tool_frame import ToolFrame

SUFFIX = {language.name: language.writes for language in table.WRITTEN}
WRITTEN = sorted(SUFFIX)
ROBOTS = [name for name in WRITTEN if name in READERS]

#: Languages whose rounding is the controller's own choice: they are told to stand or to pass.
CHOOSE = {"fanuc", "inform"}

#: Lines that 5,000 moves take (URScript: 2,500), with positions and changes of speed and rounding.
MOST_LINES = {"rapid": 5100, "krl": 12000, "fanuc": 36000, "urscript": 2600, "val3": 5100, "inform": 16000}


def target(folder, language, stem="part1"):
    return folder / f"{stem}{SUFFIX[language]}"


def read(program, folder, language):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        written = write_program(program, target(folder, language))
    return READERS[language](list(written.files))


def in_base(program) -> np.ndarray:
    poses = np.tile(np.eye(4), (len(program), 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = program.rotation, program.position
    poses = program.workobject.matrix @ poses
    poses[:, :3, 3] *= 1e3
    return poses


def test_every_robot_language_has_a_reader_here():
    """CSV is no robot's language; G-code is read by rs274 in its own test."""
    assert set(WRITTEN) - set(READERS) <= {"csv", "gcode"}


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


@pytest.mark.parametrize("language", ROBOTS)
@pytest.mark.parametrize("work", [np.eye(4), WORKOBJECT], ids=["at the base", "turned"])
def test_orientation_as_the_vendor_reads_it(language, work, tmp_path):
    """robodk's robomath turns the printed angles back into the orientation: 0.00005 deg is the coarsest print."""
    rotation = awkward_rotations()
    program = changed(random_program(len(rotation), 1), rotation=rotation, workobject=Frame.of(work))
    poses, wanted = np.array([line.pose for line in read(program, tmp_path, language)]), in_base(program)
    # robodk's quaternion formula is good to 1e-8; Fanuc and KUKA print 0.00001 deg, INFORM 0.0001
    np.testing.assert_allclose(poses[:, :3, :3], wanted[:, :3, :3], atol=1.6e-6 if language == "inform" else 4e-7)


# --- numbers ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", ROBOTS)
def test_a_position_loses_less_than_a_micrometre(language, tmp_path):
    """Far away, near zero, half way between two prints; what a controller makes of the file, in its base."""
    g = np.random.default_rng(2)
    p = random_program(400, 3)
    position = g.uniform(-2.5, 2.5, (400, 3))
    position[:100] = np.round(position[:100], 6) + g.choice([5e-7, 4.99999e-7, 5e-8], (100, 3))
    position[100:150] *= 1e-6
    p = changed(p, position=position)
    got, wanted = np.array([line.pose for line in read(p, tmp_path, language)]), in_base(p)
    assert np.linalg.norm(got[:, :3, 3] - wanted[:, :3, 3], axis=1).max() < 1e-3
    back = read_back(target(tmp_path, language))
    assert np.linalg.norm(back.position - position, axis=1).max() < 1e-6


@pytest.mark.parametrize("language", WRITTEN)
def test_read_back_loses_less_than_a_micrometre(language, tmp_path):
    p = random_program(300, 4)
    write_program(p, target(tmp_path, language))
    back = read_back(target(tmp_path, language))
    assert np.linalg.norm(back.position - p.position, axis=1).max() < 1e-6
    told = slice(2, 3) if language == "gcode" else slice(None)  # G43.4 says the tool axis alone
    np.testing.assert_allclose(back.rotation[:, :, told], p.rotation[:, :, told], atol=1.7e-6)


@pytest.mark.parametrize("language", ROBOTS)
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
    for f in write_program(p, target(tmp_path, language)).files:
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
        write_program(p, target(tmp_path, language))
    assert list(tmp_path.iterdir()) == []


# --- speeds -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", ROBOTS)
def test_units_of_speed(language, tmp_path):
    """A feed in m/s arrives in mm/s within 1 %, or a finding names the first pose where it does not."""
    feed = np.geomspace(2e-4, 1.4, 60)
    p = changed(random_program(60, 1), kind=np.ones(60, dtype=np.uint8), feed=feed)
    written = write_program(p, target(tmp_path, language))
    speed = np.array([line.speed for line in READERS[language](list(written.files))])
    off = np.abs(speed / (feed * 1e3) - 1.0)
    said = [f for f in written.findings if "feed" in f.what]
    assert off.max() < 1e-4 or (len(said) >= 1 and said[0].level == WARNING)
    assert off[feed > 0.01].max() < 0.01


# --- zones ------------------------------------------------------------------------------------------------


def zigzag(n: int, seed: int):
    """Steps from 1 um to 10 mm in all directions."""
    p = random_program(n, seed, lock=False)
    scale = 10.0 ** np.random.default_rng(seed).uniform(-3, 1, n)
    step = np.random.default_rng(seed + 1).normal(size=(n, 3)) * scale[:, None] * 1e-3
    return changed(p, position=np.cumsum(step, axis=0), rotation=np.tile(np.eye(3), (n, 1, 1)))


@pytest.mark.parametrize("language", sorted(set(ROBOTS) - CHOOSE))
def test_zones_end_within_half_a_segment(language, tmp_path):
    lines = read(zigzag(1500, 5), tmp_path, language)
    at = np.array([line.pose[:3, 3] for line in lines])
    reach = np.array([line.reach for line in lines])
    shorter = np.minimum(*(np.linalg.norm(np.diff(at, axis=0), axis=1)[s] for s in (slice(None, -1), slice(1, None))))
    moving = shorter > 0.0102  # shorter ones are turns on the spot
    assert (reach[1:-1] <= 0.5 * shorter + 1.5e-4)[moving].all() and moving.mean() > 0.5
    assert (reach > 0).mean() > 0.3 and reach[0] == reach[-1] == 0.0


@pytest.mark.parametrize("language", sorted(CHOOSE & set(ROBOTS)))
def test_where_the_controller_chooses_the_zone_sharp_corners_stand(language, tmp_path):
    """A corner of 90 deg between 10 mm lines may be missed by 0.01 mm only: no passing there; on a line it may pass."""
    n = 12
    p = random_program(n, 1, lock=False)
    corner = np.array([(10 * (i // 2 + i % 2), 10 * (i // 2), 0) for i in range(n)]) * 1e-3
    straight = np.array([(10 * i, 0, 0) for i in range(n)]) * 1e-3
    for name, xyz, passes in (("corner", corner, 0), ("straight", straight, n - 2)):
        (tmp_path / name).mkdir()
        q = changed(
            p, position=xyz, rotation=np.tile(np.eye(3), (n, 1, 1)),
            kind=np.ones(n, dtype=np.uint8), feed=np.full(n, 0.02),
        )  # fmt: skip
        reach = [line.reach for line in read(q, tmp_path / name, language)]
        assert sum(map(math.isnan, reach)) == passes and reach[0] == reach[-1] == 0.0


@pytest.mark.parametrize("language", ROBOTS)
def test_exact_poses_stand(language, tmp_path):
    p = random_program(200, 9, lock=False)
    exact = np.zeros(200, dtype=bool)
    exact[20:200:17] = True
    xyz = np.column_stack((np.arange(200) * 1e-3, np.zeros(200), np.zeros(200)))
    lines = read(changed(p, position=xyz, exact=exact), tmp_path, language)
    assert [line.reach == 0.0 for line in lines] == [bool(e) or i in (0, 199) for i, e in enumerate(exact)]


# --- tools ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", ROBOTS)
def test_several_tools_in_one_program(language, tmp_path):
    """Every pose has its own tool, the arm stands on both sides of a change, also when a tool comes back."""
    turn = Rotation.from_euler("xyz", [20, -40, 70], degrees=True).as_matrix()
    tools = {
        1: SPINDLE,
        7: ToolFrame("b", Frame(turn, np.array([0.0, 0.1, 0.3])), 3.0, np.array([0.0, 0.0, 0.1])),
        12: ToolFrame("c", Frame(turn.T, np.array([-0.05, 0.0, 0.2])), 2.0, np.array([0.0, 0.0, 0.1])),
    }
    numbers = np.repeat([1, 7, 12, 7], 10).astype(np.int32)
    xyz = np.column_stack((np.arange(40) * 1e-3, np.zeros(40), np.zeros(40)))
    program = changed(random_program(40, 6), tools=tools, tool=numbers, position=xyz)
    lines = read(program, tmp_path, language)
    for line, n in zip(lines, numbers.tolist(), strict=True):
        if isinstance(line.tool, int):
            assert line.tool == n
        else:
            np.testing.assert_allclose(line.tool[:3, 3], tools[n].frame.origin * 1e3, atol=1e-4)
            np.testing.assert_allclose(line.tool[:3, :3], tools[n].frame.rotation, atol=4e-7)
    assert [k for k in range(40) if lines[k].reach == 0.0] == [0, 9, 10, 19, 20, 29, 30, 39]


# --- names and characters ---------------------------------------------------------------------------------

NAMES = [
    "1110_wall", "a-b", "a b", "größe", "a" * 40, "a" * 300, "", "_", "if", "LIN", "MoveL", "END", "main", "tool",
    "a;b", 'a"b', "a'b", "a\nb", "a\\b", "a/b", "]]>", "名前", "a" * 24, "A.B",
]  # fmt: skip


@pytest.mark.parametrize("language", ROBOTS)
@pytest.mark.parametrize("name", NAMES)
def test_program_names_become_legal_or_are_refused(language, name, tmp_path):
    """The reader of the language takes what is written, or the finding says which name and what to do."""
    p = changed(small(), name=name)
    try:
        assert len(read(p, tmp_path, language)) == 8
    except WriteError as e:
        assert "name" in str(e) and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("language", ROBOTS)
@pytest.mark.parametrize("stem", [n for n in NAMES if n and "/" not in n and "\n" not in n and len(n) < 200])
def test_file_names_are_legal_or_are_refused(language, stem, tmp_path):
    try:
        written = write_program(small(), target(tmp_path, language, stem))
    except WriteError as e:
        assert f"{stem}{SUFFIX[language]}" in str(e) and "name" in str(e) and list(tmp_path.iterdir()) == []
    else:
        assert len(READERS[language](list(written.files))) == 8


@pytest.mark.parametrize("language", ROBOTS)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(max_size=120), other=st.text(max_size=60))
def test_texts_cannot_become_instructions(language, text, other, tmp_path):
    """Whatever stands in a comment, a source's, a robot's or a tool's name: the moves are the same eight."""
    program = changed(
        small(), comments=((0, text), (4, other)), source=other, robot=text, tools={1: replace(SPINDLE, name=text)}
    )
    assert len(read(program, tmp_path, language)) == 8


HOSTILE = [
    "x\r\nHALT\r\nEND", 'x"); movel(p', "]]></Code>", "'\r\nPAUSE", "! x\nStop;", "; x\nLIN {X 0}", "end\nmovel(",
    "\x00\x1a", ";\n   1:L P[1] 10mm/sec FINE", "%s %d {0}", "\\", "\u2028END", "*/", "-->",
]  # fmt: skip


@pytest.mark.parametrize("language", ROBOTS)
@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts(language, text, tmp_path):
    program = changed(
        small(), comments=((0, text), (4, text)), source=text, robot=text, tools={1: replace(SPINDLE, name=text)}
    )
    assert len(read(program, tmp_path, language)) == 8


# --- sizes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", ROBOTS)
def test_long_programs_are_split_and_complete(language, tmp_path):
    """No file is longer than its controller takes; every move is there once, in order."""
    p = random_program(11000, 12, lock=False)
    written = write_program(p, target(tmp_path, language))
    assert len(written.files) > 2
    got = np.array([line.pose[:3, 3] for line in READERS[language](list(written.files))])
    np.testing.assert_allclose(got, in_base(p)[:, :3, 3], atol=0.51e-3)
    for f in written.files:
        if f.suffix != ".dtx":  # one data base for all parts; its arrays are as long as the parts
            assert f.read_bytes().count(b"\n") <= MOST_LINES[language], f.name


# --- findings ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", WRITTEN)
def test_one_error_refuses_the_whole_program(language, tmp_path):
    """Everything is listed: errors first, each with level, place and remedy, repeats as one."""
    said = (
        Finding(WARNING, "pose 1 (a.nc:2)", "close to a limit", "move the part"),
        Finding(ERROR, "pose 3 (a.nc:4)", "not reached", "move the part"),
        Finding(ERROR, "pose 5 (a.nc:6)", "not reached", "move the part", 2),
        Finding(ERROR, "tool 1", "not mounted"),
    )
    old = target(tmp_path, language)
    old.write_bytes(b"what was there")
    with pytest.raises(WriteError) as caught:
        write_program(changed(small(), findings=said), old)
    lines = str(caught.value).split("\n  ")
    assert lines[0].endswith("the program is refused:")
    assert lines[1] == "error: pose 3 (a.nc:4) (and 2 more places): not reached. move the part"
    assert lines[2] == "error: tool 1: not mounted"
    assert lines[3] == "warning: pose 1 (a.nc:2): close to a limit. move the part"
    assert {f.name: f.read_bytes() for f in tmp_path.iterdir()} == {old.name: b"what was there"}


@pytest.mark.parametrize("language", WRITTEN)
def test_warnings_do_not_refuse_and_come_back(language, tmp_path):
    said = (Finding(WARNING, "pose 1", "close", "look"), Finding(WARNING, "pose 2", "close", "look"))
    found = write_program(changed(small(), findings=said), target(tmp_path, language)).findings
    assert Finding(WARNING, "pose 1", "close", "look", 2) in found
    assert all(f.level == WARNING and f.place and f.what for f in found)


@pytest.mark.parametrize("language", ROBOTS)
def test_a_language_s_own_errors_are_listed_with_a_remedy(language, tmp_path):
    with pytest.raises(WriteError, match=r"error: a robot: 7 joints: .*\. write CSV for this arm"):
        write_program(changed(small(), joints=np.zeros((8, 7)), start_joints=None), target(tmp_path, language))
    assert list(tmp_path.iterdir()) == []


def test_merging_keeps_levels_and_remedies_apart():
    a, b = Finding(ERROR, "pose 9", "x", "do"), Finding(WARNING, "pose 2", "x", "do")
    c = Finding(ERROR, "pose 4", "x", "do otherwise")
    assert merged([b, a, c, a, b, a]) == (replace(a, count=3), c, replace(b, count=2))
    far = merged([*merged([a, replace(a, place="pose 3")]), a, replace(a, place="pose 20")])
    assert far == (replace(a, count=4),) and far[0].places == ("pose 9", "pose 3", "pose 20")
