"""Known traps of robot languages, over every language that is written: speeds, zones, tools, sizes.

What needs a reader of the language goes over READERS in tests/oracles/vendor_moves.py: a new robot language needs a
line there.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contracts.samples import WRITTEN, to_write
from tests.oracles.sample_programs import SPINDLE, changed, random_program, small
from tests.oracles.vendor_moves import OTHER, READERS, in_base, moves_of
from toolpaths.errors import WriteError
from toolpaths.files import write_program
from toolpaths.finding import WARNING
from toolpaths.frame import Frame
from toolpaths.languages.table import LANGUAGES
from toolpaths.tool_frame import ToolFrame

# --- speeds -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", READERS)
def test_units_of_speed(language, tmp_path):
    """A feed in m/s arrives in mm/s within 1 %, or a finding names the first pose where it does not."""
    feed = np.geomspace(2e-4, 1.4, 60)
    p = changed(random_program(60, 1), kind=np.ones(60, dtype=np.uint8), feed=feed)
    written = write_program(p, to_write(tmp_path, language))
    speed = np.array([line.speed for line in READERS[language](list(written.files))])
    off = np.abs(speed / (feed * 1e3) - 1.0)
    said = [f for f in written.findings if "feed" in f.what]
    assert off.max() < 1e-4 or (len(said) >= 1 and said[0].level == WARNING)
    assert off[feed > 0.01].max() < 0.01


@pytest.mark.parametrize("language", [name for name, sample in WRITTEN.items() if sample.fastest])
def test_speeds_that_the_controller_does_not_take(language, tmp_path):
    p, words = small(), WRITTEN[language].fastest
    speed = float(re.findall(r"[\d.]+", words)[0]) * (1e-3 if "mm/s" in words else 1.0) + 0.5
    feed = p.feed.copy()
    feed[3] = speed
    with pytest.raises(WriteError, match=rf"pose 3 \(part.nc:13\): faster than {words}"):
        write_program(changed(p, feed=feed), to_write(tmp_path, language))
    with pytest.raises(WriteError, match=f"rapid speed: faster than {words}"):
        write_program(changed(p, rapid_speed=speed), to_write(tmp_path, language))
    assert list(tmp_path.iterdir()) == []


# --- zones ------------------------------------------------------------------------------------------------


def zigzag(n: int, seed: int):
    """Steps from 1 um to 10 mm in all directions."""
    p = random_program(n, seed, lock=False)
    scale = 10.0 ** np.random.default_rng(seed).uniform(-3, 1, n)
    step = np.random.default_rng(seed + 1).normal(size=(n, 3)) * scale[:, None] * 1e-3
    return changed(p, position=np.cumsum(step, axis=0), rotation=np.tile(np.eye(3), (n, 1, 1)))


@pytest.mark.parametrize("language", [name for name in READERS if not WRITTEN[name].stands_or_passes])
def test_zones_end_within_half_a_segment(language, tmp_path):
    lines = moves_of(zigzag(1500, 5), to_write(tmp_path, language))
    at = np.array([line.pose[:3, 3] for line in lines])
    reach = np.array([line.reach for line in lines])
    shorter = np.minimum(*(np.linalg.norm(np.diff(at, axis=0), axis=1)[s] for s in (slice(None, -1), slice(1, None))))
    moving = shorter > 0.0102  # shorter ones are turns on the spot
    assert (reach[1:-1] <= 0.5 * shorter + 1.5e-4)[moving].all() and moving.mean() > 0.5
    assert (reach > 0).mean() > 0.3 and len(set(reach)) >= 6 and reach[0] == reach[-1] == 0.0


@pytest.mark.parametrize("language", [name for name in READERS if WRITTEN[name].stands_or_passes])
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
        reach = [line.reach for line in moves_of(q, to_write(tmp_path / name, language))]
        assert sum(map(math.isnan, reach)) == passes and reach[0] == reach[-1] == 0.0


@pytest.mark.parametrize("language", READERS)
def test_exact_poses_stand(language, tmp_path):
    p = random_program(200, 9, lock=False)
    exact = np.zeros(200, dtype=bool)
    exact[20:200:17] = True
    xyz = np.column_stack((np.arange(200) * 1e-3, np.zeros(200), np.zeros(200)))
    lines = moves_of(changed(p, position=xyz, exact=exact), to_write(tmp_path, language))
    assert [line.reach == 0.0 for line in lines] == [bool(e) or i in (0, 199) for i, e in enumerate(exact)]


# --- tools ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", READERS)
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
    lines = moves_of(program, to_write(tmp_path, language))
    for line, n in zip(lines, numbers.tolist(), strict=True):
        if isinstance(line.tool, int):
            assert line.tool == n
        else:
            np.testing.assert_allclose(line.tool[:3, 3], tools[n].frame.origin * 1e3, atol=1e-4)
            np.testing.assert_allclose(line.tool[:3, :3], tools[n].frame.rotation, atol=4e-7)
    assert [k for k in range(40) if lines[k].reach == 0.0] == [0, 9, 10, 19, 20, 29, 30, 39]
    files = sorted(tmp_path.glob(f"part1*{LANGUAGES[language].writes}"))
    (tmp_path / "one").mkdir()
    one = write_program(changed(program, tool=np.ones(40, dtype=np.int32)), to_write(tmp_path / "one", language))
    assert len(OTHER[language](files)) == 3 + len(OTHER[language](list(one.files)))  # it waits for each change


# --- sizes ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("language", READERS)
def test_long_programs_are_split_and_complete(language, tmp_path):
    """No file is longer than its controller takes; every move is there once, in order."""
    p = random_program(11000, 12, lock=False)
    written = write_program(p, to_write(tmp_path, language))
    assert len(written.files) > 2
    got = np.array([line.pose[:3, 3] for line in READERS[language](list(written.files))])
    np.testing.assert_allclose(got, in_base(p)[:, :3, 3], atol=0.51e-3)
    for f in written.files:
        if f.suffix != ".dtx":  # one data base for all parts; its arrays are as long as the parts
            assert f.read_bytes().count(b"\n") <= WRITTEN[language].most_lines, f.name
