"""G-code against LinuxCNC's interpreter (``rs274 -g``): every move, its kind and feed, and the arcs between."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.random_gcode import RandomProgram, joined
from toolpaths.errors import ReadError
from toolpaths.files import read_toolpath
from toolpaths.languages.table import LANGUAGES
from toolpaths.toolpath import CUT, Toolpath

pytestmark = pytest.mark.skipif(
    shutil.which("rs274") is None, reason="rs274 of LinuxCNC is missing (apt-get install linuxcnc-uspace)"
)
CALL = re.compile(r"N\S+\s+([A-Z_0-9]+)\((.*)\)\s*$")
FIRST_AXIS = {"XY": 0, "YZ": 1, "XZ": 2}
PRINTED_INCH = 4e-3  # mm: rs274 prints 4 decimals, inch blocks in inches, and shifts apart


@dataclass
class Reference:
    """What LinuxCNC would do, mm: ends (N, 3), cut (N,), feed (N,) mm/min, arcs by move."""

    ends: np.ndarray
    cut: np.ndarray
    feed: np.ndarray
    arcs: dict[int, tuple[int, np.ndarray, float]]  # normal axis, centre, turns (sign: about the axis)


def run(file: Path) -> str:
    # rs274 maps its tool table into a file in HOME: runs side by side would share it
    with tempfile.TemporaryDirectory() as home:
        done = subprocess.run(
            ["rs274", "-g", str(file.resolve())],
            capture_output=True, text=True, timeout=120, cwd=home, env={**os.environ, "HOME": home},
        )  # fmt: skip
    if done.returncode:
        raise ReadError(str(file), None, done.stderr.strip() or done.stdout[-300:])
    return done.stdout


def reference(file: Path) -> Reference:
    """The canonical calls of LinuxCNC as moves."""
    scale, plane, at, shift = 1.0, "XY", np.zeros(3), np.zeros(3)
    feed, per_turn, speed = 0.0, False, 0.0
    ends: list[np.ndarray] = []
    cut: list[bool] = []
    feeds: list[float] = []
    arcs: dict[int, tuple[int, np.ndarray, float]] = {}
    for text in run(file).splitlines():
        match = CALL.search(text)
        if match is None:
            continue
        name, arguments = match.groups()
        if name == "USE_LENGTH_UNITS":
            scale = 25.4 if "INCH" in arguments else 1.0
        elif name == "SELECT_PLANE":
            plane = arguments[-2:]
        elif name == "SET_G92_OFFSET":
            shift = np.array([float(v) for v in arguments.split(",")[:3]]) * scale
        elif name == "SET_FEED_RATE":
            feed = float(arguments) * scale
        elif name == "SET_FEED_MODE":
            per_turn = arguments.split(",")[1].strip() == "1"
        elif name == "SET_SPINDLE_SPEED":
            speed = float(arguments.split(",")[1])
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            at = np.array([float(v) for v in arguments.split(",")[:3]]) * scale + shift
            ends.append(at)
            cut.append(name == "STRAIGHT_FEED")
            feeds.append(feed * (speed if per_turn else 1.0))
        elif name == "ARC_FEED":
            u, v, cu, cv, turns, w = (float(v) for v in arguments.split(",")[:6])
            first = FIRST_AXIS[plane]
            order = [first, (first + 1) % 3, (first + 2) % 3]
            center, to = np.zeros(3), np.zeros(3)
            to[order] = np.array([u, v, w]) * scale
            center[order[:2]] = np.array([cu, cv]) * scale
            at = to + shift
            arcs[len(ends)] = order[2], center + shift, turns
            ends.append(at)
            cut.append(True)
            feeds.append(feed * (speed if per_turn else 1.0))
    return Reference(np.array(ends), np.array(cut), np.array(feeds), arcs)


def pairs(ours: np.ndarray, arcs: np.ndarray, cut: np.ndarray, ref: Reference, digits: float) -> np.ndarray:
    """(P, 2) which end of the file is which of the reference.

    A straight move to where the tool is already is none; what LinuxCNC prints of a move of few micrometres in inches
    may be none or more. Such moves may be left over on either side; before the position is known, up to three there.
    """
    same = np.abs(ref.ends[:4] - ours[0]).max(axis=1) <= digits
    assert same.any(), f"{ours[0]} is not where LinuxCNC begins: {ref.ends[:4]}"
    i, j, found = 0, int(np.argmax(same)), []

    def small(ends: np.ndarray, k: int, arc: bool) -> bool:
        return not arc and k > 0 and np.abs(ends[k] - ends[k - 1]).max() <= 2 * digits

    while i < len(ours) and j < len(ref.ends):
        arc, its_arc = bool(arcs[i]), j in ref.arcs
        alike = arc == its_arc or (its_arc and not small(ours, i, arc))  # an arc of one chord has no points
        if alike and np.abs(ours[i] - ref.ends[j]).max() <= digits and (cut[i] == ref.cut[j] or not i):
            found.append((i, j))
            i, j = i + 1, j + 1
        elif small(ours, i, arc):
            i += 1
        else:
            assert small(ref.ends, j, its_arc), f"move {i} to {ours[i]} is move {j} to {ref.ends[j]} of LinuxCNC"
            j += 1
    assert all(small(ours, k, bool(arcs[k])) for k in range(i, len(ours))), "LinuxCNC has fewer moves"
    assert all(small(ref.ends, k, k in ref.arcs) for k in range(j, len(ref.ends))), "LinuxCNC has more moves"
    return np.array(found)


def check(path: Toolpath, ref: Reference, digits: float) -> None:
    """The poses of the file are the end points; the points between lie on the arcs, in the right order."""
    poses = np.flatnonzero(path.row == np.round(path.row))
    ours = path.position * 1e3
    arcs = np.diff(poses, prepend=-1) > 1
    i, j = pairs(ours[poses], arcs, path.kind[poses] == CUT, ref, digits).T
    assert len(i) > 0.9 * len(poses) - 3
    np.testing.assert_allclose(ours[poses[i]], ref.ends[j], rtol=0, atol=digits)
    np.testing.assert_array_equal(path.kind[poses[i[1:]]] == CUT, ref.cut[j[1:]])
    cut = ref.cut[j] & (path.kind[poses[i]] == CUT)
    feed, expected = path.feed[poses[i]][cut] * 6e4, ref.feed[j][cut]
    slow = (feed < 2.55) & (expected < 2.55)  # LinuxCNC takes 0.1 a minute as the least of inverse-time feeds
    np.testing.assert_allclose(feed[~slow], expected[~slow], rtol=2e-3, atol=0.5)
    at = dict(zip(j.tolist(), i.tolist(), strict=True))
    for move, (normal, center, turns) in ref.arcs.items():
        a, b = poses[at[move] - 1], poses[at[move]]
        plane = [(normal + 1) % 3, (normal + 2) % 3]
        out = ours[a : b + 1][:, plane] - center[plane]
        radius = np.linalg.norm(out, axis=1)
        assert np.ptp(radius) < 0.02
        angle = np.unwrap(np.arctan2(out[:, 1], out[:, 0])) * np.sign(turns)
        assert (np.diff(angle) > -1e-9).all()
        sweep, whole = angle[-1] - angle[0], 2 * np.pi * (abs(turns) - 1)
        assert whole - 1e-6 < sweep < whole + 2 * np.pi + 1e-6
        sagitta = radius[:-1] * (1 - np.cos(np.diff(angle) / 2))
        assert sagitta.max() < 0.0105  # mm: the chord tolerance, and what rs274 does not print
        rise = ours[a : b + 1, normal]
        share = (angle - angle[0]) / max(sweep, 1e-9)
        expected = rise[0] + share * (rise[-1] - rise[0])
        turned = digits / radius.min() / sweep  # what printing takes from the angle
        np.testing.assert_allclose(rise, expected, rtol=0, atol=2e-3 + (1e-4 + turned) * np.ptp(rise))


REAL = [
    "gcode_fusion/1110_wall_265bit.nc", "gcode_fusion/1121_btn8copies_20bit.nc", "gcode_cncjs/tball-pocket.gcode",

    "gcode_cncjs/tball.gcode",
]  # fmt: skip
ENDED = ["jsdc", "g2-arc", "circle-inch", "arc-xy-plane", "arc-xz-plane", "arc-yz-plane", "arc-ijk"]  # no M2 in these
#: The others: what the reader says of them; rs274 refuses them, too.
REFUSED = {
    "gcode_cncjs/Circle_Diamond_Square_Calibration.gcode": (624, "the radius is 29 mm at the start, 27.5862 mm"),
    "gcode_cncjs/full-circle-without-xyz.gcode": (1, "no units"),  # and a G2 in force for a line without a centre
    "gcode_cncjs/helical-thread-milling.gcode": (4, "Z-0.6533 in G91, but where Z starts is not known"),
    "gcode_cncjs/sample.gcode": (10, "3D printers"),
    "krl_waam/Hollow_Box_cleaned.gcode": (12, "3D printers"),
    "krl_waam/circle4_cleaned.gcode": (12, "3D printers"),
}  # fmt: skip


def test_every_real_file_is_compared_or_refused_by_both(shared: Path) -> None:
    cam = shared / "data/cam"
    files = {str(f.relative_to(cam)) for f in cam.rglob("*") if f.suffix in LANGUAGES["gcode"].reads}
    assert files == {*REAL, *(f"gcode_cncjs/{name}.gcode" for name in ENDED), *REFUSED}
    for name, (line, words) in REFUSED.items():
        with pytest.raises(ReadError, match=re.escape(words)) as caught:
            read_toolpath(cam / name)
        assert caught.value.line == line, name
        with pytest.raises(ReadError):
            run(cam / name)


@pytest.mark.parametrize("name", REAL)
def test_real_files_agree(shared: Path, name: str) -> None:
    file = shared / "data/cam" / name
    check(read_toolpath(file), reference(file), 1e-4)


@pytest.mark.parametrize("name", ENDED)
def test_unfinished_real_files_agree_once_they_end(shared: Path, tmp_path: Path, name: str) -> None:
    text = (shared / "data/cam/gcode_cncjs" / f"{name}.gcode").read_text()
    head = "" if "G21" in text or "G20" in text else "G21\nG0 X0 Y0 Z0\n"
    file = tmp_path / f"{name}.nc"
    file.write_text(f"{head}{text}\nM2\n")
    check(read_toolpath(file), reference(file), PRINTED_INCH if "inch" in name else 1e-4)


PROGRAMS = int(os.environ.get("RS274_PROGRAMS", "1000"))  # docs/gcode.md has the number of the longest run
PER_FILE, PER_TEST = 10, 100


@pytest.mark.parametrize("first", range(0, PROGRAMS, PER_TEST))
def test_random_modal_programs_agree(tmp_path: Path, first: int) -> None:
    agreed = 0
    for seed in range(first, min(first + PER_TEST, PROGRAMS), PER_FILE):
        text = joined(range(seed, min(seed + PER_FILE, PROGRAMS)))
        file = tmp_path / f"random{seed}.ngc"
        file.write_text(text)
        ref = reference(file)
        check(read_toolpath(file), ref, PRINTED_INCH if "G20" in text.upper() else 1e-4)
        agreed += len(ref.ends)
    assert agreed > 75 * min(PER_TEST, PROGRAMS - first)


@pytest.mark.parametrize("change", ["G2 as G3", "G91", "a lost line", "a digit", "a feed"])
def test_a_disagreement_is_seen(tmp_path: Path, change: str) -> None:
    """What the comparison is worth: the reader gets another file than LinuxCNC."""
    text = RandomProgram(9).text  # in mm
    at = text.index("\n", len(text) // 2)
    text = f"{text[:at]}\nG80\nG94 G90 G21 G17 G91.1\nF400\nG1 X3 Y4 Z5\nG2 X7 I2\nG1 X9 Y1\nM2\n"
    other = {
        "G2 as G3": text.replace("G2 X7 I2", "G3 X7 I2"), "G91": text.replace("G94 G90 G21", "G94 G91 G21"),
        "a lost line": text.replace("G1 X3 Y4 Z5\n", ""), "a digit": text.replace("X9 Y1", "X9 Y1.0003"),
        "a feed": text.replace("F400", "F410"),
    }[change]  # fmt: skip
    files = tmp_path / "a.ngc", tmp_path / "b.ngc"
    for file, content in zip(files, (text, other), strict=True):
        file.write_text(content)
    ref = reference(files[0])
    check(read_toolpath(files[0]), ref, 1e-4)
    with pytest.raises((AssertionError, ReadError)):
        check(read_toolpath(files[1]), ref, 1e-4)
